// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_hierarchy_h
#define feib_plugins_navier_stokes_hierarchy_h

#include "multigrid/level_transfer.h"
#include "multigrid/multigrid_level.h"

#include <memory>
#include <vector>

namespace feib
{
  /// The mesh of the space coarsened as a whole, again and again, also beyond the base cells of the
  /// domain: the levels, the finest first, and the transfer from each to the next.
  template <int dim>
  class Hierarchy
  {
  public:
    /// Collective.
    explicit Hierarchy(const EulerianSpace<dim> &space);

    unsigned int
    size() const
    {
      return levels.size();
    }

    const MultigridLevel<dim> &
    operator[](const unsigned int l) const
    {
      return *levels[l];
    }

    /// Between level l and the next.
    LevelTransfer<dim> &
    transfer(const unsigned int l)
    {
      return transfers[l];
    }

    /// The number of cells of a level, of all ranks.
    std::size_t
    n_cells(const unsigned int l) const
    {
      return numbers_of_cells[l];
    }

  private:
    std::vector<std::unique_ptr<MultigridLevel<dim>>> levels;
    std::vector<LevelTransfer<dim>> transfers;
    std::vector<std::size_t> numbers_of_cells;
  };
} // namespace feib

#endif
