// SPDX-License-Identifier: LGPL-2.1-or-later
#include "structure_checks.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace feib
{
  namespace
  {
    /// What the elements of a structure look like.
    struct Shapes
    {
      double longest = 0; // edge
      double flattest =
        std::numeric_limits<double>::infinity();               // smallest height over longest edge
      std::uint64_t longest_element = 0, flattest_element = 0; // their numbers
      unsigned int n_turned = 0; // of a body: elements with another sense than most
    };


    template <int dim>
    Shapes
    shapes_of(const StructureModel<dim> &model)
    {
      const Positions<dim> &X = model.positions;
      const unsigned int m    = model.mesh().structure_dim();
      Shapes result;
      unsigned int n_negative = 0, e = 0;
      for (const auto &element : model.mesh().elements())
        {
          const double longest = model.mesh().longest_edge(element, X);
          if (longest > result.longest)
            {
              result.longest         = longest;
              result.longest_element = element.number;
            }
          if (m > 1)
            {
              dealii::Tensor<2, dim> edges;
              for (unsigned int k = 0; k < m; ++k)
                edges[k] = X[element.nodes[k + 1]] - X[element.nodes[0]];
              // m! times the measure, over the longest edge to the power m.
              const double size =
                (m == 3 ? 6 : m) * model.mesh().measure(element, X) / std::pow(longest, double(m));
              if (size < result.flattest)
                {
                  result.flattest         = size;
                  result.flattest_element = element.number;
                }
              if (m == dim && determinant(edges) <= 0)
                ++n_negative;
            }
          ++e;
        }
      result.n_turned = std::min(n_negative, e - n_negative);
      return result;
    }


    /// The distance of a structure's nearest node to a wall, without nodes that started on it.
    template <int dim>
    double
    distance_to_walls(const Domain<dim> &domain,
                      const Positions<dim> &X,
                      const Positions<dim> &initial,
                      const double near)
    {
      double result = std::numeric_limits<double>::infinity();
      for (unsigned int a = 0; a < dim; ++a)
        {
          if (domain.periodic(a))
            continue;
          const double touching = 1e-9 * (domain.upper[a] - domain.lower[a]);
          for (const double sign : {1., -1.})
            {
              const double wall = sign > 0 ? domain.lower[a] : domain.upper[a];
              const auto from   = [&](const dealii::Point<dim> &x) { return sign * (x[a] - wall); };
              // What stands on the wall begins near it.
              const bool stands = std::any_of(initial.begin(), initial.end(), [&](const auto &x) {
                return from(x) <= touching;
              });
              for (unsigned int i = 0; i < X.size(); ++i)
                if (from(initial[i]) > (stands ? 2 * near : touching))
                  result = std::min(result, from(X[i]));
            }
        }
      return result;
    }


    /// Whether a point is inside a body.
    template <int dim>
    bool
    inside(const StructureModel<dim> &body, const dealii::Point<dim> &x)
    {
      for (const auto &element : body.mesh().elements())
        {
          dealii::Tensor<2, dim> edges; // as columns
          const dealii::Point<dim> &tip = body.positions[element.nodes[0]];
          for (unsigned int k = 0; k < dim; ++k)
            for (unsigned int a = 0; a < dim; ++a)
              edges[a][k] = body.positions[element.nodes[k + 1]][a] - tip[a];
          if (determinant(edges) == 0)
            continue;
          const dealii::Tensor<1, dim> unit = invert(edges) * (x - tip);
          double rest                       = 1;
          bool within                       = true;
          for (unsigned int a = 0; a < dim; ++a)
            {
              within = within && unit[a] > 1e-9;
              rest -= unit[a];
            }
          if (within && rest > 1e-9)
            return true;
        }
      return false;
    }


    /// How many nodes of a structure are inside a body.
    template <int dim>
    unsigned int
    n_inside(const StructureModel<dim> &body, const StructureModel<dim> &structure)
    {
      dealii::Point<dim> low = body.positions[0], high = low;
      for (const dealii::Point<dim> &x : body.positions)
        for (unsigned int a = 0; a < dim; ++a)
          {
            low[a]  = std::min(low[a], x[a]);
            high[a] = std::max(high[a], x[a]);
          }
      unsigned int result = 0;
      for (const dealii::Point<dim> &x : structure.positions)
        {
          bool near = true;
          for (unsigned int a = 0; a < dim; ++a)
            near = near && x[a] > low[a] && x[a] < high[a];
          if (near && inside(body, x))
            ++result;
        }
      return result;
    }
  } // namespace


  template <int dim>
  void
  check_meshes(const Components<dim> &components, const double time, Verdict &verdict)
  {
    for (const ImmersedStructure<dim> &structure : components.structures)
      for (const auto &remark : structure.model->mesh().remarks())
        verdict.warn(remark.kind,
                     time,
                     remark.value,
                     "the structure \"" + structure.model->name() + "\": " + remark.text);
  }


  template <int dim>
  void
  check_structures(const Components<dim> &components, const double time, Verdict &verdict)
  {
    const double h = components.space->smallest_edge();
    for (unsigned int s = 0; s < components.structures.size(); ++s)
      {
        const StructureModel<dim> &model = *components.structures[s].model;
        const std::string name           = "the structure \"" + model.name() + "\"";
        const Shapes shapes              = shapes_of(model);
        std::ostringstream text;
        text.precision(3);
        const auto warn = [&](const std::string &kind, const double value) {
          verdict.warn(kind, time, value, text.str());
          text.str("");
        };
        const double bearable = components.structures[s].motion->longest_element();
        if (shapes.longest > bearable * h)
          {
            text << "element " << shapes.longest_element << " of " << name << " is "
                 << shapes.longest << " long, the smallest cells of the fluid are " << h
                 << ": with this coupling an element may be at most " << bearable
                 << " times as long; use a finer mesh of the structure";
            warn("long_elements", shapes.longest / h);
          }
        if (shapes.flattest < .05)
          {
            text << "element " << shapes.flattest_element << " of " << name
                 << " has a bad shape: its measure is " << shapes.flattest
                 << " of that of a right one with its longest edge";
            warn("element_shape", 1 / std::max(shapes.flattest, 1e-300));
          }
        if (shapes.n_turned > 0)
          {
            text << name << " is folded: " << shapes.n_turned
                 << " of its elements have another sense than the others";
            warn("folded", shapes.n_turned);
          }
        const double distance = distance_to_walls(components.space->domain(),
                                                  model.positions,
                                                  components.structures[s].model->initial_positions,
                                                  .5 * h);
        if (distance < .5 * h)
          {
            text << name << " is " << distance
                 << " from a wall, less than half a cell of the fluid, " << h
                 << ": the flow between them is not resolved";
            warn("near_wall", h / std::max(distance, 1e-300));
          }
      }
  }


  template <int dim>
  void
  check_overlap(const Components<dim> &components, const double time, Verdict &verdict)
  {
    for (unsigned int s = 0; s < components.structures.size(); ++s)
      for (unsigned int t = 0; t < components.structures.size(); ++t)
        {
          const StructureModel<dim> &body  = *components.structures[s].model,
                                    &other = *components.structures[t].model;
          // Of two bodies, one may hold no node of the other.
          if (s == t || body.mesh().structure_dim() < dim || other.mesh().structure_dim() < dim)
            continue;
          if (const unsigned int n = n_inside(body, other); n > 0)
            {
              std::ostringstream text;
              text << n << " nodes of the structure \"" << other.name()
                   << "\" are inside the structure \"" << body.name() << "\"";
              verdict.warn("overlap", time, n, text.str());
            }
        }
  }


  template void check_meshes(const Components<2> &, double, Verdict &);
  template void check_meshes(const Components<3> &, double, Verdict &);
  template void check_overlap(const Components<2> &, double, Verdict &);
  template void check_overlap(const Components<3> &, double, Verdict &);
  template void check_structures(const Components<2> &, double, Verdict &);
  template void check_structures(const Components<3> &, double, Verdict &);
} // namespace feib
