// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_velocity_cycle_h
#define feib_plugins_navier_stokes_velocity_cycle_h

#include "multigrid/chebyshev.h"
#include "multigrid/hierarchy.h"

#include <deal.II/lac/sparse_direct.h>

namespace feib
{
  /// A^{-1} for the matrix A of a form of the velocity, by a V-cycle in single precision. Where the
  /// mass dominates, the smoother alone is a solver and the cycle ends.
  template <int dim>
  class VelocityCycle
  {
  public:
    /// On every level: u ~ A^{-1} f; product and step are for anybody's use between cycles.
    struct Level
    {
      LevelVector<float> u, f, product, step;
      LevelVector<float> inverse_diagonal;
      Chebyshev smoother;
      bool smoother_solves;
    };

    explicit VelocityCycle(Hierarchy<dim> &hierarchy);

    /// Prepares the levels that cycles use, when cycles start on the finest one, and on the next
    /// after each of those that @p coarser_first says.
    void set_form(const VelocityForm &form, const std::vector<bool> &coarser_first);

    /// u = about A^{-1} f on level l.
    void apply(unsigned int l);

    /// product = A u
    void multiply(unsigned int l, LevelVector<float> &u);

    Level &
    operator[](const unsigned int l)
    {
      return levels[l];
    }

    /// The last level that cycles use; and whether they end with a factorisation there.
    unsigned int
    last() const
    {
      return last_level;
    }
    bool
    ends_with_factor() const
    {
      return factor != nullptr;
    }

  private:
    void smooth(unsigned int l, bool from_zero);

    void factorize();

    Hierarchy<dim> &hierarchy;
    std::vector<Level> levels;
    VelocityForm form{0, 0};
    unsigned int last_level = 0;
    std::unique_ptr<dealii::SparseDirectUMFPACK> factor; // on the coarsest level, if used
  };
} // namespace feib

#endif
