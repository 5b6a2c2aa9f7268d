// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_time_integrator_coupled_scheme_h
#define feib_plugins_time_integrator_coupled_scheme_h

#include "geometry_iteration.h"
#include "stability_estimate.h"
#include "structure_load.h"

#include <feib/error.h>
#include <feib/time_integrator.h>

#include <algorithm>
#include <cmath>
#include <deque>

namespace feib
{
  /// The schemes of this folder are one step with three choices. With tau = dt for the Euler
  /// schemes and dt/2 for the midpoint schemes, the fluid makes a backward Euler step of length tau
  /// to u_s under the load
  ///   J^T [ F(Y) - M/tau (J u_s - V^n) ],
  /// J taken at the geometry X_g; the structures move by X^{n+1} = X^n + dt J u_s. Midpoint schemes
  /// extrapolate to the end of the step, u^{n+1} = 2 u_s - u^n, V^{n+1} = 2 J u_s - V^n: with tau =
  /// dt/2 this is the midpoint rule (Crank-Nicolson) for the fluid. M is the excess mass.
  ///
  /// | scheme          | X_g                     | Y                    |
  /// |-----------------|-------------------------|----------------------|
  /// | fe_be           | X^n                     | X_g                  |
  /// | lagged_be       | X^n                     | X^n + tau J u_s      |
  /// | be_be           | X^{n+1}                 | X^n + tau J u_s      |
  /// | midpoint        | X^n + dt/2 J(X^n) u^n   | X_g                  |
  /// | lagged_midpoint | X^n + dt/2 J(X^n) u^n   | X^n + tau J u_s      |
  struct SchemeChoices
  {
    bool midpoint;
    bool implicit_force;
    /// Solutions with the geometry of the last one, until it moves less than this part of the
    /// fluid's smallest edge; 0: as many as corrections says.
    double geometry_tolerance = 0;
    unsigned int corrections  = 0;
  };


  template <int dim>
  class CoupledScheme : public TimeIntegrator<dim>
  {
  public:
    using Base           = TimeIntegrator<dim>;
    using System         = typename Base::System;
    using Report         = typename Base::Report;
    using StabilityLimit = typename Base::StabilityLimit;

    explicit CoupledScheme(const SchemeChoices &choices)
      : choices(choices)
    {}

    Report step(System &system, double time, double dt) override;

    StabilityLimit stability_limit(const System &system) const override;

    void
    archive(Archive &archive) override
    {
      archive("past", past);
    }

    std::vector<std::pair<std::string, double>> diagnostics(const System &system,
                                                            double dt) const override;

  private:
    using Configuration = std::vector<Positions<dim>>; // of all structures

    /// X^n + dt/2 J(X^n) u^n, or X^n.
    Configuration first_geometry(System &system, double dt, const Configuration &old) const;

    /// One solution with J at the geometry; space.velocity becomes u_s. The structures' positions
    /// and velocities are left alone.
    void solve(System &system,
               double time,
               double tau,
               const Configuration &geometry,
               Report &report) const;

    /// An estimate of the error dt^3/12 u'' of the midpoint rule, from the second difference of the
    /// velocities half way through the last three steps (which are free of the alternation that the
    /// rule leaves in u^n); of the nodes, or of the fluid when there is no structure. Negative
    /// while there are too few steps.
    double error_estimate(const System &system,
                          double time,
                          double dt,
                          const std::vector<NodalField<dim>> &U);

    /// The pressure that a midpoint scheme has solved for is that of @p middle, half way through
    /// the step; space.pressure becomes that of its @p end.
    static void take_pressure_to_end(EulerianSpace<dim> &space, double middle, double end);

    /// Moves structure s by dt U and adds what that means to the report. J is at @p geometry.
    void move(System &system,
              unsigned int s,
              const Positions<dim> &geometry,
              const NodalField<dim> &U,
              double tau,
              double dt,
              Report &report) const;

    static Body
    body_of(const StructureModel<dim> &model)
    {
      return model.mesh().structure_dim() == dim ? Body::thick
             : dim == 2                          ? Body::curve
                                                 : Body::surface;
    }

    const SchemeChoices choices;

    /// What the structures' nodes did in the last steps, for the error estimate.
    struct Motion
    {
      double time = 0; // half way through the step
      std::vector<NodalField<dim>> velocities;

      void
      archive(Archive &archive)
      {
        archive("time", time);
        archive("velocities", velocities);
      }
    };
    std::deque<Motion> past;
  };


  template <int dim>
  typename CoupledScheme<dim>::Configuration
  CoupledScheme<dim>::first_geometry(System &system,
                                     const double dt,
                                     const Configuration &old) const
  {
    Configuration geometry = old;
    if (choices.midpoint)
      {
        const Timers::Section section(system.timers, "coupling");
        NodalField<dim> U;
        for (unsigned int s = 0; s < old.size(); ++s)
          {
            ImmersedStructure<dim> &structure = system.structures[s];
            structure.motion->set_geometry(system.space,
                                           structure.model->mesh(),
                                           old[s],
                                           structure.nodes);
            structure.motion->interpolate(system.space, system.space.old_velocity, U);
            for (unsigned int i = 0; i < U.size(); ++i)
              geometry[s][i] += dt / 2 * U[i];
          }
      }
    else if (choices.geometry_tolerance > 0)
      for (unsigned int s = 0; s < old.size(); ++s)
        for (unsigned int i = 0; i < old[s].size(); ++i)
          geometry[s][i] += dt * system.structures[s].model->velocities[i];
    return geometry;
  }


  template <int dim>
  void
  CoupledScheme<dim>::solve(System &system,
                            const double time,
                            const double tau,
                            const Configuration &geometry,
                            Report &report) const
  {
    VelocityVector load = system.space.make_velocity();
    StructureLoad<dim> implicit_load(system, tau, choices.implicit_force);
    NodalField<dim> force;
    for (unsigned int s = 0; s < geometry.size(); ++s)
      {
        ImmersedStructure<dim> &structure = system.structures[s];
        if (!choices.implicit_force)
          {
            const Timers::Section section(system.timers, "structure");
            structure.model->load(geometry[s], force);
          }
        const Timers::Section section(system.timers, "coupling");
        structure.set_geometry(system.space, geometry[s]);
        if (!choices.implicit_force)
          structure.spreading().spread(system.space, force, load);
      }
    const Timers::Section section(system.timers, "fluid");
    const auto fluid = system.fluid.advance(
      system.space, {time + tau, tau, load, implicit_load.empty() ? nullptr : &implicit_load});
    report.linear_iterations += fluid.linear_iterations;
    report.nonlinear_iterations += fluid.nonlinear_iterations;
    report.dissipated    = fluid.dissipation;
    report.convected     = fluid.convection_power;
    report.boundary_work = fluid.boundary_power;
    report.body_work     = fluid.body_force_power;
    report.numerical     = fluid.increment_energy;
  }


  template <int dim>
  typename CoupledScheme<dim>::Report
  CoupledScheme<dim>::step(System &system, const double time, const double dt)
  {
    EulerianSpace<dim> &space = system.space;
    const double tau          = choices.midpoint ? dt / 2 : dt;
    const unsigned int n      = system.structures.size();

    Configuration old;
    for (const ImmersedStructure<dim> &structure : system.structures)
      old.push_back(structure.model->positions);
    Configuration geometry = first_geometry(system, dt, old);

    // What the structures do under u_s.
    std::vector<NodalField<dim>> U(n);
    const auto interpolate = [&] {
      const Timers::Section section(system.timers, "coupling");
      for (unsigned int s = 0; s < n; ++s)
        system.structures[s].motion->interpolate(space, space.velocity, U[s]);
    };
    // Where J should have been taken.
    const auto better_geometry = [&] {
      Configuration better = old;
      for (unsigned int s = 0; s < n; ++s)
        for (unsigned int i = 0; i < U[s].size(); ++i)
          better[s][i] += tau * U[s][i];
      return better;
    };

    Report report;
    solve(system, time, tau, geometry, report);
    interpolate();
    if (choices.geometry_tolerance > 0)
      {
        GeometryIteration<dim> iteration(choices.geometry_tolerance * space.smallest_edge());
        while (!iteration.converged(geometry, better_geometry()))
          {
            geometry = iteration.next();
            solve(system, time, tau, geometry, report);
            interpolate();
            ++report.geometry_iterations;
          }
      }
    else
      for (unsigned int i = 0; i < choices.corrections; ++i)
        {
          geometry = better_geometry();
          solve(system, time, tau, geometry, report);
          interpolate();
          ++report.geometry_iterations;
        }

    // From powers at u_s to energies of the step. The midpoint rule loses nothing to inertia.
    report.dissipated *= dt;
    report.convected *= dt;
    report.boundary_work *= dt;
    report.body_work *= dt;
    if (choices.midpoint)
      report.numerical = 0;

    const Timers::Section section(system.timers, "accounting");
    if (choices.midpoint)
      report.displacement_error = error_estimate(system, time, dt, U);
    for (unsigned int s = 0; s < n; ++s)
      move(system, s, geometry[s], U[s], tau, dt, report);

    if (choices.midpoint)
      {
        space.velocity.zero_out_ghost_values();
        space.velocity.sadd(2., -1., space.old_velocity);
        space.velocity.update_ghost_values();
        take_pressure_to_end(space, time + dt / 2, time + dt);
      }
    return report;
  }


  template <int dim>
  void
  CoupledScheme<dim>::take_pressure_to_end(EulerianSpace<dim> &space,
                                           const double middle,
                                           const double end)
  {
    auto &earlier          = space.earlier_pressures;
    const PressureVector p = space.pressure;
    if (earlier.size() == 2)
      {
        // The straight line through the last three, so weighted that what alternates from step to
        // step drops out: 1, 1/2 and -1/2 for equal steps.
        const double d_0 = end - middle, d_1 = end - earlier[0].time, d_2 = end - earlier[1].time;
        const double weight = (d_1 + d_2) / (d_2 - d_0) / 2;
        space.pressure.zero_out_ghost_values();
        space.pressure.sadd(weight, .5, earlier[0].values);
        space.pressure.add(.5 - weight, earlier[1].values);
        space.pressure.update_ghost_values();
      }
    earlier.push_front({middle, p});
    if (earlier.size() > 2)
      earlier.pop_back();
  }


  template <int dim>
  double
  CoupledScheme<dim>::error_estimate(const System &system,
                                     const double time,
                                     const double dt,
                                     const std::vector<NodalField<dim>> &U)
  {
    const EulerianSpace<dim> &space = system.space;
    if (U.empty())
      {
        // u_s less the extrapolation of u^n and u^{n-1} is tau (tau + old dt)/2 u''.
        if (!(space.old_dt > 0))
          return std::numeric_limits<double>::infinity();
        const double tau = dt / 2, ratio = tau / space.old_dt;
        VelocityVector difference = space.velocity;
        difference.zero_out_ghost_values();
        difference.add(-1 - ratio, space.old_velocity, ratio, space.older_velocity);
        return dt * dt * dt / 6 * difference.linfty_norm() / (tau * (tau + space.old_dt));
      }

    const double middle = time + dt / 2;
    double result       = std::numeric_limits<double>::infinity();
    if (past.size() >= 2)
      {
        const Motion &last = past.back(), &before = past[past.size() - 2];
        // Divided by (t - t_1)(t - t_2), the difference to the line through the past is u''/2.
        const double t_1 = last.time, t_2 = before.time;
        const double ratio = (middle - t_1) / (t_1 - t_2);
        double largest     = 0;
        for (unsigned int s = 0; s < U.size(); ++s)
          for (unsigned int i = 0; i < U[s].size(); ++i)
            largest = std::max(largest,
                               (U[s][i] - (1 + ratio) * last.velocities[s][i] +
                                ratio * before.velocities[s][i])
                                 .norm());
        result = dt * dt * dt / 6 * largest / ((middle - t_1) * (middle - t_2));
      }
    past.push_back({middle, U});
    if (past.size() > 2)
      past.pop_front();
    return result;
  }


  template <int dim>
  void
  CoupledScheme<dim>::move(System &system,
                           const unsigned int s,
                           const Positions<dim> &geometry,
                           const NodalField<dim> &U,
                           const double tau,
                           const double dt,
                           Report &report) const
  {
    const ImmersedStructure<dim> &structure = system.structures[s];
    StructureModel<dim> &model              = *structure.model;
    const std::vector<double> &mass         = model.excess_mass();
    const Positions<dim> old                = model.positions;
    const auto displaced                    = [&](const Positions<dim> &X, const double factor) {
      Positions<dim> result = X;
      for (unsigned int i = 0; i < U.size(); ++i)
        result[i] += factor * U[i];
      return result;
    };

    typename Base::Exchange exchange;
    const auto add = [&](const dealii::Tensor<1, dim> &force,
                         const dealii::Point<dim> &x,
                         const dealii::Tensor<1, dim> &velocity) {
      exchange.power += force * velocity;
      exchange.force += force;
      exchange.torque[2] += x[0] * force[1] - x[1] * force[0];
      if constexpr (dim == 3)
        {
          exchange.torque[0] += x[1] * force[2] - x[2] * force[1];
          exchange.torque[1] += x[2] * force[0] - x[0] * force[2];
        }
    };

    // The elastic force that acted, at its points.
    NodalField<dim> force, velocity = U;
    model.load(choices.implicit_force ? displaced(old, tau) : geometry, force);
    if (structure.loading)
      structure.loading->interpolate(system.space, system.space.velocity, velocity);
    const Positions<dim> points = model.load_points().positions(geometry);
    for (unsigned int q = 0; q < force.size(); ++q)
      add(force[q], points[q], velocity[q]);

    // The work of the elastic force, the work along the way of the step (by two Gauss points, exact
    // where the energy is a polynomial of degree 4), and the energy it comes from.
    model.positions  = displaced(old, dt);
    const double way = model.energy(old) - model.energy(model.positions);
    double work      = way;
    if (model.conservative())
      {
        work = 0;
        for (const double theta : {.5 - std::sqrt(1. / 12), .5 + std::sqrt(1. / 12)})
          {
            model.load(displaced(old, theta * dt), force);
            for (unsigned int q = 0; q < force.size(); ++q)
              work += dt / 2 * (force[q] * velocity[q]);
          }
      }
    exchange.numerical    = work - dt * exchange.power;
    exchange.unexplained  = way - work;
    exchange.elastic_work = std::abs(work);

    for (unsigned int i = 0; i < U.size(); ++i)
      {
        const dealii::Tensor<1, dim> change = U[i] - model.velocities[i];
        if (!mass.empty())
          {
            add(-mass[i] / tau * change, geometry[i], U[i]);
            if (!choices.midpoint)
              exchange.numerical += mass[i] / 2 * change.norm_square();
          }
        model.velocities[i] += (choices.midpoint ? 2. : 1.) * change;
      }

    // dt A'(geometry)[U]: A is a polynomial of degree dim in the positions.
    const auto A = [&](const double factor) { return model.measure(displaced(geometry, factor)); };
    if (model.mesh().structure_dim() == dim || model.mesh().closed())
      exchange.leak =
        dim == 2 ? (A(dt) - A(-dt)) / 2 : (8 * (A(dt) - A(-dt)) - (A(2 * dt) - A(-2 * dt))) / 12;
    report.numerical += exchange.numerical;
    report.unexplained += exchange.unexplained;
    report.exchanges.push_back(exchange);
  }


  template <int dim>
  typename CoupledScheme<dim>::StabilityLimit
  CoupledScheme<dim>::stability_limit(const System &system) const
  {
    StabilityLimit result;
    if (!choices.implicit_force)
      for (const ImmersedStructure<dim> &structure : system.structures)
        {
          const StructureModel<dim> &model = *structure.model;
          const double dt                  = stable_step(structure_scales(model, model.positions),
                                        body_of(model),
                                        choices.midpoint,
                                        system.fluid.density(),
                                        system.fluid.viscosity(),
                                        system.space.smallest_edge());
          if (dt < result.dt)
            result = {dt, model.name(), choices.midpoint ? "lagged_midpoint" : "lagged_be"};
        }
    return result;
  }


  template <int dim>
  std::vector<std::pair<std::string, double>>
  CoupledScheme<dim>::diagnostics(const System &system, const double dt) const
  {
    std::vector<std::pair<std::string, double>> result;
    if (choices.implicit_force)
      return result;
    const double h_x = system.space.smallest_edge();
    result.emplace_back("h_x", h_x);
    for (const ImmersedStructure<dim> &structure : system.structures)
      {
        const StructureModel<dim> &model = *structure.model;
        const unsigned int m             = model.mesh().structure_dim();
        const double h_s                 = model.mesh().diameter();
        const StructureScales scales     = structure_scales(model, model.positions);
        const double limit               = stable_step(scales,
                                         body_of(model),
                                         choices.midpoint,
                                         system.fluid.density(),
                                         system.fluid.viscosity(),
                                         h_x);
        result.emplace_back("h_s_" + model.name(), h_s);
        result.emplace_back("longest_edge_" + model.name(), scales.longest_edge);
        result.emplace_back("kappa_" + model.name(), scales.kappa);
        // -mu_a of the energy estimate with C = 1.
        result.emplace_back("eta_" + model.name(),
                            scales.kappa * std::pow(h_s, int(m) - 2) * dt * scales.longest_edge /
                              std::pow(h_x, dim - 1));
        result.emplace_back("dt_limit_" + model.name(), std::min(limit, 1e12));
      }
    return result;
  }
} // namespace feib

#endif
