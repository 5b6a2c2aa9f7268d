// SPDX-License-Identifier: LGPL-2.1-or-later
#include "structure_step.h"

#include <feib/time_integrator/coupled_scheme.h>
#include <feib/time_integrator/geometry_iteration.h>
#include <feib/time_integrator/stability_estimate.h>
#include <feib/time_integrator/structure_load.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    /// Where J should have been taken.
    template <int dim>
    std::vector<Positions<dim>>
    better_geometry(const std::vector<ImmersedStructure<dim>> &structures,
                    const double tau,
                    const std::vector<NodalField<dim>> &velocities)
    {
      std::vector<Positions<dim>> better;
      for (unsigned int s = 0; s < structures.size(); ++s)
        {
          better.push_back(structures[s].model->positions);
          for (unsigned int i = 0; i < velocities[s].size(); ++i)
            better[s][i] += tau * velocities[s][i];
        }
      return better;
    }


    /// The pressure that a midpoint scheme has solved for is that of @p middle, half way through
    /// the step; space.pressure becomes that of its @p end.
    template <int dim>
    void
    take_pressure_to_end(EulerianSpace<dim> &space, const double middle, const double end)
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
  } // namespace


  template <int dim>
  CoupledScheme<dim>::CoupledScheme(const SchemeChoices &choices)
    : choices(choices)
  {}


  template <int dim>
  void
  CoupledScheme<dim>::archive(Archive &archive)
  {
    archive("error_estimate", error_estimate);
  }


  template <int dim>
  typename CoupledScheme<dim>::Configuration
  CoupledScheme<dim>::first_geometry(System &system, const double dt) const
  {
    Configuration geometry;
    for (const ImmersedStructure<dim> &structure : system.structures)
      geometry.push_back(structure.model->positions);
    if (choices.midpoint)
      {
        const Timers::Section section(system.timers, "coupling");
        NodalField<dim> U;
        for (unsigned int s = 0; s < geometry.size(); ++s)
          {
            const ImmersedStructure<dim> &structure = system.structures[s];
            structure.motion->set_geometry(system.space,
                                           structure.model->mesh(),
                                           structure.model->positions,
                                           structure.nodes);
            structure.motion->interpolate(system.space, system.space.old_velocity, U);
            for (unsigned int i = 0; i < U.size(); ++i)
              geometry[s][i] += dt / 2 * U[i];
          }
      }
    else if (choices.geometry_tolerance > 0)
      for (unsigned int s = 0; s < geometry.size(); ++s)
        for (unsigned int i = 0; i < geometry[s].size(); ++i)
          geometry[s][i] += dt * system.structures[s].model->velocities[i];
    return geometry;
  }


  template <int dim>
  typename CoupledScheme<dim>::Solution
  CoupledScheme<dim>::solve(System &system,
                            const double time,
                            const double tau,
                            const Configuration &geometry,
                            Report &report) const
  {
    VelocityVector load = system.space.make_velocity();
    StructureLoad<dim> implicit_load(system, tau, geometry, choices.implicit_force);
    const std::vector<NodalField<dim>> none(geometry.size());
    Solution solution{geometry, geometry, none, none, none};
    for (unsigned int s = 0; s < geometry.size(); ++s)
      {
        const ImmersedStructure<dim> &structure = system.structures[s];
        if (!choices.implicit_force)
          {
            const Timers::Section section(system.timers, "structure");
            structure.model->load(geometry[s], solution.forces[s]);
          }
        const Timers::Section section(system.timers, "coupling");
        structure.set_geometry(system.space, geometry[s]);
        if (!choices.implicit_force)
          structure.spreading().spread(system.space, solution.forces[s], load);
        if (structure.model->external())
          {
            structure.model->external_load(geometry[s], solution.other_forces[s]);
            structure.spreading().spread(system.space, solution.other_forces[s], load);
          }
      }
    {
      const Timers::Section section(system.timers, "fluid");
      const auto fluid = system.fluid.advance(system.space,
                                              {time + tau,
                                               tau,
                                               load,
                                               implicit_load.empty() ? nullptr : &implicit_load,
                                               choices.midpoint ? tau : 0.});
      report.linear_iterations += fluid.linear_iterations;
      report.nonlinear_iterations += fluid.nonlinear_iterations;
      report.dissipated    = fluid.dissipation;
      report.convected     = fluid.convection_power;
      report.boundary_work = fluid.boundary_power;
      report.body_work     = fluid.body_force_power;
      report.boundary      = fluid.boundary;
      report.numerical     = fluid.increment_energy;
    }
    const Timers::Section section(system.timers, "coupling");
    for (unsigned int s = 0; s < geometry.size(); ++s)
      {
        const ImmersedStructure<dim> &structure = system.structures[s];
        const NodalField<dim> &U                = solution.velocities[s];
        structure.motion->interpolate(system.space, system.space.velocity, solution.velocities[s]);
        if (choices.implicit_force)
          {
            solution.loaded[s] = implicit_load.moved_by(s, U);
            solution.forces[s] = implicit_load.elastic_force(s, U);
          }
        if (structure.model->viscous())
          {
            NodalField<dim> viscous, &others = solution.other_forces[s];
            structure.model->viscous_load(geometry[s], U, viscous);
            for (unsigned int q = 0; q < others.size(); ++q)
              viscous[q] += others[q];
            others = std::move(viscous);
          }
      }
    return solution;
  }


  template <int dim>
  typename CoupledScheme<dim>::Solution
  CoupledScheme<dim>::find_geometry(System &system,
                                    const double time,
                                    const double dt,
                                    Report &report) const
  {
    const double tau  = choices.midpoint ? dt / 2 : dt;
    Solution solution = solve(system, time, tau, first_geometry(system, dt), report);
    const auto better = [&] {
      return better_geometry<dim>(system.structures, tau, solution.velocities);
    };
    const auto solve_again = [&](const Configuration &geometry) {
      solution = solve(system, time, tau, geometry, report);
      ++report.geometry_iterations;
    };
    if (choices.geometry_tolerance > 0)
      {
        GeometryIteration<dim> iteration(choices.geometry_tolerance * system.space.smallest_edge());
        while (!iteration.converged(solution.geometry, better()))
          solve_again(iteration.next());
      }
    else
      for (unsigned int i = 0; i < choices.corrections; ++i)
        solve_again(better());
    return solution;
  }


  template <int dim>
  std::vector<double>
  CoupledScheme<dim>::begin_structures(System &system, const double time, const double dt) const
  {
    const double elapsed = choices.midpoint ? dt / 2 : choices.implicit_force ? dt : 0.;
    std::vector<double> energies;
    for (const ImmersedStructure<dim> &structure : system.structures)
      {
        energies.push_back(structure.model->energy(structure.model->positions));
        structure.model->set_moment(time + elapsed, elapsed);
      }
    return energies;
  }


  template <int dim>
  typename CoupledScheme<dim>::Report
  CoupledScheme<dim>::step(System &system, const double time, const double dt)
  {
    EulerianSpace<dim> &space = system.space;
    Report report;
    const std::vector<double> energies = begin_structures(system, time, dt);
    const Solution solution            = find_geometry(system, time, dt, report);

    // From powers at u_s to energies of the step. The midpoint rule loses nothing to inertia.
    report.dissipated *= dt;
    report.convected *= dt;
    report.boundary_work *= dt;
    report.body_work *= dt;
    if (choices.midpoint)
      report.numerical = 0;

    const Timers::Section section(system.timers, "accounting");
    if (choices.midpoint)
      report.displacement_error = error_estimate.add(space, time, dt, solution.velocities);
    for (unsigned int s = 0; s < system.structures.size(); ++s)
      {
        const typename StructureStep<dim>::Motion motion{solution.geometry[s],
                                                         solution.velocities[s],
                                                         solution.loaded[s],
                                                         solution.forces[s],
                                                         solution.other_forces[s]};
        const auto exchange =
          StructureStep<dim>(space, system.structures[s], motion, time, dt, choices.midpoint)
            .take(energies[s]);
        report.numerical += exchange.numerical;
        report.unexplained += exchange.unexplained;
        report.exchanges.push_back(exchange);
      }

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


  template class CoupledScheme<2>;
  template class CoupledScheme<3>;
} // namespace feib
