// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_level_transfer_h
#define feib_plugins_navier_stokes_level_transfer_h

#include "multigrid/level_space.h"

namespace feib
{
  /// Between two levels that follow each other: the embedding P of the coarser space and its
  /// transpose.
  template <int dim>
  class LevelTransfer
  {
  public:
    using Family = typename LatticeCells<dim>::Family;

    /// @p coarse is on the mesh @p coarser, made of the @p families of the cells of @p fine.
    /// Collective.
    LevelTransfer(const LevelSpace<dim> &fine,
                  const LevelSpace<dim> &coarse,
                  const LatticeCells<dim> &coarser,
                  const std::vector<Family> &families,
                  MPI_Comm world);

    /// fine += P coarse; coarse is expanded
    void prolongate_velocity(const LevelVector<float> &coarse, LevelVector<float> &fine);
    void prolongate_pressure(const LevelVector<float> &coarse, LevelVector<float> &fine);

    /// coarse = P^T fine; for velocities still to be condensed by the coarser level
    void restrict_velocity(LevelVector<float> &fine, LevelVector<float> &coarse) const;
    void restrict_pressure(LevelVector<float> &fine, LevelVector<float> &coarse) const;

  private:
    static constexpr unsigned int lanes      = LevelSpace<dim>::lanes;
    static constexpr unsigned int n          = LevelSpace<dim>::n;
    static constexpr unsigned int n_pressure = LevelSpace<dim>::n_pressure;
    static constexpr unsigned int n_fine     = dim == 2 ? 25 : 125;
    static constexpr float child_slope       = LineMatrices::root / 4;

    /// Cells of the coarser level, lane by lane, and their places on the finer one: nodes (5^dim of
    /// refined cells, else 3^dim) and pressures (of all children).
    struct Batch
    {
      bool refined;
      unsigned int filled;
      std::vector<unsigned int> coarse_nodes, fine_nodes, coarse_pressures, fine_pressures;

      unsigned int
      n_fine_nodes() const
      {
        return fine_nodes.size() / lanes;
      }

      unsigned int
      n_children() const
      {
        return fine_pressures.size() / lanes / n_pressure;
      }
    };

    /// Of the cells c of the coarser mesh.
    static Batch make_batch(const LevelSpace<dim> &fine,
                            const LevelSpace<dim> &coarse,
                            const LatticeCells<dim> &coarser,
                            const std::vector<Family> &families,
                            const std::vector<unsigned int> &cells,
                            bool refined);

    void find_node_weights(const LevelSpace<dim> &fine);

    void sum(LevelVector<float> &v) const;

    std::vector<Batch> batches;
    LevelVector<float> node_weights; // 1 / number of coarse cells a node is in
    LevelVector<float> fine_velocity, fine_pressure;
    const MPI_Comm sum_over; // what is restricted is summed over these ranks
  };
} // namespace feib

#endif
