// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/refinement_strategy.h>
#include <feib/refinement_strategy/cell_tree.h>

#include "immersed_cells_schema.h"

namespace
{
  template <int dim>
  class ImmersedCells : public feib::RefinementStrategy<dim>
  {
  public:
    explicit ImmersedCells(const feib::Parameters &parameters)
      : level(parameters.integer("level"))
      , minimum_level(parameters.integer("minimum_level"))
      , buffer(parameters.integer("buffer"))
      , steps(parameters.integer("interval"))
    {
      if (minimum_level > level)
        parameters.fail("minimum_level",
                        "is " + std::to_string(minimum_level) + ", must be at most the level, " +
                          std::to_string(level));
    }

    void
    mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
         const feib::EulerianSpace<dim> &space,
         const std::vector<feib::ImmersedStructure<dim>> &structures) const override
    {
      make_tree(space, structures).mark(triangulation, space);
    }

    double
    forecast_cells(const feib::EulerianSpace<dim> &space,
                   const std::vector<feib::ImmersedStructure<dim>> &structures) const override
    {
      using Lattice = feib::Lattice<dim>;
      const double least =
        std::max<double>(Lattice(space.domain(), minimum_level).n_units(),
                         feib::least_touched_cells(Lattice(space.domain(), level), structures));
      return feib::CellTree<dim>::too_large(least) ? least : make_tree(space, structures).n_cells();
    }

    unsigned int
    finest_level() const override
    {
      return level;
    }

    unsigned int
    interval() const override
    {
      return steps;
    }

  private:
    feib::CellTree<dim>
    make_tree(const feib::EulerianSpace<dim> &space,
              const std::vector<feib::ImmersedStructure<dim>> &structures) const
    {
      feib::CellTree<dim> tree(space.domain(), minimum_level, level);
      feib::Places<dim> places = feib::touched_cells(tree.lattice(level), structures);
      feib::dilate(tree.lattice(level), places, buffer);
      for (const feib::Place<dim> &place : places)
        tree.ask_for(level, place);
      tree.balance();
      return tree;
    }

    const int level, minimum_level;
    const long buffer;
    const unsigned int steps;
  };
} // namespace


FEIB_PLUGIN("immersed_cells", "1.0", registry)
{
  registry.add<feib::RefinementStrategy, ImmersedCells>("immersed_cells", immersed_cells_schema);
}
