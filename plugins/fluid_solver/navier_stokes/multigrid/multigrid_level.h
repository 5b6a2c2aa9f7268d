// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_multigrid_level_h
#define feib_plugins_navier_stokes_multigrid_level_h

#include "multigrid/level_space.h"

#include <deal.II/base/aligned_vector.h>

namespace feib
{
  /// The forms on a level. Velocities given are expanded, results of velocity condensed.
  template <int dim>
  class MultigridLevel : public LevelSpace<dim>
  {
  public:
    using LevelSpace<dim>::LevelSpace;
    using LevelSpace<dim>::lanes;
    using LevelSpace<dim>::n;
    using LevelSpace<dim>::n_pressure;
    using LevelSpace<dim>::n_batches;
    using LevelSpace<dim>::n_filled;
    using LevelSpace<dim>::cell_size;
    using LevelSpace<dim>::nodes;
    using typename LevelSpace<dim>::Size;

    /// result = form(u, v)
    template <typename Number>
    void apply_velocity_form(const VelocityForm &form,
                             const LevelVector<Number> &u,
                             LevelVector<Number> &result) const;

    /// result = (p, div v)
    void apply_gradient(const LevelVector<float> &p, LevelVector<float> &result) const;

    /// result = (div u, q)
    void apply_divergence(const LevelVector<float> &u, LevelVector<float> &result) const;

    /// result += factor * Mp^{-1} g, with Mp the mass matrix of the pressure.
    void add_inverse_pressure_mass(float factor,
                                   const LevelVector<float> &g,
                                   LevelVector<float> &result) const;

    /// One over the diagonal (or, with @p row_sums, over the sums of the rows, without those of
    /// other components) of the condensed matrix of the form; zero where the unknown does not
    /// count.
    void
    inverse_diagonal(const VelocityForm &form, bool row_sums, LevelVector<float> &result) const;

    /// The cells' own blocks of B diag(weights) B^T, with B condensed, inverted: of the cell in
    /// lane l of batch b, entry (k, m) at ((b * n_pressure + k) * n_pressure + m) * lanes + l.
    void invert_blocks(LevelVector<float> &weights, dealii::AlignedVector<float> &blocks) const;
  };
} // namespace feib

#endif
