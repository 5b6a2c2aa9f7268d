// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_stokes_multigrid_h
#define feib_plugins_navier_stokes_stokes_multigrid_h

#include "multigrid/finest_level_map.h"
#include "multigrid/pressure_cycle.h"
#include "multigrid/velocity_cycle.h"

#include <memory>
#include <string>

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
    /// What depends on the mesh alone.
    struct Mesh
    {
      explicit Mesh(const EulerianSpace<dim> &space);

      Hierarchy<dim> hierarchy;
      FinestLevelMap<dim> map;
      VelocityCycle<dim> velocity;
      PressureCycle<dim> pressure;
      bool walls;
    };

    /// What a level adds where the coarser one corrects first.
    struct Correction
    {
      LevelVector<float> u, p;
    };

    /// What the cycle of the velocity sees of a form.
    VelocityForm form_of_cycle(const VelocityForm &wanted, bool augmented) const;

    /// On which levels the coarser one is to correct first. Beside walls the Schur complement of a
    /// viscous flow has more than S^{-1} knows of.
    void choose_corrections();

    /// (u, p) ~ matrix^{-1} (f, -g), f and g are used up: the triangle's two inverses, on the
    /// coarser levels first where that is due.
    void apply(unsigned int l);

    /// The correction by the coarser levels; f and g become what it leaves of the equations.
    void correct_first(unsigned int l);

    unsigned int revision = 0;
    std::unique_ptr<Mesh> mesh;
    VelocityForm form{0, 0};     // of the equations
    VelocityForm cycled{0, 0};   // what the cycles see of it, augmented
    bool inertia_counts = false; // so that the cycle of the pressure is to be sharp
    std::vector<bool> coarser_first;
    std::vector<Correction> corrections;
  };
} // namespace feib

#endif
