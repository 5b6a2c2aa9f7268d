// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_convective_blocks_h
#define feib_plugins_navier_stokes_convective_blocks_h

#include "multigrid/stokes_multigrid.h"
#include "stokes_equations.h"

namespace feib
{
  /// A preconditioner like StokesMultigrid with convection in its blocks, for large steps: the
  /// velocity's with a few iterations of GMRES around the cycle without convection, and the
  /// least-squares commutator of Elman, Howle, Shadid, Shuttleworth and Tuminaro (2006) for the
  /// Schur complement,
  ///   S^{-1} = Lp^{-1} (B Ml^{-1} F Ml^{-1} B^T) Lp^{-1}.
  template <int dim>
  class ConvectiveBlocks
  {
  public:
    ConvectiveBlocks(const StokesEquations<dim> &equations, StokesMultigrid<dim> &multigrid)
      : equations(equations)
      , multigrid(multigrid)
    {}

    /// (u, p) ~ matrix^{-1} (f, g) for condensed f. Collective.
    void
    solve(const VelocityVector &f, const PressureVector &g, VelocityVector &u, PressureVector &p);

    /// dst = F src
    void vmult(VelocityVector &dst, const VelocityVector &src) const;

  private:
    /// r = B^T p, condensed
    void apply_gradient(const PressureVector &p, VelocityVector &r) const;

    const StokesEquations<dim> &equations;
    StokesMultigrid<dim> &multigrid;
  };
} // namespace feib

#endif
