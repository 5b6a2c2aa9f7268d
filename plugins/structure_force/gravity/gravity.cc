// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/expression.h>
#include <feib/plugin.h>
#include <feib/registry.h>
#include <feib/structure_force/try_times.h>

#include "gravity_schema.h"

#include <memory>

namespace feib
{
  /// The weight of the excess mass, E = - sum_i m_i g(s_i, t) . (X_i - X_i(0)).
  template <int dim>
  class Gravity : public StructureForce<dim>
  {
  public:
    using Body = typename StructureForce<dim>::Body;

    explicit Gravity(const Parameters &parameters)
      : g(parse_expressions<dim>(parameters, "acceleration", dim, Variables::reference_time))
    {}

    void
    attach(const Body &body) override
    {
      nodes  = body.mesh.nodes();
      start  = body.positions;
      masses = body.excess_mass;
      try_times<dim>([this](const double time) { take(time); }, body, {g.get()});
    }

    void
    set_moment(const double time, double) override
    {
      take_at<dim>([this](const double t) { take(t); }, time, {g.get()});
    }

    double
    energy(const Positions<dim> &X) const override
    {
      return X.sum([&](const unsigned int i) { return -(weights[i] * (X[i] - start[i])); });
    }

    void
    load(const Positions<dim> &, NodalField<dim> &load) const override
    {
      for (unsigned int i = 0; i < load.size(); ++i)
        load[i] += weights[i];
    }

    bool
    linear() const override
    {
      return true;
    }

  private:
    /// The values of the expressions at a time.
    void
    take(const double time)
    {
      g->set_time(time);
      weights.assign(nodes.size(), {});
      for (unsigned int i = 0; i < masses.size(); ++i)
        for (unsigned int a = 0; a < dim; ++a)
          weights[i][a] = masses[i] * g->value(nodes[i], a);
    }

    const std::unique_ptr<Expressions<dim>> g;
    std::vector<dealii::Point<dim>> nodes; // reference places
    Positions<dim> start;
    std::vector<double> masses;
    std::vector<dealii::Tensor<1, dim>> weights; // at the moment
  };
} // namespace feib

FEIB_PLUGIN("gravity", "1.0", registry)
{
  registry.add<feib::StructureForce, feib::Gravity>("gravity", gravity_schema);
}
