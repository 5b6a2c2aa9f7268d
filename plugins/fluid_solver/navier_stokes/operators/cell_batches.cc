// SPDX-License-Identifier: LGPL-2.1-or-later
#include "operators/cell_batches.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace feib
{
  namespace
  {
    /// The faces of a cell that fluid crosses freely: bit f for face f.
    template <int dim>
    unsigned int
    open_faces_of(const typename EulerianSpace<dim>::Cell &cell, const Domain<dim> &box)
    {
      unsigned int result = 0;
      for (unsigned int f = 0; f < 2 * dim; ++f)
        if (box.faces[f].open())
          {
            const double distance = f % 2 == 0
                                      ? cell.lower[f / 2] - box.lower[f / 2]
                                      : box.upper[f / 2] - cell.lower[f / 2] - cell.size[f / 2];
            if (std::abs(distance) < .5 * cell.size[f / 2])
              result |= 1U << f;
          }
      return result;
    }
  } // namespace


  template <int dim>
  void
  CellBatches<dim>::reinit(const EulerianSpace<dim> &space)
  {
    std::map<std::pair<unsigned int, unsigned int>, std::vector<unsigned int>> groups;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      groups[{space.cells()[c].level, open_faces_of<dim>(space.cells()[c], space.domain())}]
        .push_back(c);
    batches.clear();
    place_of_cell.resize(space.cells().size());
    n_open_batches = 0;
    for (const auto &[key, cells] : groups)
      for (unsigned int first = 0; first < cells.size(); first += lanes)
        {
          CellBatch batch;
          batch.size        = space.cells()[cells[first]].size;
          batch.level       = key.first;
          batch.open_faces  = key.second;
          batch.open_number = n_open_batches;
          if (batch.open_faces != 0)
            ++n_open_batches;
          batch.filled = std::min<unsigned int>(lanes, cells.size() - first);
          for (unsigned int l = 0; l < lanes; ++l)
            {
              const unsigned int c = cells[first + std::min(l, batch.filled - 1)];
              batch.cells[l]       = c;
              if (l < batch.filled)
                place_of_cell[c] = batches.size() * lanes + l;
              for (unsigned int i = 0; i < n_u; ++i)
                batch.velocities[i * lanes + l] = space.velocity_dofs(c)[i];
              for (unsigned int k = 0; k < n_p; ++k)
                batch.pressures[k * lanes + l] = space.pressure_dofs(c)[k];
            }
          batches.push_back(batch);
        }
  }


  template class CellBatches<2>;
  template class CellBatches<3>;
} // namespace feib
