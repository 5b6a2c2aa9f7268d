// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_pressure_cycle_h
#define feib_plugins_navier_stokes_pressure_cycle_h

#include "multigrid/chebyshev.h"
#include "multigrid/hierarchy.h"

#include <deal.II/lac/sparse_direct.h>

namespace feib
{
  /// Lp^{-1} for Lp = B Ml^{-1} B^T with the lumped mass Ml, by a V-cycle in single precision.
  template <int dim>
  class PressureCycle
  {
  public:
    /// On every level: p ~ Lp^{-1} g; product and flux are for anybody's use between cycles.
    struct Level
    {
      LevelVector<float> p, g, product, step;
      LevelVector<float> flux; // a velocity
      LevelVector<float> inverse_mass;
      dealii::AlignedVector<float> inverse_blocks;
      Chebyshev smoother;
    };

    /// @p enclosed: constants are in the kernel.
    PressureCycle(Hierarchy<dim> &hierarchy, bool enclosed);

    /// p = about Lp^{-1} g on level l. If @p sharp, the last smoothing sees something nearer to
    /// B M^{-1} B^T, which is what the pressure of a flow dominated by inertia needs.
    void apply(unsigned int l, bool sharp);

    Level &
    operator[](const unsigned int l)
    {
      return levels[l];
    }

  private:
    void find_smoothers();

    /// The largest eigenvalue of Lp with its blocks.
    double largest_eigenvalue(unsigned int l);

    /// product = Lp p
    void multiply(unsigned int l, const LevelVector<float> &p, bool sharp);

    void step(Level &level, unsigned int l, double c, double s, const float *product) const;

    void smooth(unsigned int l, const Chebyshev &smoother, bool from_zero, bool sharp);

    void factorize();

    void solve_coarsest();

    Hierarchy<dim> &hierarchy;
    const bool enclosed;
    std::vector<Level> levels;
    LevelVector<float> mass_product; // of the finest level, for the sharp operator
    std::unique_ptr<dealii::SparseDirectUMFPACK> factor;
  };
} // namespace feib

#endif
