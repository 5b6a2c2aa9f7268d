// SPDX-License-Identifier: LGPL-2.1-or-later
#include "operators/cell_batches.h"

#include <algorithm>
#include <array>
#include <map>

namespace feib
{
  template <int dim>
  void
  CellBatches<dim>::reinit(const EulerianSpace<dim> &space)
  {
    std::vector<std::array<unsigned int, 2>> faces(space.cells().size(), {0U, 0U});
    for (const auto &face : space.boundary_faces())
      if (const auto &condition = space.domain().conditions[face.condition]; condition.open())
        {
          faces[face.cell][0] |= 1U << face.face;
          if (condition.static_inflow)
            faces[face.cell][1] |= 1U << face.face;
        }
    std::map<std::array<unsigned int, 3>, std::vector<unsigned int>> groups;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      groups[{space.cells()[c].level, faces[c][0], faces[c][1]}].push_back(c);
    batches.clear();
    place_of_cell.resize(space.cells().size());
    n_open_batches = 0;
    for (const auto &[key, cells] : groups)
      for (unsigned int first = 0; first < cells.size(); first += lanes)
        {
          CellBatch batch;
          batch.size         = space.cells()[cells[first]].size;
          batch.level        = key[0];
          batch.open_faces   = key[1];
          batch.static_faces = key[2];
          batch.open_number  = n_open_batches;
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
