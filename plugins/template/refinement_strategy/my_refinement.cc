#include <feib/plugin.h>
#include <feib/refinement_strategy.h>

#include "my_refinement_schema.h"

namespace my_refinement_plugin
{
  /// Halves the cells whose centres lie in a ball, a given number of times, once, at the start.
  template <int dim>
  class MyRefinement : public feib::RefinementStrategy<dim>
  {
  public:
    explicit MyRefinement(const feib::Parameters &parameters)
      : levels(parameters.integer("levels"))
      , radius(parameters.number("radius"))
    {}

    /// Called until nothing is marked: what is marked must not depend on the cells it is asked of.
    void
    mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
         const feib::EulerianSpace<dim> &space,
         const std::vector<feib::ImmersedStructure<dim>> &) const override
    {
      dealii::Point<dim> centre;
      for (unsigned int a = 0; a < dim; ++a)
        centre[a] = (space.domain().lower[a] + space.domain().upper[a]) / 2;
      for (const auto &cell : triangulation.active_cell_iterators())
        if (cell->is_locally_owned() && space.level(*cell) < levels &&
            cell->center().distance(centre) < radius)
          cell->set_refine_flag();
    }

    unsigned int
    finest_level() const override
    {
      return levels;
    }

    /// Steps after which to mark again; 0: never.
    unsigned int
    interval() const override
    {
      return 0;
    }

  private:
    const int levels;
    const double radius;
  };
} // namespace my_refinement_plugin

FEIB_PLUGIN("my_refinement", "1.0", registry)
{
  registry.add<feib::RefinementStrategy, my_refinement_plugin::MyRefinement>("my_refinement",
                                                                             my_refinement_schema);
}
