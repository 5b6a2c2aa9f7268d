// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_residual_norms_h
#define feib_plugins_navier_stokes_residual_norms_h

#include "operators/fluid_operators.h"

namespace feib
{
  /// The sizes of what is left of the equations, and of what their second row is made of.
  struct ResidualNorms
  {
    double momentum = 0, divergence = 0;
    double divergence_scale = 0; // the fluxes through the cells
  };

  /// At the velocity of the space; @p r is condensed. Collective.
  template <int dim>
  ResidualNorms
  residual_norms(const EulerianSpace<dim> &space, const VelocityVector &r, const PressureVector &g);

  /// The force per flux that stops it in a time 1 / rate, by dimensions, for cells of size @p h.
  template <int dim>
  double
  impedance(const typename FluidOperators<dim>::Terms &terms, const double h, const double rate)
  {
    return terms.rho * rate * h + terms.mu / h;
  }

  /// Cycles in single precision tell fluxes from such fractions of what forces could cause, not
  /// from much smaller ones.
  constexpr double least_flux = 1e-4;

  /// What the divergence is compared with: the fluxes, unless they are next to nothing beside what
  /// momentum of the size @p scale could cause.
  template <int dim>
  double relevant_flux(const EulerianSpace<dim> &space,
                       const typename FluidOperators<dim>::Terms &terms,
                       double rate,
                       const ResidualNorms &norms,
                       double scale);

  /// Takes its mean off the pressure. Collective.
  template <int dim>
  void remove_mean_pressure(EulerianSpace<dim> &space);
} // namespace feib

#endif
