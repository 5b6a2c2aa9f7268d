// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_fluid_integrals_h
#define feib_plugins_navier_stokes_fluid_integrals_h

#include "cell_operators.h"

#include <feib/fluid_solver.h>

#include <deal.II/base/function.h>

namespace feib
{
  /// Integrals over the fluid of density @p rho at the velocity of the space: energy and momenta of
  /// R u with the R of the operators, divergence and extrema of u. Collective.
  template <int dim>
  typename FluidSolver<dim>::Balance
  fluid_balance(const EulerianSpace<dim> &space, const CellOperators<dim> &operators, double rho);

  /// (f, v) for all v, not condensed; with a @p reconstruction (f, R v). Gauss rules of 4 points
  /// per direction, with R of 8, so that a smooth gradient f does no work on R v beside round-off.
  /// @p force: f [force/volume], at its time. Collective.
  template <int dim>
  VelocityVector load_of_body_force(const EulerianSpace<dim> &space,
                                    const dealii::Function<dim> &force,
                                    const Reconstruction<dim> *reconstruction);
} // namespace feib

#endif
