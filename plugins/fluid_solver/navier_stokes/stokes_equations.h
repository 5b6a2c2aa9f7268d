// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_stokes_equations_h
#define feib_plugins_navier_stokes_stokes_equations_h

#include "operators/fluid_operators.h"

#include <feib/implicit_load.h>

namespace feib
{
  /// The linear equations of a step, or of a step of Newton's method:
  /// [rate M + viscosity + convection + load  -B^T; -B  0].
  template <int dim>
  struct StokesEquations
  {
    const EulerianSpace<dim> &space;
    const FluidOperators<dim> &operators;
    double rate;                              // 1/dt
    const VelocityVector *velocity = nullptr; // Newton's method has convection here, if any
    double cfl                     = 0;       // of that velocity
    const ImplicitLoad<dim> *load  = nullptr;

    /// r += factor times the derivative of convection along u
    void
    add_convection(const double factor, const VelocityVector &u, VelocityVector &r) const
    {
      operators.convection().add(factor, u, r);
      operators.convection().add_by(factor, u, *velocity, r);
    }
  };
} // namespace feib

#endif
