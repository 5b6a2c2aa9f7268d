// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/refinement_strategy.h>

#include <cmath>

#include "uniform_schema.h"

namespace
{
  template <int dim>
  class Uniform : public feib::RefinementStrategy<dim>
  {
  public:
    explicit Uniform(const feib::Parameters &parameters)
      : levels(parameters.integer("levels"))
    {}

    void
    mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
         const feib::EulerianSpace<dim> &space,
         const std::vector<feib::ImmersedStructure<dim>> &) const override
    {
      for (const auto &cell : triangulation.active_cell_iterators())
        if (cell->is_locally_owned() && space.level(*cell) < levels)
          cell->set_refine_flag();
    }

    double
    forecast_cells(const feib::EulerianSpace<dim> &space,
                   const std::vector<feib::ImmersedStructure<dim>> &) const override
    {
      double n = std::pow(2., dim * levels);
      for (const unsigned int of_base : space.domain().cells)
        n *= of_base;
      return n;
    }

    unsigned int
    finest_level() const override
    {
      return levels;
    }

    unsigned int
    interval() const override
    {
      return 0;
    }

  private:
    const int levels;
  };
} // namespace


FEIB_PLUGIN("uniform", "1.0", registry)
{
  registry.add<feib::RefinementStrategy, Uniform>("uniform", uniform_schema);
}
