// SPDX-License-Identifier: LGPL-2.1-or-later
#include "law_check.h"

#include <feib/archive.h>
#include <feib/error.h>

#include <deal.II/base/symmetric_tensor.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <optional>
#include <random>
#include <sstream>

namespace feib
{
  namespace
  {
    template <int dim>
    double
    norm(const NodalField<dim> &a)
    {
      return std::sqrt(a * a);
    }

    template <int dim>
    bool
    finite(const NodalField<dim> &field)
    {
      return std::isfinite(norm(field));
    }

    template <int dim>
    Positions<dim>
    moved(Positions<dim> X, const NodalField<dim> &V, const double h)
    {
      for (unsigned int i = 0; i < X.size(); ++i)
        X[i] += h * V[i];
      return X;
    }

    std::string
    number(const double value)
    {
      std::ostringstream text;
      text << std::setprecision(4) << value;
      return text.str();
    }

    std::string
    factor(const double value)
    {
      std::ostringstream text;
      text << std::fixed << std::setprecision(3) << value;
      return text.str();
    }


    /// The state near the start that a structure is tried at, and how.
    template <int dim>
    class LawCheck
    {
    public:
      LawCheck(StructureModel<dim> &model, const Parameters &slot);

      void finite_at_start() const;
      void measure_noise();
      void stress() const;
      void derivative() const;
      void rotation() const;
      void growth() const;
      void viscosity() const;
      void state() const;

      /// Throws the sentence at the law.
      [[noreturn]] void fail(const std::string &sentence) const;

    private:
      /// The same, with law and structure in front.
      [[noreturn]] void refuse(const std::string &problem) const;

      /// For each node the smallest height of the elements there, so that displacements by a part
      /// of it neither invert an element nor vanish beside it.
      std::vector<double> heights() const;

      /// A displacement of up to one height in each direction.
      NodalField<dim> random_displacement(unsigned int seed) const;

      NodalField<dim>
      load(const Positions<dim> &X) const
      {
        NodalField<dim> result;
        model.load(X, result);
        return result;
      }

      /// The viscous load at X for the nodes' velocities U.
      NodalField<dim>
      viscous_load(const NodalField<dim> &U) const
      {
        NodalField<dim> result;
        model.viscous_load(X, U, result);
        return result;
      }

      /// What the load points do when the nodes move by V.
      NodalField<dim>
      at_points(const NodalField<dim> &V) const
      {
        const Positions<dim> x =
          model.load_points().positions(moved(Positions<dim>(V.size()), V, 1.));
        return {x.begin(), x.end()};
      }

      /// The energy of an affine image of the start; nothing where it is not defined.
      std::optional<double> energy_of(const dealii::Tensor<2, dim> &map) const;

      StructureModel<dim> &model; // as it was, after each of these
      const Parameters block;
      std::string law; // its name; "" when the structure has no such slot
      std::vector<double> node_heights;
      Positions<dim> X;      // the start, shaken: there laws are smooth
      double noise      = 0; // round-off of the energy near X
      double load_noise = 0; // and, as a norm, of the load
    };


    template <int dim>
    LawCheck<dim>::LawCheck(StructureModel<dim> &model, const Parameters &slot)
      : model(model)
      , block(slot.choice().second)
      , law(block.has("law") ? block.child("law").choice().first : "")
      , node_heights(heights())
      , X(moved(model.positions, random_displacement(1), .02))
    {}


    template <int dim>
    void
    LawCheck<dim>::measure_noise()
    {
      // Second differences too short for a second derivative to show.
      constexpr double h       = 1e-9;
      const double energy      = model.energy(X);
      const NodalField<dim> at = load(X);
      for (const unsigned int seed : {8, 9, 10})
        {
          const NodalField<dim> V  = random_displacement(seed);
          const Positions<dim> one = moved(X, V, h), other = moved(X, V, -h);
          noise = std::max(noise, std::abs(model.energy(one) - 2 * energy + model.energy(other)));
          if (seed > 8)
            continue;
          NodalField<dim> second   = load(one);
          const NodalField<dim> by = load(other);
          for (unsigned int q = 0; q < second.size(); ++q)
            second[q] += by[q] - 2. * at[q];
          load_noise = norm(second);
        }
    }


    template <int dim>
    void
    LawCheck<dim>::refuse(const std::string &problem) const
    {
      fail((law.empty() ? "" : "the law \"" + law + "\" of ") + ("structure \"" + model.name()) +
           "\" is wrong: " + problem);
    }


    template <int dim>
    void
    LawCheck<dim>::fail(const std::string &sentence) const
    {
      block.fail(law.empty() ? "" : "law", sentence);
    }


    template <int dim>
    std::vector<double>
    LawCheck<dim>::heights() const
    {
      const unsigned int m = model.mesh().structure_dim();
      std::vector<double> result(model.mesh().n_nodes(), std::numeric_limits<double>::infinity());
      for (const auto &element : model.mesh().elements())
        {
          // The edges, made orthogonal one after the other, for each node as the last one.
          double smallest = std::numeric_limits<double>::infinity();
          for (unsigned int k = 0; k <= m; ++k)
            {
              std::array<dealii::Tensor<1, dim>, dim> edges;
              for (unsigned int l = 1; l <= m; ++l)
                {
                  dealii::Tensor<1, dim> &edge = edges[l - 1];
                  edge = model.positions[element.nodes[(k + 1 + l) % (m + 1)]] -
                         model.positions[element.nodes[(k + 1) % (m + 1)]];
                  for (unsigned int j = 0; j + 1 < l; ++j)
                    if (edges[j].norm_square() > 0)
                      edge -= (edge * edges[j]) / edges[j].norm_square() * edges[j];
                }
              smallest = std::min(smallest, edges[m - 1].norm());
            }
          for (unsigned int k = 0; k <= m; ++k)
            result[element.nodes[k]] = std::min(result[element.nodes[k]], smallest);
        }
      return result;
    }


    template <int dim>
    NodalField<dim>
    LawCheck<dim>::random_displacement(const unsigned int seed) const
    {
      std::mt19937 generator(seed); // its numbers are the same everywhere
      NodalField<dim> result(model.mesh().n_nodes());
      for (unsigned int i = 0; i < result.size(); ++i)
        for (unsigned int a = 0; a < dim; ++a)
          result[i][a] = node_heights[i] * (2. * generator() / generator.max() - 1);
      return result;
    }


    template <int dim>
    void
    LawCheck<dim>::finite_at_start() const
    {
      // Structures throw when something is not.
      model.energy_density(model.positions);
      load(model.positions);
      NodalField<dim> dload;
      model.load_derivative(model.positions, random_displacement(2), dload);
    }


    template <int dim>
    void
    LawCheck<dim>::stress() const
    {
      const NodalField<dim> f     = load(X);
      double size                 = 0; // of the energies that are subtracted
      const std::vector<double> W = model.energy_density(X);
      for (unsigned int e = 0; e < W.size(); ++e)
        size += std::abs(W[e]) * model.mesh().elements()[e].measure;
      double least = std::numeric_limits<double>::infinity(), largest = -least;
      bool wrong = false;
      for (const unsigned int seed : {3, 4, 5})
        {
          NodalField<dim> V = random_displacement(seed);
          // Without the load of its boundary faces a load is the derivative elsewhere.
          if (!model.conservative())
            for (const auto &face : model.mesh().faces())
              for (unsigned int k = 0; face.at_boundary() && k < model.mesh().structure_dim(); ++k)
                V[face.nodes[k]] = dealii::Tensor<1, dim>();
          const NodalField<dim> v = at_points(V);
          const double work       = f * v;
          double scale            = 0;
          for (unsigned int q = 0; q < f.size(); ++q)
            scale += f[q].norm() * v[q].norm();

          // The shorter difference is for laws with kinks: few elements pass one then.
          double released = 0;
          bool agrees     = false;
          for (const double h : {1e-4, 1e-6})
            {
              released = (model.energy(moved(X, V, -h)) - model.energy(moved(X, V, h))) / (2 * h);
              agrees   = std::abs(work - released) <= 1e-5 * std::max(scale, std::abs(released)) +
                                                      (1e-14 * size + 100 * noise) / h;
              if (agrees)
                break;
            }
          wrong = wrong || !agrees;
          if (scale > 0 || released != 0)
            {
              least   = std::min(least, work / released);
              largest = std::max(largest, work / released);
            }
        }
      if (!wrong)
        return;
      // No factor, but round-off or nothing: the work of a constant stress on a closed curve.
      const bool no_work = std::max(std::abs(least), std::abs(largest)) < 1e-10;
      if (std::isfinite(least) && !no_work && largest - least <= 1e-3 * std::abs(largest))
        refuse("its stress is " + factor((least + largest) / 2) + " times dW/dF");
      if (!std::isfinite(least) || !std::isfinite(largest))
        refuse("its stress is not dW/dF: its energy does not change where its stress does work");
      refuse("its stress is not dW/dF: along random displacements its work is " + factor(least) +
             " to " + factor(largest) + " times what the energy releases");
    }


    template <int dim>
    void
    LawCheck<dim>::derivative() const
    {
      const NodalField<dim> V = random_displacement(6);
      NodalField<dim> given, changed;
      model.load_derivative(X, V, given);
      // Beside a kink of the law the shorter differences say what its derivative is.
      double error = 0, scale = 0;
      for (const double h : {1e-4, 1e-6, 1e-8})
        {
          changed                     = load(moved(X, V, h));
          const NodalField<dim> other = load(moved(X, V, -h));
          NodalField<dim> difference  = given;
          for (unsigned int q = 0; q < changed.size(); ++q)
            {
              changed[q] = (changed[q] - other[q]) / (2 * h);
              difference[q] -= changed[q];
            }
          error = norm(difference);
          scale = 1e-3 * std::max(norm(changed), norm(given)) +
                  (1e-14 * norm(other) + 100 * load_noise) / h;
          if (error <= scale)
            break;
        }
      if (!(error <= scale))
        {
          if (norm(given) == 0)
            refuse("the derivative of its stress is zero, where its stress changes");
          const double ratio = (given * changed) / (changed * changed);
          double rest        = 0;
          for (unsigned int q = 0; q < given.size(); ++q)
            rest += (given[q] - ratio * changed[q]).norm_square();
          if (std::sqrt(rest) <= 1e-3 * norm(given))
            refuse("the derivative of its stress is given as " + factor(ratio) +
                   " times what differences of the stress say");
          refuse("the derivative of its stress is not what differences of the stress say: it is "
                 "off by " +
                 factor(100 * error / norm(changed)) + " %");
        }
      if (!model.linear())
        return;
      NodalField<dim> at_start;
      model.load_derivative(moved(X, random_displacement(7), .05), V, at_start);
      for (unsigned int q = 0; q < given.size(); ++q)
        at_start[q] -= given[q];
      if (norm(at_start) > 1e-9 * norm(given))
        refuse("it says that its stress is linear in F, but the derivative changes with F");
    }


    template <int dim>
    void
    LawCheck<dim>::rotation() const
    {
      const dealii::Tensor<2, dim> identity = dealii::unit_symmetric_tensor<dim>();
      const double c = std::cos(.7), s = std::sin(.7);
      for (unsigned int a = 0; a < (dim == 2 ? 1 : 2); ++a)
        {
          dealii::Tensor<2, dim> Q = identity;
          Q[a][a] = Q[a + 1][a + 1] = c;
          Q[a][a + 1]               = -s;
          Q[a + 1][a]               = s;
          Positions<dim> turned     = X;
          for (auto &x : turned)
            x = X[0] + Q * (x - X[0]);
          const double before = model.energy(X), after = model.energy(turned);
          if (!(std::abs(after - before) <=
                1e-6 * std::max(std::abs(after), std::abs(before)) + 1e6 * noise))
            refuse("its energy changes from " + number(before) + " to " + number(after) +
                   " when the structure is turned as a whole");
        }
    }


    template <int dim>
    std::optional<double>
    LawCheck<dim>::energy_of(const dealii::Tensor<2, dim> &map) const
    {
      Positions<dim> image = model.positions;
      for (auto &x : image)
        x = model.positions[0] + map * (x - model.positions[0]);
      try
        {
          const double energy = model.energy(image);
          return std::isfinite(energy) ? std::optional<double>(energy) : std::nullopt;
        }
      catch (const RunFailure &)
        {
          return std::nullopt;
        }
    }


    template <int dim>
    void
    LawCheck<dim>::growth() const
    {
      // A law with any sense resists some of these; they keep areas and volumes, but for the last.
      const dealii::Tensor<2, dim> identity = dealii::unit_symmetric_tensor<dim>();
      const double start                    = model.energy(model.positions);
      std::optional<double> fallen;
      // Some laws have no energy far away; some structures are squeezed, and soften until they have
      // their size again.
      double reference = 0, present = 0;
      for (const auto &element : model.mesh().elements())
        {
          reference += element.measure;
          present += model.mesh().measure(element, model.positions);
        }
      const double size =
        std::max(1., std::pow(reference / present, 1. / model.mesh().structure_dim()));
      for (const double stretch : {8. * size, 3. * size, 1.1 * size})
        {
          for (unsigned int a = 0; a < dim; ++a)
            {
              dealii::Tensor<2, dim> map = identity;
              for (unsigned int b = 0; b < dim; ++b)
                map[b][b] = b == a ? stretch : std::pow(stretch, -1. / (dim - 1));
              const std::optional<double> energy = energy_of(map);
              if (!energy)
                continue;
              if (*energy >= start - 1e-3 * std::abs(start) - 1e6 * noise)
                return;
              fallen = energy;
            }
          if (fallen)
            refuse("its energy falls, from " + number(start) + " to " + number(*fallen) +
                   ", when the structure is stretched " + number(stretch) +
                   " times, along whatever axis; are energy and stress negative?");
        }
    }


    template <int dim>
    void
    LawCheck<dim>::viscosity() const
    {
      const NodalField<dim> U = random_displacement(11), V = random_displacement(12);
      const NodalField<dim> f = viscous_load(U), g = viscous_load(V);
      const double size      = norm(f) * norm(at_points(U)) + norm(g) * norm(at_points(V));
      const double tolerated = 1e-9 * size;
      NodalField<dim> sum    = U, rest;
      for (unsigned int i = 0; i < U.size(); ++i)
        sum[i] += 2. * V[i];
      rest = viscous_load(sum);
      for (unsigned int q = 0; q < f.size(); ++q)
        rest[q] -= f[q] + 2. * g[q];
      if (norm(rest) > 1e-9 * (norm(f) + norm(g)))
        refuse("its viscous stress is not linear in dF/dt");
      // Without the load of its boundary faces, or with Gauss points, powers are others.
      if (!model.conservative())
        return;
      if (f * at_points(U) > tolerated)
        refuse("its viscous stress drives the structure instead of damping it; is its sign wrong?");
      if (std::abs(f * at_points(V) - g * at_points(U)) > tolerated)
        refuse("its viscous stress has no dissipation potential: P(A) : B is not P(B) : A");
      NodalField<dim> turning(U.size());
      for (unsigned int i = 0; i < U.size(); ++i)
        {
          turning[i][0] = -(X[i][1] - X[0][1]);
          turning[i][1] = X[i][0] - X[0][0];
        }
      double speed = 0;
      for (unsigned int i = 0; i < U.size(); ++i)
        speed = std::max(speed, turning[i].norm() / node_heights[i]);
      if (norm(viscous_load(turning)) > 1e-9 * speed * norm(f))
        refuse("its viscous stress resists when the structure is turned as a whole");
    }


    template <int dim>
    void
    LawCheck<dim>::state() const
    {
      MemoryArchive before;
      before("structure", model);
      for (const Positions<dim> &end : {model.positions, X})
        {
          // The end of a short step; structures throw when the state is none.
          model.set_moment(0., 1e-6);
          const double held = model.energy(end);
          model.update_state(end);
          const double moved_on = model.energy(end);
          load(end);
          before.start_reading();
          before("structure", model);
          if (!(moved_on <= held + 1e-9 * std::abs(held) + 1e6 * noise))
            refuse("its energy grows, from " + number(held) + " to " + number(moved_on) +
                   ", when its state moves on; it must be what is stored and what is dissipated on "
                   "the way from the state held");
        }
    }
  } // namespace


  template <int dim>
  void
  check_law(StructureModel<dim> &model, const Parameters &slot)
  {
    LawCheck<dim> check(model, slot);
    try
      {
        check.finite_at_start();
        check.measure_noise();
        check.stress();
        check.derivative();
        if (slot.choice().second.has("law"))
          {
            check.rotation();
            check.growth();
          }
        if (model.viscous())
          check.viscosity();
        if (!model.state().empty())
          check.state();
      }
    catch (const RunFailure &failure)
      {
        check.fail(failure.what());
      }
  }


  template void check_law(StructureModel<2> &, const Parameters &);
  template void check_law(StructureModel<3> &, const Parameters &);
} // namespace feib
