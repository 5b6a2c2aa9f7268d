// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/hierarchy.h"

#include <feib/log.h>

#include <deal.II/base/mpi.h>

#include <string>

namespace feib
{
  namespace
  {
    /// Levels with at most this many cells are held by every rank: there a message costs more than
    /// the work it saves.
    constexpr unsigned int replicate_below = 600;
  } // namespace


  template <int dim>
  Hierarchy<dim>::Hierarchy(const EulerianSpace<dim> &space)
  {
    const MPI_Comm communicator = space.communicator();
    const bool parallel         = dealii::Utilities::MPI::n_mpi_processes(communicator) > 1;

    std::vector<LatticeCells<dim>> meshes{LatticeCells<dim>(space)};
    std::vector<std::vector<typename LatticeCells<dim>::Family>> families;
    while (meshes.back().coarsens())
      {
        families.emplace_back();
        LatticeCells<dim> coarser = meshes.back().coarsened(families.back());
        meshes.push_back(std::move(coarser));
      }
    if (parallel && meshes.size() == 1)
      {
        // The coarsest level is solved by every rank alone.
        families.emplace_back(meshes[0].cells().size());
        for (unsigned int c = 0; c < families[0].size(); ++c)
          families[0][c].children[0] = c;
        LatticeCells<dim> same = meshes[0];
        meshes.push_back(std::move(same));
      }

    constexpr unsigned int large = dim == 2 ? 10000 : 1000;
    if (meshes.back().cells().size() > large)
      log::warning("the fluid's multigrid ends with " +
                   std::to_string(meshes.back().cells().size()) +
                   " cells, which are solved for directly: numbers of cells with more factors of "
                   "two are faster");

    transfers.reserve(meshes.size());
    bool replicated = false;
    for (unsigned int l = 0; l < meshes.size(); ++l)
      {
        const bool last = l + 1 == meshes.size();
        numbers_of_cells.push_back(meshes[l].cells().size());
        replicated =
          replicated || (parallel && (last || (l > 0 && numbers_of_cells[l] <= replicate_below)));
        levels.push_back(std::make_unique<MultigridLevel<dim>>(meshes[l],
                                                               space.domain(),
                                                               communicator,
                                                               replicated,
                                                               last ? nullptr : &meshes[l + 1],
                                                               last ? nullptr : &families[l]));
        if (l > 0)
          {
            transfers.emplace_back(
              *levels[l - 1], *levels[l], meshes[l], families[l - 1], communicator);
            levels[l - 1]->forget_places();
          }
      }
    levels.back()->forget_places();
  }


  template class Hierarchy<2>;
  template class Hierarchy<3>;
} // namespace feib
