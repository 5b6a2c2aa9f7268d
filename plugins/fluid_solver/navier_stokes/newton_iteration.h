// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_newton_iteration_h
#define feib_plugins_navier_stokes_newton_iteration_h

#include "regulated_pressures.h"
#include "residual_norms.h"
#include "stokes_solver.h"

#include <feib/fluid_solver.h>

#include <sstream>

namespace feib
{
  /// The equations of one step, solved by corrections of the state of the space.
  ///
  /// Every step is a residual and its correction: with the boundary values set in the first guess,
  /// the correction obeys homogeneous constraints, and one loop serves the linear step (one
  /// correction), Newton's method and an implicit load.
  template <int dim>
  class NewtonIteration
  {
  public:
    struct Settings
    {
      double tolerance;
      unsigned int max_iterations;
      bool convects;
    };

    /// The state of the space is the first guess. @p fixed_forces: all that does not depend on the
    /// unknowns, not condensed. All must live as long. Collective.
    NewtonIteration(const Settings &settings,
                    FluidOperators<dim> &operators,
                    StokesSolver<dim> &solver,
                    RegulatedPressures<dim> &outlets,
                    EulerianSpace<dim> &space,
                    const typename FluidSolver<dim>::Step &step,
                    const VelocityVector &fixed_forces);

    /// Corrects the state until it obeys the equations to the tolerance. Puts the numbers of
    /// iterations into the report. Collective. Throws RunFailure.
    void run(typename FluidSolver<dim>::Report &report);

    /// The force of the walls where velocity is prescribed, not condensed.
    const VelocityVector &
    reaction() const
    {
      return present.reaction;
    }

  private:
    /// What is left of the equations at a velocity and a pressure.
    struct Residual
    {
      VelocityVector momentum; // condensed
      VelocityVector reaction; // not condensed
      PressureVector divergence;
      ResidualNorms norms;
      double implicit_load = 0;   // norm, condensed
      std::vector<double> fluxes; // through the conditions, if pressures hang on them
    };

    /// The linear equations of a correction.
    StokesEquations<dim> equations() const;

    /// At the state of the space.
    Residual residual();

    bool converged(bool first, double flux) const;

    /// One correction.
    void correct(typename FluidSolver<dim>::Report &report);

    /// Adds the correction, or as much of it as makes a load that is not linear defined and the
    /// residual fall.
    void add(const VelocityVector &du, const PressureVector &dp);

    /// Makes the first guess obey the equations of outlets.
    void start_outlets();

    /// What the divergence is compared with.
    double flux() const;

    /// Why a step is given up.
    std::string not_converged(unsigned int iterations) const;

    const Settings settings;
    FluidOperators<dim> &operators;
    StokesSolver<dim> &solver;
    RegulatedPressures<dim> &outlets;
    EulerianSpace<dim> &space;
    const typename FluidSolver<dim>::Step &step;
    const VelocityVector &fixed_forces;
    const double rate;
    const bool linear;
    const double tighter; // the tolerance of the divergence
    Residual present;
    double scale     = 0; // of the forces
    double last_norm = 0; // of the momentum, before the last correction
    std::ostringstream history;
  };
} // namespace feib

#endif
