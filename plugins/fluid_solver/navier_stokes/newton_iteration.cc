// SPDX-License-Identifier: LGPL-2.1-or-later
#include "newton_iteration.h"

#include <feib/error.h>
#include <feib/message.h>

#include <algorithm>
#include <cmath>
#include <iomanip>

namespace feib
{
  template <int dim>
  NewtonIteration<dim>::NewtonIteration(const Settings &settings,
                                        FluidOperators<dim> &operators,
                                        StokesSolver<dim> &solver,
                                        RegulatedPressures<dim> &outlets,
                                        EulerianSpace<dim> &space,
                                        const typename FluidSolver<dim>::Step &step,
                                        const VelocityVector &fixed_forces)
    : settings(settings)
    , operators(operators)
    , solver(solver)
    , outlets(outlets)
    , space(space)
    , step(step)
    , fixed_forces(fixed_forces)
    , rate(1 / step.dt)
    , linear(!settings.convects && (!step.implicit_load || step.implicit_load->linear()))
    // What is left of the divergence moves what structures enclose, and costs little to lower.
    , tighter(settings.convects ? 4 : 1)
  {
    if (!outlets.empty())
      start_outlets();
    VelocityVector condensed = fixed_forces;
    outlets.add_load(condensed);
    space.condense(condensed);
    present = residual();
    scale   = std::max({condensed.l2_norm(), present.implicit_load, present.norms.momentum});
    // Forces that move nothing by more than round-off of a cell's size in the step are none, as
    // those of a body at rest are what cancels in it.
    const double h = space.smallest_edge();
    if (scale > 0)
      scale = std::max(scale,
                       1e-15 / settings.tolerance * operators.terms().rho *
                         std::pow(h, int(dim) + 1) * rate * rate);
    history << std::setprecision(2);
  }


  template <int dim>
  typename NewtonIteration<dim>::Residual
  NewtonIteration<dim>::residual()
  {
    Residual result;
    result.momentum   = space.make_velocity();
    result.divergence = space.make_pressure();
    operators.subtract_stokes(
      rate, space.velocity, space.pressure, result.momentum, result.divergence);
    if (settings.convects)
      {
        operators.convection().set_velocity(space.velocity);
        operators.convection().add(-1., space.velocity, result.momentum);
      }
    result.momentum.compress(dealii::VectorOperation::add);
    result.divergence.compress(dealii::VectorOperation::add);
    result.momentum += fixed_forces;
    outlets.add_load(result.momentum);
    if (!outlets.empty())
      result.fluxes = outlets.fluxes(space);
    if (step.implicit_load)
      {
        VelocityVector load = space.make_velocity();
        step.implicit_load->evaluate(space.velocity, load);
        result.momentum += load;
        space.condense(load);
        result.implicit_load = std::max(load.l2_norm(), step.implicit_load->largest_part());
      }
    // Where the velocity is prescribed, what is left over is the reaction; elsewhere nothing is.
    result.reaction = result.momentum;
    space.condense(result.momentum);
    result.norms = residual_norms(space, result.momentum, result.divergence);
    if (!std::isfinite(result.norms.momentum) || !std::isfinite(result.norms.divergence))
      throw RunFailure("the fluid's residual is not finite at time " + readable(step.time));
    return result;
  }


  template <int dim>
  double
  NewtonIteration<dim>::flux() const
  {
    return relevant_flux(space, operators.terms(), rate, present.norms, scale);
  }


  template <int dim>
  bool
  NewtonIteration<dim>::converged(const bool first, const double flux) const
  {
    const ResidualNorms &norms = present.norms;
    const double of_outlets    = outlets.residual(present.fluxes, flux);
    // The divergence is a linear equation: any correction solves it as far as round-off allows.
    return first ? scale == 0. && norms.divergence == 0. && of_outlets == 0.
                 : norms.momentum <= settings.tolerance * scale &&
                     norms.divergence <= settings.tolerance / tighter * flux &&
                     of_outlets <= settings.tolerance;
  }


  template <int dim>
  void
  NewtonIteration<dim>::run(typename FluidSolver<dim>::Report &report)
  {
    while (true)
      {
        const bool first     = report.nonlinear_iterations == 0;
        const double of_flux = flux();
        history << (first ? "" : ", ") << present.norms.momentum / scale;
        if (of_flux > 0)
          history << " (" << present.norms.divergence / of_flux << ")";
        if (converged(first, of_flux))
          return;
        constexpr double hopeless = 1e4; // times the forces
        if (report.nonlinear_iterations >= settings.max_iterations ||
            present.norms.momentum > hopeless * scale)
          throw RunFailure(not_converged(report.nonlinear_iterations));
        correct(report);
      }
  }


  template <int dim>
  void
  NewtonIteration<dim>::correct(typename FluidSolver<dim>::Report &report)
  {
    const ResidualNorms &norms = present.norms;
    // A linear problem is solved at once; Newton's method converges quadratically while each linear
    // residual is the square of the nonlinear one.
    const double target =
      std::max((linear ? .3 : .1) * settings.tolerance * scale,
               (linear ? 1e-13 : std::min(1e-4, .02 * norms.momentum / scale)) * norms.momentum);
    const double weight = norms.divergence_scale > 0
                            ? tighter * scale / flux()
                            : impedance<dim>(operators.terms(), space.smallest_edge(), rate);
    // Where Newton's method is slow, what the fluid answers may have changed.
    if (!linear && last_norm > 0 && norms.momentum > .1 * last_norm)
      outlets.forget();
    last_norm         = norms.momentum;
    VelocityVector du = space.make_velocity();
    PressureVector dp = space.make_pressure();
    report.linear_iterations +=
      solver.solve(equations(), present.momentum, present.divergence, weight, target, du, dp);
    ++report.nonlinear_iterations;
    space.distribute(du, true);
    dp.update_ghost_values();
    report.linear_iterations += outlets.correct(space, equations(), solver, du, dp);
    add(du, dp);
  }


  template <int dim>
  StokesEquations<dim>
  NewtonIteration<dim>::equations() const
  {
    return {space,
            operators,
            rate,
            settings.convects ? &space.velocity : nullptr,
            settings.convects ? operators.cfl_rate(space.velocity) * step.dt : 0.,
            step.implicit_load};
  }


  template <int dim>
  void
  NewtonIteration<dim>::start_outlets()
  {
    // The answers of the fluid are those of equations at the first guess.
    if (settings.convects)
      operators.convection().set_velocity(space.velocity);
    if (step.implicit_load)
      {
        VelocityVector load = space.make_velocity();
        step.implicit_load->evaluate(space.velocity, load);
      }
    VelocityVector du = space.make_velocity();
    PressureVector dp = space.make_pressure();
    outlets.correct(space, equations(), solver, du, dp);
    space.velocity.zero_out_ghost_values();
    space.pressure.zero_out_ghost_values();
    space.velocity += du;
    space.pressure += dp;
    space.distribute(space.velocity, false);
    space.pressure.update_ghost_values();
    outlets.add(1.);
  }


  template <int dim>
  void
  NewtonIteration<dim>::add(const VelocityVector &du, const PressureVector &dp)
  {
    const double before       = present.norms.momentum;
    constexpr double shortest = 1. / 32;
    for (double length = 1, taken = 0;; length /= 2)
      {
        space.velocity.zero_out_ghost_values();
        space.pressure.zero_out_ghost_values();
        space.velocity.add(length - taken, du);
        space.pressure.add(length - taken, dp);
        outlets.add(length - taken);
        taken = length;
        if (space.domain().enclosed())
          remove_mean_pressure(space);
        space.distribute(space.velocity, false);
        space.pressure.update_ghost_values();
        try
          {
            present = residual();
            if (linear || !step.implicit_load || length <= shortest ||
                present.norms.momentum <=
                  std::max(settings.tolerance * scale, (1 - .1 * length) * before))
              return;
          }
        catch (const RunFailure &)
          {
            if (linear || length <= shortest)
              throw;
          }
      }
  }


  template <int dim>
  std::string
  NewtonIteration<dim>::not_converged(const unsigned int iterations) const
  {
    std::ostringstream text;
    text << std::setprecision(3) << "the fluid step to time " << step.time
         << " did not reach its tolerance in " << iterations
         << " iterations; relative residuals of momentum (and divergence): " << history.str();
    if (settings.convects)
      text << "; convection had a CFL number of "
           << operators.cfl_rate(space.old_velocity) * step.dt;
    return text.str();
  }


  template class NewtonIteration<2>;
  template class NewtonIteration<3>;
} // namespace feib
