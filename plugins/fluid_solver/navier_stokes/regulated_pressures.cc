// SPDX-License-Identifier: LGPL-2.1-or-later
#include "regulated_pressures.h"

#include "residual_norms.h"

#include <deal.II/lac/full_matrix.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  template <int dim>
  void
  RegulatedPressures<dim>::reinit(const EulerianSpace<dim> &space)
  {
    const auto &conditions = space.domain().conditions;
    outlets.clear();
    for (unsigned int i = 0; i < conditions.size(); ++i)
      if (conditions[i].regulated())
        {
          Outlet outlet;
          outlet.condition = i;
          outlet.is_flux   = conditions[i].flux != nullptr;
          outlet.load      = terms.unit_load(space, i);
          outlets.push_back(outlet);
        }
    if (states.empty()) // else they go on
      for (const Outlet &outlet : outlets)
        {
          State state;
          if (!outlet.is_flux)
            state.past.start = state.pressure =
              conditions[outlet.condition].windkessel->initial_pressure;
          states.push_back(state);
        }
    forget();
  }


  template <int dim>
  void
  RegulatedPressures<dim>::begin(const EulerianSpace<dim> &space,
                                 const typename FluidSolver<dim>::Step &step,
                                 const bool linear)
  {
    const double time = step.time, dt = step.dt;
    if (!linear && time != answers_time)
      forget();
    answers_time = time;
    // Newton's method corrects what is wrong with them.
    answers_accuracy = linear ? 1e-8 : 1e-5;
    if (outlets.empty())
      return;
    const VelocityVector old_velocity = space.old_velocity;
    const std::vector<double> before  = terms.fluxes(space, old_velocity);
    for (unsigned int i = 0; i < outlets.size(); ++i)
      {
        Outlet &outlet        = outlets[i];
        const auto &condition = space.domain().conditions[outlet.condition];
        if (outlet.is_flux)
          {
            // On the straight line to what is given at the end.
            condition.flux->set_time(time + step.beyond);
            const double given = condition.flux->value(dealii::Point<dim>()),
                         share = dt / (dt + step.beyond);
            outlet.flux        = (1 - share) * before[outlet.condition] + share * given;
            continue;
          }
        // Backward Euler for the circuit, too.
        const auto &circuit     = *condition.windkessel;
        const double compliance = circuit.capacitance / dt, leak = 1 / circuit.distal_resistance;
        outlet.way        = {time - dt, states[i].past.at(time - dt), time, 0.};
        outlet.resistance = circuit.resistance;
        outlet.b          = circuit.resistance + 1 / (compliance + leak);
        outlet.a =
          (compliance * outlet.way.start + leak * circuit.distal_pressure) / (compliance + leak);
      }
  }


  template <int dim>
  std::vector<double>
  RegulatedPressures<dim>::pressures(const EulerianSpace<dim> &space) const
  {
    std::vector<double> result(space.domain().conditions.size(), 0.);
    for (unsigned int i = 0; i < outlets.size(); ++i)
      result[outlets[i].condition] = states[i].pressure;
    return result;
  }


  template <int dim>
  void
  RegulatedPressures<dim>::add_load(VelocityVector &load) const
  {
    for (unsigned int i = 0; i < outlets.size(); ++i)
      load.add(states[i].pressure, outlets[i].load);
  }


  template <int dim>
  typename RegulatedPressures<dim>::Answer
  RegulatedPressures<dim>::answer(const EulerianSpace<dim> &space,
                                  const StokesEquations<dim> &equations,
                                  StokesSolver<dim> &solver,
                                  const Outlet &outlet,
                                  const double accuracy,
                                  unsigned int &iterations) const
  {
    Answer result;
    result.velocity        = space.make_velocity();
    result.pressure        = space.make_pressure();
    VelocityVector r       = outlet.load;
    const PressureVector g = space.make_pressure();
    space.condense(r);
    iterations += solver.solve(equations,
                               r,
                               g,
                               impedance<dim>(equations.operators.terms(),
                                              space.smallest_edge(),
                                              equations.rate),
                               accuracy * r.l2_norm(),
                               result.velocity,
                               result.pressure);
    space.distribute(result.velocity, true);
    result.pressure.update_ghost_values();
    result.fluxes = terms.fluxes(space, result.velocity);
    return result;
  }


  template <int dim>
  unsigned int
  RegulatedPressures<dim>::correct(const EulerianSpace<dim> &space,
                                   const StokesEquations<dim> &equations,
                                   StokesSolver<dim> &solver,
                                   VelocityVector &du,
                                   PressureVector &dp)
  {
    unsigned int iterations = 0;
    if (outlets.empty())
      return iterations;
    if (answers.empty() || answers_rate != equations.rate)
      {
        std::vector<Answer> found; // all or none
        for (const Outlet &outlet : outlets)
          found.push_back(answer(space, equations, solver, outlet, answers_accuracy, iterations));
        answers      = std::move(found);
        answers_rate = equations.rate;
      }

    std::vector<double> fluxes       = terms.fluxes(space, space.velocity);
    const std::vector<double> change = terms.fluxes(space, du);
    const unsigned int n             = outlets.size();
    dealii::FullMatrix<double> matrix(n, n);
    dealii::Vector<double> right_hand_side(n), changes(n);
    for (unsigned int i = 0; i < n; ++i)
      {
        const Outlet &outlet = outlets[i];
        const double flux    = fluxes[outlet.condition] + change[outlet.condition];
        const double b       = outlet.is_flux ? -1 : outlet.b;
        for (unsigned int j = 0; j < n; ++j)
          matrix(i, j) = (i == j && !outlet.is_flux) - b * answers[j].fluxes[outlet.condition];
        right_hand_side(i) =
          outlet.is_flux ? outlet.flux - flux : b * flux + outlet.a - states[i].pressure;
      }
    matrix.gauss_jordan();
    matrix.vmult(changes, right_hand_side);
    du.zero_out_ghost_values();
    dp.zero_out_ghost_values();
    for (unsigned int i = 0; i < n; ++i)
      {
        outlets[i].change = changes(i);
        du.add(changes(i), answers[i].velocity);
        dp.add(changes(i), answers[i].pressure);
      }
    du.update_ghost_values();
    dp.update_ghost_values();
    return iterations;
  }


  template <int dim>
  void
  RegulatedPressures<dim>::add(const double part)
  {
    for (unsigned int i = 0; i < outlets.size(); ++i)
      states[i].pressure += part * outlets[i].change;
  }


  template <int dim>
  double
  RegulatedPressures<dim>::residual(const std::vector<double> &fluxes,
                                    const double least_flux) const
  {
    double largest = 0;
    for (unsigned int i = 0; i < outlets.size(); ++i)
      {
        const Outlet &outlet  = outlets[i];
        const double flux     = fluxes[outlet.condition];
        const double pressure = states[i].pressure, of_flux = outlet.b * flux;
        const double left = outlet.is_flux ? flux - outlet.flux : pressure - of_flux - outlet.a;
        const double size = outlet.is_flux ? std::abs(flux) + std::abs(outlet.flux) + least_flux
                                           : std::abs(pressure) + std::abs(of_flux) +
                                               std::abs(outlet.a) + outlet.b * least_flux;
        if (left != 0)
          largest = std::max(largest, std::abs(left) / size);
      }
    return largest;
  }


  template <int dim>
  void
  RegulatedPressures<dim>::finish(const std::vector<double> &fluxes)
  {
    for (unsigned int i = 0; i < outlets.size(); ++i)
      if (!outlets[i].is_flux)
        outlets[i].way.end =
          states[i].pressure - outlets[i].resistance * fluxes[outlets[i].condition];
  }


  template <int dim>
  void
  RegulatedPressures<dim>::commit()
  {
    for (unsigned int i = 0; i < outlets.size(); ++i)
      if (!outlets[i].is_flux)
        states[i].past = outlets[i].way;
    stepped = true;
  }


  template <int dim>
  std::vector<double>
  RegulatedPressures<dim>::wanted_fluxes(const EulerianSpace<dim> &space) const
  {
    std::vector<double> result = fluxes(space);
    for (const Outlet &outlet : outlets)
      if (outlet.is_flux && !stepped)
        {
          const auto &flux = space.domain().conditions[outlet.condition].flux;
          flux->set_time(0.);
          result[outlet.condition] = flux->value(dealii::Point<dim>());
        }
    return result;
  }


  template <int dim>
  void
  RegulatedPressures<dim>::adjust(const EulerianSpace<dim> &space,
                                  const std::vector<double> &wanted,
                                  const StokesEquations<dim> &equations,
                                  StokesSolver<dim> &solver,
                                  VelocityVector &u) const
  {
    std::vector<const Outlet *> given;
    std::vector<Answer> of_given;
    unsigned int iterations = 0;
    for (const Outlet &outlet : outlets)
      if (outlet.is_flux)
        {
          given.push_back(&outlet);
          of_given.push_back(answer(space, equations, solver, outlet, 1e-8, iterations));
        }
    const unsigned int n = given.size();
    if (n == 0)
      return;
    const std::vector<double> fluxes = terms.fluxes(space, u);
    dealii::FullMatrix<double> matrix(n, n);
    dealii::Vector<double> right_hand_side(n), multiples(n);
    for (unsigned int i = 0; i < n; ++i)
      {
        right_hand_side(i) = wanted[given[i]->condition] - fluxes[given[i]->condition];
        for (unsigned int j = 0; j < n; ++j)
          matrix(i, j) = of_given[j].fluxes[given[i]->condition];
      }
    matrix.gauss_jordan();
    matrix.vmult(multiples, right_hand_side);
    u.zero_out_ghost_values();
    for (unsigned int i = 0; i < n; ++i)
      u.add(multiples(i), of_given[i].velocity);
    space.distribute(u, false);
  }


  template class RegulatedPressures<2>;
  template class RegulatedPressures<3>;
} // namespace feib
