// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_refinement_strategy_h
#define feib_refinement_strategy_h

#include <feib/archive.h>
#include <feib/check_context.h>
#include <feib/eulerian_space.h>
#include <feib/immersed_structure.h>

namespace feib
{
  /// Marks cells of the Eulerian mesh.
  template <int dim>
  class RefinementStrategy
  {
  public:
    static constexpr const char *kind = "refinement_strategy";

    virtual ~RefinementStrategy() = default;

    /// Before a run, when nothing has been written and space is that of the base cells: throws
    /// Error with all that the case asks for and that cannot be. Collective.
    virtual void
    check(const CheckContext<dim> &)
    {}

    /// The number of cells of the first mesh, before it is made. Where that is beyond
    /// Domain::most_cells, a lower estimate which is so too. 0: not known.
    virtual double
    forecast_cells(const EulerianSpace<dim> &, const std::vector<ImmersedStructure<dim>> &) const
    {
      return 0;
    }

    /// The level of the smallest cells that the mesh may get: how often a base cell is halved.
    /// Where it is said, a case with too small cells is refused before the run. 0: not known.
    virtual unsigned int
    finest_level() const
    {
      return 0;
    }

    /// What the object carries from step to step. Collective.
    virtual void
    archive(Archive &)
    {}

    /// Called once before the calls of mark() that lead to a new mesh. What is wanted because of
    /// the fluid's state must be decided here: mark() would find the same state on the finer cells
    /// and refine them again. Collective.
    virtual void
    plan(const EulerianSpace<dim> &, const std::vector<ImmersedStructure<dim>> &)
    {}

    /// Sets refine and coarsen flags on the locally owned cells of @p triangulation. Mark and
    /// execute are repeated until no flag is set on any rank.
    virtual void mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
                      const EulerianSpace<dim> &space,
                      const std::vector<ImmersedStructure<dim>> &structures) const = 0;

    /// After how many steps to mark again; 0: never.
    virtual unsigned int interval() const = 0;

    /// Plans, and adapts the mesh until nothing is marked. Returns whether it changed. Collective.
    bool
    adapt(EulerianSpace<dim> &space, const std::vector<ImmersedStructure<dim>> &structures)
    {
      plan(space, structures);
      return space.adapt([&](auto &mesh) { mark(mesh, space, structures); }, true);
    }
  };
} // namespace feib

#endif
