// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/expression.h>
#include <feib/plugin.h>
#include <feib/registry.h>
#include <feib/structure_force.h>
#include <feib/structure_force/selection.h>
#include <feib/structure_force/try_times.h>

#include "tether_schema.h"

#include <algorithm>
#include <memory>
#include <sstream>

namespace feib
{
  /// Springs and dampers from nodes to target places Y(s, t),
  ///   E = sum_i k_i/2 |X_i - Y_i|^2,  F_i = -k_i (X_i - Y_i) - c_i (U_i - dY_i/dt),
  /// k_i and c_i the given ones times the reference measure that the node stands for.
  template <int dim>
  class Tether : public StructureForce<dim>
  {
  public:
    using Body      = typename StructureForce<dim>::Body;
    using Stiffness = typename StructureForce<dim>::Stiffness;

    explicit Tether(const Parameters &parameters)
      : parameters(parameters)
      , k(parse_expressions<dim>(parameters, "stiffness", 1, Variables::reference))
      , c(parse_expressions<dim>(parameters, "damping", 1, Variables::reference))
    {
      if (parameters.has("target"))
        target = parse_expressions<dim>(parameters, "target", dim, Variables::reference_time);
      if (!parameters.has("target_velocity"))
        return;
      if (!target)
        parameters.fail("target_velocity", "needs a target that moves");
      velocity =
        parse_expressions<dim>(parameters, "target_velocity", dim, Variables::reference_time);
    }

    void
    attach(const Body &body) override
    {
      nodes                              = body.mesh.nodes();
      targets                            = body.positions;
      const std::vector<double> measures = Selection<dim>(parameters, body.mesh).measures();
      springs                            = constants("stiffness", *k, measures);
      dampers                            = constants("damping", *c, measures);
      if (target && !velocity && damped() && depends_on_time(parameters, "target"))
        parameters.fail("",
                        "lacks \"target_velocity\": dampers want to know how a target moves that "
                        "depends on t");
      const std::vector<double> all = body.mesh.node_measures();
      for (unsigned int i = 0; i < all.size(); ++i)
        largest = std::max(largest, springs[i] / all[i]);
      try_times<dim>([this](const double time) { take(time); },
                     body,
                     {target.get(), velocity.get()});
    }

    void
    set_moment(const double time, double) override
    {
      take_at<dim>([this](const double t) { take(t); }, time, {target.get(), velocity.get()});
    }

    double
    energy(const Positions<dim> &X) const override
    {
      return X.sum([&](const unsigned int i) {
        return springs[i] > 0 ? springs[i] / 2 * (X[i] - targets[i]).norm_square() : 0.;
      });
    }

    void
    load(const Positions<dim> &X, NodalField<dim> &load) const override
    {
      for (unsigned int i = 0; i < X.size(); ++i)
        if (springs[i] > 0)
          load[i] -= springs[i] * (X[i] - targets[i]);
    }

    void
    load_derivative(const Positions<dim> &,
                    const NodalField<dim> &dX,
                    NodalField<dim> &dload) const override
    {
      for (unsigned int i = 0; i < dX.size(); ++i)
        dload[i] -= springs[i] * dX[i];
    }

    void
    tangent(const Positions<dim> &, MatrixEntries &entries) const override
    {
      add_diagonal(springs, entries);
    }

    bool
    linear() const override
    {
      return true;
    }

    bool
    viscous() const override
    {
      return damped();
    }

    void
    viscous_load(const Positions<dim> &,
                 const NodalField<dim> &U,
                 NodalField<dim> &load) const override
    {
      for (unsigned int i = 0; i < U.size(); ++i)
        load[i] -= dampers[i] * U[i];
    }

    void
    viscous_tangent(const Positions<dim> &, MatrixEntries &entries) const override
    {
      add_diagonal(dampers, entries);
    }

    /// Of the dampers, that of the targets.
    bool
    external() const override
    {
      return velocity && damped();
    }

    void
    external_load(const Positions<dim> &, NodalField<dim> &load) const override
    {
      for (unsigned int i = 0; i < load.size(); ++i)
        load[i] += dampers[i] * target_velocities[i];
    }

    Stiffness
    stiffness(const Positions<dim> &) const override
    {
      return {largest, 0.};
    }

  private:
    /// The values of the expressions at a time.
    void
    take(const double time)
    {
      target_velocities.assign(nodes.size(), {});
      for (unsigned int a = 0; a < dim; ++a)
        for (unsigned int i = 0; i < nodes.size(); ++i)
          {
            if (target && springs[i] + dampers[i] > 0)
              {
                target->set_time(time);
                targets[i][a] = target->value(nodes[i], a);
              }
            if (velocity && dampers[i] > 0)
              {
                velocity->set_time(time);
                target_velocities[i][a] = velocity->value(nodes[i], a);
              }
          }
    }

    bool
    damped() const
    {
      return std::any_of(dampers.begin(), dampers.end(), [](const double d) { return d > 0; });
    }

    /// An expression at the nodes times what they stand for.
    std::vector<double>
    constants(const std::string &key,
              Expressions<dim> &expression,
              std::vector<double> measures) const
    {
      for (unsigned int i = 0; i < measures.size(); ++i)
        if (measures[i] > 0)
          {
            const double value = expression.value(nodes[i]);
            if (value < 0)
              {
                std::ostringstream text;
                text << "is " << value << " at the reference place (" << nodes[i]
                     << "); it must not be less than 0";
                parameters.fail(key, text.str());
              }
            measures[i] *= value;
          }
      if (const Issues issues = expression.not_finite(MPI_COMM_SELF); !issues.empty())
        throw Error(issues);
      return measures;
    }

    void
    add_diagonal(const std::vector<double> &values, MatrixEntries &entries) const
    {
      if (dealii::Utilities::MPI::this_mpi_process(parameters.communicator()) != 0)
        return;
      for (std::uint64_t i = 0; i < values.size(); ++i)
        if (values[i] > 0)
          for (unsigned int a = 0; a < dim; ++a)
            entries.push_back({i * dim + a, i * dim + a, values[i]});
    }

    const Parameters parameters;
    const std::unique_ptr<Expressions<dim>> k, c;
    std::unique_ptr<Expressions<dim>> target, velocity; // null: at rest
    std::vector<dealii::Point<dim>> nodes;              // reference places
    std::vector<double> springs, dampers;               // of the nodes
    double largest = 0;                                 // spring per reference measure
    Positions<dim> targets;                             // at the moment
    std::vector<dealii::Tensor<1, dim>> target_velocities;
  };
} // namespace feib

FEIB_PLUGIN("tether", "1.0", registry)
{
  registry.add<feib::StructureForce, feib::Tether>("tether", tether_schema);
}
