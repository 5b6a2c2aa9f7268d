// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_refinement_strategy_h
#define feib_refinement_strategy_h

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

    /// Sets refine and coarsen flags on the locally owned cells of @p triangulation. The core
    /// repeats mark and execute at the start until no flag is set on any rank.
    virtual void mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
                      const EulerianSpace<dim> &space,
                      const std::vector<ImmersedStructure<dim>> &structures) const = 0;

    /// After how many steps to mark again; 0: never.
    virtual unsigned int interval() const = 0;
  };
} // namespace feib

#endif
