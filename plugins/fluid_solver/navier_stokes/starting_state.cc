// SPDX-License-Identifier: LGPL-2.1-or-later
#include "starting_state.h"

#include "residual_norms.h"

#include <algorithm>

namespace feib
{
  template <int dim>
  StartingState<dim>::StartingState(FluidOperators<dim> &operators,
                                    StokesSolver<dim> &solver,
                                    const RegulatedPressures<dim> &outlets,
                                    const double tolerance,
                                    const bool convects)
    : operators(operators)
    , inertia({operators.terms().rho, 0., 0., false, ConvectiveForm::rotational})
    , solver(solver)
    , outlets(outlets)
    , tolerance(tolerance)
    , convects(convects)
  {}


  template <int dim>
  void
  StartingState<dim>::reinit(const EulerianSpace<dim> &space)
  {
    inertia.reinit(space);
  }


  template <int dim>
  void
  StartingState<dim>::project(EulerianSpace<dim> &space, ImplicitLoad<dim> *const masses)
  {
    const double of_flux = impedance<dim>(inertia.terms(), space.smallest_edge(), rate);
    space.distribute(space.velocity, false);
    const std::vector<double> wanted = outlets.wanted_fluxes(space);
    VelocityVector given = space.velocity, du = space.make_velocity();
    given.update_ghost_values();
    PressureVector multiplier = space.make_pressure(), dp = space.make_pressure();
    double scale = 0;
    for (unsigned int pass = 0; pass < 2; ++pass)
      {
        VelocityVector r = space.make_velocity(), load = space.make_velocity();
        PressureVector g = space.make_pressure();
        inertia.add_velocity_form(rate, 0., given, r);
        inertia.subtract_stokes(rate, space.velocity, multiplier, r, g);
        r.compress(dealii::VectorOperation::add);
        g.compress(dealii::VectorOperation::add);
        if (masses)
          masses->evaluate(space.velocity, load);
        r += load;
        space.condense(r);
        const ResidualNorms norms = residual_norms(space, r, g);
        if (pass == 0)
          scale = std::max(norms.momentum, of_flux * norms.divergence_scale);
        const double flux = std::max(norms.divergence_scale, least_flux * scale / of_flux);
        if (norms.momentum <= tolerance * scale && norms.divergence <= tolerance * flux)
          break;
        solver.solve({space, inertia, rate, nullptr, 0., masses},
                     r,
                     g,
                     scale / flux,
                     .5 * tolerance * scale,
                     du,
                     dp);
        space.distribute(du, true);
        space.velocity.zero_out_ghost_values();
        space.velocity += du;
        space.distribute(space.velocity, false);
        multiplier.zero_out_ghost_values();
        multiplier += dp;
        multiplier.update_ghost_values();
      }
    // By the change that pressures at these faces make at once.
    outlets.adjust(
      space, wanted, {space, inertia, rate, nullptr, 0., masses}, solver, space.velocity);
  }


  template <int dim>
  VelocityVector
  StartingState<dim>::boundary_acceleration(EulerianSpace<dim> &space,
                                            const double time,
                                            const double dt) const
  {
    VelocityVector acceleration = space.velocity;
    space.set_time(time + dt);
    space.distribute(acceleration, false);
    space.set_time(time);
    acceleration.zero_out_ghost_values();
    acceleration.add(-1., space.velocity);
    acceleration *= 1 / dt;
    acceleration.update_ghost_values();
    space.velocity.update_ghost_values();
    return acceleration;
  }


  template <int dim>
  void
  StartingState<dim>::find_pressure(EulerianSpace<dim> &space,
                                    const typename FluidSolver<dim>::Step &step,
                                    const VelocityVector &forces)
  {
    VelocityVector acceleration = boundary_acceleration(space, step.time, step.dt);
    VelocityVector opposed      = space.make_velocity();
    PressureVector g            = space.make_pressure();
    operators.add_velocity_form(0., 1., space.velocity, opposed);
    if (convects)
      {
        operators.convection().set_velocity(space.velocity);
        operators.convection().add(1., space.velocity, opposed);
      }
    inertia.add_velocity_form(rate, 0., acceleration, opposed);
    inertia.add_divergence(acceleration, g);
    opposed.compress(dealii::VectorOperation::add);
    g.compress(dealii::VectorOperation::add);
    if (step.implicit_load)
      step.implicit_load->apply(opposed, acceleration);
    VelocityVector r = forces;
    r -= opposed;
    space.condense(r);
    const double of_flux = impedance<dim>(inertia.terms(), space.smallest_edge(), rate);
    const double scale   = std::max(r.l2_norm(), of_flux * g.l2_norm());
    space.pressure       = 0.;
    if (scale > 0)
      solver.solve({space, inertia, rate, nullptr, 0., step.implicit_load},
                   r,
                   g,
                   of_flux,
                   .1 * tolerance * scale,
                   acceleration,
                   space.pressure);
  }


  template class StartingState<2>;
  template class StartingState<3>;
} // namespace feib
