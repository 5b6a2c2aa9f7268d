// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_stokes_multigrid_h
#define feib_plugins_navier_stokes_stokes_multigrid_h

#include "multigrid_level.h"

#include <deal.II/lac/sparse_direct.h>

namespace feib
{
  /// The block triangular preconditioner of Cahouet and Chabard (1988) for the saddle point matrix
  /// [A -B^T; -B 0] with A the matrix of a VelocityForm: on the pressure,
  ///   S^{-1} = (mu + nu) Mp^{-1} + alpha Lp^{-1},  Lp = B Ml^{-1} B^T with the lumped mass Ml,
  /// and then A^{-1}, each inverse but Mp^{-1} replaced by a V-cycle in single precision. The
  /// system it sees is augmented (Fortin and Glowinski 1983; Benzi and Olshanskii 2006): with
  /// p + eta Mp^{-1} B u in the place of p, A becomes A + eta B^T Mp^{-1} B, and S^{-1} becomes
  /// S^{-1} + eta Mp^{-1}, of which more is known. Levels are the mesh coarsened as a whole, again
  /// and again, also beyond the base cells of the domain.
  template <int dim>
  class StokesMultigrid
  {
  public:
    /// Builds the levels for the mesh of the space when it changed, and what depends on the form of
    /// the velocity when that did. @p augmented: for solve(); the velocity's cycle is then for A
    /// with the augmentation. Without, solve_velocity() is a cycle for A itself. Collective.
    void prepare(const EulerianSpace<dim> &space, const VelocityForm &form, bool augmented = true);

    /// (u, p) ~ matrix^{-1} (f, g) for condensed f; constrained entries of u are zero. Collective.
    void
    solve(const VelocityVector &f, const PressureVector &g, VelocityVector &u, PressureVector &p);

    /// The parts of it: p ~ Lp^{-1} g and u ~ A^{-1} f by one cycle, in condensed
    /// vectors of the space. Collective.
    void solve_pressure(const PressureVector &g, PressureVector &p);
    void solve_velocity(const VelocityVector &f, VelocityVector &u);

    /// v = Ml^{-1} v. Collective.
    void divide_by_mass(VelocityVector &v);

    /// Levels there are, for the log.
    std::string describe() const;

  private:
    /// Chebyshev's iteration on D^{-1} A over an interval that holds the upper end of the spectrum,
    /// or all of it.
    struct Chebyshev
    {
      double lower, upper;
      unsigned int degree;
    };

    struct Level
    {
      std::unique_ptr<MultigridLevel<dim>> mesh;

      // A: the form of the cycles
      Chebyshev velocity_smoother;
      LevelVector<float> inverse_diagonal;
      bool smoother_solves; // the mass dominates
      LevelVector<float> u, f, velocity_product, velocity_step;

      // Lp
      Chebyshev pressure_smoother;
      LevelVector<float> inverse_mass;
      dealii::AlignedVector<float> inverse_blocks;
      LevelVector<float> p, g, pressure_product, pressure_step, flux;

      // both: the coarser level corrects first, by this much
      bool coarser_first = false;
      LevelVector<float> first_u, first_p;
    };

    void build_levels(const EulerianSpace<dim> &space);

    void set_pressure_smoother(Level &level) const;

    void map_unknowns(const EulerianSpace<dim> &space);

    // Between vectors of the space and u, f, p or g of the finest level; sources are owned values.
    void import_velocity(const VelocityVector &from, LevelVector<float> &to) const;
    void export_velocity(const LevelVector<float> &from, VelocityVector &to) const;
    void import_pressure(const PressureVector &from, float factor, LevelVector<float> &to) const;
    void export_pressure(const LevelVector<float> &from, PressureVector &to) const;

    /// result = B Ml^{-1} B^T p or (sharp) something nearer to B M^{-1} B^T p.
    void apply_pressure_operator(Level &level,
                                 const LevelVector<float> &p,
                                 LevelVector<float> &result,
                                 bool sharp) const;

    void smooth_velocity(Level &level, const Chebyshev &smoother, bool from_zero) const;
    void smooth_pressure(Level &level, const Chebyshev &smoother, bool from_zero, bool sharp) const;

    /// u = about A^{-1} f, p = about Lp^{-1} g; where inertia counts, the last smoothing on the
    /// finest level sees the sharper operator.
    void velocity_cycle(unsigned int l);
    void pressure_cycle(unsigned int l, bool sharp);

    /// (u, p) ~ matrix^{-1} (f, -g), f and g are used up: the triangle's two inverses, on the
    /// coarser levels first where that is due.
    void stokes_cycle(unsigned int l);

    void factorize_pressure();
    void factorize_velocity();

    unsigned int revision = 0;
    VelocityForm form{0, 0};            // of the equations
    VelocityForm cycled{0, 0};          // what the cycles see of it, augmented
    std::vector<Level> levels;          // the finest first
    bool inertia_counts        = false; // so that the cycle of the pressure is to be sharp
    unsigned int last_velocity = 0;     // the last level that velocity cycles use
    bool direct_velocity       = true;  // they end with a factorisation there

    std::unique_ptr<dealii::SparseDirectUMFPACK> pressure_factor, velocity_factor;
    bool enclosed = false, walls = false;

    // The unknowns of the space: for each of the finest level, and back.
    std::vector<unsigned int> space_velocity, level_velocity, space_pressure;
  };
} // namespace feib

#endif
