// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_starting_state_h
#define feib_plugins_navier_stokes_starting_state_h

#include "operators/fluid_operators.h"
#include "regulated_pressures.h"

#include <feib/implicit_load.h>

namespace feib
{
  /// Makes a state that no step led to one of the flow, by the equations of a step whose unknowns
  /// have inertia alone.
  template <int dim>
  class StartingState
  {
  public:
    /// @p operators, those of the flow, and @p solver must live as long.
    StartingState(FluidOperators<dim> &operators,
                  StokesSolver<dim> &solver,
                  const RegulatedPressures<dim> &outlets,
                  double tolerance,
                  bool convects);

    /// For the present mesh of the space.
    void reinit(const EulerianSpace<dim> &space);

    /// The discretely divergence-free velocity nearest to that of the space, in the energy of the
    /// fluid and of excess @p masses, if any, with the fluxes that are wanted where they are
    /// prescribed. Collective. Throws RunFailure.
    void project(EulerianSpace<dim> &space, ImplicitLoad<dim> *masses);

    /// What FluidSolver::find_pressure() does, given all @p forces that do not depend on the
    /// velocity, not condensed; the pressure is that of the equations. Collective. Throws
    /// RunFailure.
    void find_pressure(EulerianSpace<dim> &space,
                       const typename FluidSolver<dim>::Step &step,
                       const VelocityVector &forces);

  private:
    /// How prescribed values change in a step.
    VelocityVector boundary_acceleration(EulerianSpace<dim> &space, double time, double dt) const;

    static constexpr double rate = 1; // the unknown of these equations is an acceleration

    FluidOperators<dim> &operators;
    FluidOperators<dim> inertia; // without viscosity
    StokesSolver<dim> &solver;
    const RegulatedPressures<dim> &outlets;
    const double tolerance;
    const bool convects;
  };
} // namespace feib

#endif
