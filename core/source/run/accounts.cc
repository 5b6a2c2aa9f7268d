// SPDX-License-Identifier: LGPL-2.1-or-later
#include "accounts.h"

#include <feib/cross_product.h>
#include <feib/message.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    /// The phases a step's time is divided into, as the ledger lists them.
    const char *const phases[] =
      {"fluid", "structure", "coupling", "refinement", "output", "accounting"};

    const char *const axes[] = {"x", "y", "z"};
  } // namespace


  template <int dim>
  Accounts<dim>::Accounts(Components<dim> &components)
    : components(components)
  {
    totals.leak.assign(components.structures.size(), 0.);
    totals.time_error.assign(components.structures.size(), 0.);
  }


  template <int dim>
  void
  Accounts<dim>::Totals::archive(Archive &archive)
  {
    archive("dissipated", dissipated);
    archive("convected", convected);
    archive("numerical", numerical);
    archive("unexplained", unexplained);
    archive("inelastic", inelastic);
    archive("boundary_work", boundary_work);
    archive("body_work", body_work);
    archive("energy", energy);
    archive("remeshing", remeshing);
    archive("linear_iterations", linear_iterations);
    archive("nonlinear_iterations", nonlinear_iterations);
    archive("geometry_iterations", geometry_iterations);
    archive("largest_increase", largest_increase);
    archive("largest_relative_increase", largest_relative_increase);
    archive("largest_closure", largest_closure);
    archive("smallest_dt", smallest_dt);
    archive("largest_dt", largest_dt);
    archive("leak", leak);
    archive("time_error", time_error);
    archive("impulse", impulse);
    archive("first_linear_iterations", first_linear_iterations);
  }


  template <int dim>
  typename Accounts<dim>::State
  Accounts<dim>::state(const Report &report) const
  {
    State result;
    result.fluid            = components.fluid->balance(*components.space);
    result.kinetic          = result.fluid.kinetic_energy;
    result.elastic          = 0;
    result.potential        = 0;
    result.momentum         = result.fluid.momentum;
    result.angular_momentum = result.fluid.angular_momentum;
    for (unsigned int s = 0; s < components.structures.size(); ++s)
      {
        const StructureModel<dim> &model = *components.structures[s].model;
        double of_forces                 = 0;
        for (const double energy : model.force_energies(model.positions))
          of_forces += energy;
        result.potential += of_forces;
        result.elastic += (s < report.exchanges.size() ? report.exchanges[s].elastic_energy
                                                       : model.energy(model.positions)) -
                          of_forces;
        for (unsigned int i = 0; i < model.excess_mass().size(); ++i)
          {
            const dealii::Tensor<1, dim> p = model.excess_mass()[i] * model.velocities[i];
            result.kinetic += .5 * (p * model.velocities[i]);
            result.momentum += p;
            result.angular_momentum += cross_product<dim>(model.positions[i], p);
          }
      }
    return result;
  }


  template <int dim>
  void
  Accounts<dim>::sum_up(const unsigned int step,
                        const double dt,
                        const Report &report,
                        const double total)
  {
    totals.dissipated += report.dissipated;
    totals.convected += report.convected;
    totals.numerical += report.numerical;
    totals.unexplained += report.unexplained;
    for (const auto &exchange : report.exchanges)
      {
        totals.inelastic += exchange.inelastic;
        for (const Impulse &force : exchange.forces)
          totals.impulse += dt * force.force;
      }
    totals.boundary_work += report.boundary_work;
    totals.body_work += report.body_work;
    totals.linear_iterations += report.linear_iterations;
    totals.nonlinear_iterations += report.nonlinear_iterations;
    totals.geometry_iterations += report.geometry_iterations;
    if (step == 1)
      totals.first_linear_iterations = report.linear_iterations;
    if (step > 0)
      {
        const double increase   = total - totals.energy;
        totals.largest_increase = std::max(totals.largest_increase, increase);
        if (totals.energy > 0)
          totals.largest_relative_increase =
            std::max(totals.largest_relative_increase, increase / totals.energy);
        totals.smallest_dt = std::min(totals.smallest_dt, dt);
        totals.largest_dt  = std::max(totals.largest_dt, dt);
      }
    totals.energy = total;
  }


  template <int dim>
  void
  Accounts<dim>::add_impulse(Ledger::Row &row,
                             const std::string &name,
                             const double power,
                             const dealii::Tensor<1, dim> &force,
                             const dealii::Tensor<1, 3> &torque)
  {
    row.emplace_back("power_" + name, power);
    for (unsigned int a = 0; a < dim; ++a)
      row.emplace_back(std::string("force_") + axes[a] + "_" + name, force[a]);
    for (unsigned int a = (dim == 2 ? 2 : 0); a < 3; ++a)
      row.emplace_back(std::string("torque_") + axes[a] + "_" + name, torque[a]);
  }


  template <int dim>
  void
  Accounts<dim>::add_boundary(Ledger::Row &row, const Report &report) const
  {
    const auto &conditions = components.space->domain().conditions;
    for (unsigned int i = 0; i < conditions.size(); ++i)
      if (!conditions[i].periodic())
        {
          const std::string &name = conditions[i].name;
          const auto exchange     = i < report.boundary.size()
                                      ? report.boundary[i]
                                      : typename FluidSolver<dim>::BoundaryExchange();
          add_impulse(row, name, exchange.power, exchange.force, exchange.torque);
          if (!conditions[i].tight)
            {
              row.emplace_back("flux_" + name, exchange.flux);
              row.emplace_back("pressure_" + name, exchange.pressure);
            }
        }
  }


  template <int dim>
  void
  Accounts<dim>::add_structure(Ledger::Row &row, const unsigned int s, const Report &report) const
  {
    const StructureModel<dim> &model = *components.structures[s].model;
    const auto exchange =
      s < report.exchanges.size() ? report.exchanges[s] : typename TimeIntegrator<dim>::Exchange();
    row.emplace_back("measure_" + model.name(), model.measure(model.positions));
    row.emplace_back("leak_" + model.name(), totals.leak[s]);
    row.emplace_back("time_error_" + model.name(), totals.time_error[s]);
    add_impulse(row, model.name(), exchange.power, exchange.force, exchange.torque);
    if (const auto &coefficients = components.coefficients)
      {
        row.emplace_back("drag_" + model.name(), coefficients->drag(exchange.force));
        row.emplace_back("lift_" + model.name(), coefficients->lift(exchange.force));
      }
    const std::vector<std::string> forces = model.force_names();
    const std::vector<double> energies    = model.force_energies(model.positions);
    for (unsigned int f = 0; f < forces.size(); ++f)
      {
        const std::string name = model.name() + "_" + forces[f];
        row.emplace_back("energy_" + name, energies[f]);
        const Impulse impulse = f < exchange.forces.size() ? exchange.forces[f] : Impulse();
        add_impulse(row, name, impulse.power, impulse.force, impulse.torque);
      }
    const dealii::Point<dim> centroid = model.centroid(model.positions);
    for (unsigned int a = 0; a < dim; ++a)
      {
        const std::string end = std::string("_") + axes[a] + "_" + model.name();
        const auto [low, high] =
          std::minmax_element(model.positions.begin(),
                              model.positions.end(),
                              [a](const auto &x, const auto &y) { return x[a] < y[a]; });
        row.emplace_back("centroid" + end, centroid[a]);
        row.emplace_back("lower" + end, (*low)[a]);
        row.emplace_back("upper" + end, (*high)[a]);
      }
    add_axes(row, model);
  }


  template <int dim>
  void
  Accounts<dim>::add_axes(Ledger::Row &row, const StructureModel<dim> &model)
  {
    // Directions of axes are not written: where two are alike they depend on round-off.
    const auto moments = model.second_moments(model.positions);
    // By rotations: the closed formula of deal.II loses eigenvalues that are nearly the same.
    const auto axes_of   = eigenvectors(moments, dealii::SymmetricTensorEigenvectorMethod::jacobi);
    const unsigned int m = model.mesh().closed() ? dim : model.mesh().structure_dim();
    for (unsigned int k = 0; k < dim; ++k)
      row.emplace_back("axis_" + std::to_string(k + 1) + "_" + model.name(),
                       std::sqrt(std::max(0., (m + 2) * axes_of[k].first)));
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int b = a; b < dim; ++b)
        row.emplace_back(std::string("moment_") + axes[a] + axes[b] + "_" + model.name(),
                         moments[a][b]);
  }


  template <int dim>
  double
  Accounts<dim>::smallest_limit() const
  {
    double result = std::numeric_limits<double>::infinity();
    for (const std::string &column : ledger.columns())
      if (column.rfind("dt_limit_", 0) == 0)
        result = std::min(result, ledger.last(column));
    return result;
  }


  template <int dim>
  Ledger::Row
  Accounts<dim>::add(const unsigned int step,
                     const double time,
                     const double dt,
                     const Report &report,
                     const std::vector<Positions<dim>> &before)
  {
    for (unsigned int s = 0; s < before.size(); ++s)
      {
        const StructureModel<dim> &model = *components.structures[s].model;
        if (model.mesh().structure_dim() < dim && !model.mesh().closed())
          continue;
        const double leak = report.exchanges[s].leak;
        totals.leak[s] += leak;
        // That of now comes last, as the row has it again.
        const double measure_before = model.measure(before[s]);
        totals.time_error[s] += model.measure(model.positions) - measure_before - leak;
      }

    Ledger::Row row;
    {
      const Timers::Section section(components.timers, "accounting");
      const State now    = state(report);
      const double total = now.kinetic + now.elastic + now.potential;
      sum_up(step, dt, report, total);
      const double initial = step > 0 ? ledger.first("total_energy") : total;
      const double closure = total - initial + totals.dissipated + totals.convected +
                             totals.numerical + totals.unexplained + totals.inelastic -
                             totals.boundary_work - totals.body_work - totals.remeshing;
      totals.largest_closure = std::max(totals.largest_closure, std::abs(closure));

      row = {{"step", double(step)},
             {"time", time},
             {"dt", dt},
             {"kinetic", now.kinetic},
             {"elastic", now.elastic},
             {"potential", now.potential},
             {"dissipated", totals.dissipated},
             {"convected", totals.convected},
             {"numerical", totals.numerical},
             {"unexplained", totals.unexplained},
             {"inelastic", totals.inelastic},
             {"boundary_work", totals.boundary_work},
             {"body_work", totals.body_work},
             {"remeshing", totals.remeshing},
             {"total_energy", total},
             {"closure", closure},
             {"largest_velocity", now.fluid.largest_velocity},
             {"divergence", now.fluid.divergence}};
      for (unsigned int a = 0; a < dim; ++a)
        row.emplace_back(std::string("momentum_") + axes[a], now.momentum[a]);
      for (unsigned int a = (dim == 2 ? 2 : 0); a < 3; ++a)
        row.emplace_back(std::string("angular_momentum_") + axes[a], now.angular_momentum[a]);
      row.emplace_back("cfl", now.fluid.cfl_rate * dt);
      add_boundary(row, report);
      for (unsigned int s = 0; s < components.structures.size(); ++s)
        add_structure(row, s, report);
      for (auto &entry : components.integrator->diagnostics(components.system(), dt))
        row.push_back(std::move(entry));
      row.emplace_back("displacement_error",
                       std::isfinite(report.displacement_error)
                         ? std::max(0., report.displacement_error)
                         : 0.);
      row.emplace_back("cells", components.space->triangulation().n_global_active_cells());
      row.emplace_back("linear_iterations", report.linear_iterations);
      row.emplace_back("nonlinear_iterations", report.nonlinear_iterations);
      row.emplace_back("geometry_iterations", report.geometry_iterations);
    }
    for (const char *phase : phases)
      {
        const auto found    = components.timers.seconds().find(phase);
        const double so_far = found == components.timers.seconds().end() ? 0. : found->second;
        row.emplace_back(std::string("seconds_") + phase, so_far - seconds_at_last_row[phase]);
        seconds_at_last_row[phase] = so_far;
      }
    for (const auto &[name, value] : row)
      if (!std::isfinite(value))
        throw RunFailure("the ledger's " + name + " is not finite at time " + readable(time));
    return row;
  }


  template <int dim>
  void
  Accounts<dim>::add_remeshing(const double gained)
  {
    // Moving the velocity to another mesh is no work of the scheme.
    totals.energy += gained;
    totals.remeshing += gained;
  }


  template class Accounts<2>;
  template class Accounts<3>;
} // namespace feib
