// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_cell_batches_h
#define feib_plugins_navier_stokes_cell_batches_h

#include "operators/cell_kernels.h"

#include <feib/eulerian_space.h>

#include <vector>

namespace feib
{
  /// The cells of this rank, so many of one size, with open faces in the same places, at a time,
  /// one in each lane of the compiler's vectors.
  template <int dim>
  class CellBatches
  {
  public:
    static constexpr unsigned int n     = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_u   = EulerianSpace<dim>::n_velocity;
    static constexpr unsigned int n_p   = EulerianSpace<dim>::n_pressure;
    static constexpr unsigned int lanes = Batch<double>::lanes;

    using Values = Batch<double>::Values;

    struct CellBatch
    {
      dealii::Tensor<1, dim> size;
      unsigned int level, filled;
      unsigned int open_faces, static_faces; // bit f: face f; those of them with static_inflow
      unsigned int open_number;              // among batches with open faces
      unsigned int cells[lanes];             // the last lanes may repeat a cell
      unsigned int velocities[n_u * lanes], pressures[n_p * lanes];

      void
      gather(const VelocityVector &u, Values (&local)[n_u]) const
      {
        for (unsigned int i = 0; i < n_u; ++i)
          local[i] = feib::gather(u.begin(), velocities + i * lanes);
      }

      void
      gather_pressure(const PressureVector &p, Values (&local)[n_p]) const
      {
        for (unsigned int k = 0; k < n_p; ++k)
          local[k] = feib::gather(p.begin(), pressures + k * lanes);
      }

      void
      scatter_add(const Values (&local)[n_u], VelocityVector &r) const
      {
        for (unsigned int i = 0; i < n_u; ++i)
          feib::scatter_add(local[i], velocities + i * lanes, filled, r.begin());
      }

      void
      scatter_add_pressure(const Values (&local)[n_p], PressureVector &g) const
      {
        for (unsigned int k = 0; k < n_p; ++k)
          feib::scatter_add(local[k], pressures + k * lanes, filled, g.begin());
      }
    };

    /// For the present mesh of the space.
    void reinit(const EulerianSpace<dim> &space);

    auto
    begin() const
    {
      return batches.begin();
    }
    auto
    end() const
    {
      return batches.end();
    }
    unsigned int
    size() const
    {
      return batches.size();
    }
    const CellBatch &
    operator[](const unsigned int batch) const
    {
      return batches[batch];
    }

    /// How many batches have open faces.
    unsigned int
    n_open() const
    {
      return n_open_batches;
    }

    /// Where a cell of the space is: batch * lanes + lane.
    unsigned int
    place(const unsigned int cell) const
    {
      return place_of_cell[cell];
    }

  private:
    std::vector<CellBatch> batches;
    std::vector<unsigned int> place_of_cell;
    unsigned int n_open_batches = 0;
  };
} // namespace feib

#endif
