// SPDX-License-Identifier: LGPL-2.1-or-later
#include "energy_check.h"

#include <feib/failure.h>
#include <feib/message.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    /// The part of an energy @p whole at the present positions that comes from no force.
    template <int dim>
    double
    elastic_energy(const StructureModel<dim> &model, double whole)
    {
      for (const double energy : model.force_energies(model.positions))
        whole -= energy;
      return whole;
    }
  } // namespace


  template <int dim>
  EnergyCheck<dim>::EnergyCheck(const Components<dim> &components, const double allowed)
    : components(components)
    , allowed(allowed)
  {
    totals.unexplained.assign(components.structures.size(), 0.);
    totals.elastic_work.assign(components.structures.size(), 0.);
    totals.inelastic.assign(components.structures.size(), 0.);
    totals.gained.assign(components.structures.size(), 0.);
    for (const ImmersedStructure<dim> &structure : components.structures)
      {
        const StructureModel<dim> &model = *structure.model;
        initial_energy.push_back(elastic_energy(model, model.energy(model.positions)));
        double reference = 0;
        for (const auto &element : model.mesh().elements())
          reference += element.measure;
        stiffness.push_back(model.stiffness(model.positions).reference * reference);
        unit += 1e-6 * stiffness.back();
        const std::vector<double> &mass = model.excess_mass();
        is_light.push_back(
          std::any_of(mass.begin(), mass.end(), [](const double m) { return m < 0; }));
      }
  }


  template <int dim>
  double
  EnergyCheck<dim>::round_off(const unsigned int s) const
  {
    return 1e-9 * (std::abs(initial_energy[s]) + stiffness[s]);
  }


  template <int dim>
  void
  EnergyCheck<dim>::judge(const double before, const double after, const Report &report)
  {
    // What leaves through open faces is known, and hides no growth.
    const double gained = -(report.numerical + report.unexplained);
    const double scale  = std::max({std::abs(before), std::abs(after), unit});
    totals.growth       = std::max(0., totals.growth + gained - report.dissipated);
    ++totals.steps;
    grew = true; // should one of these throw
    for (unsigned int s = 0; s < report.exchanges.size(); ++s)
      judge_structure(s, scale, report);
    if (totals.growth > allowed * scale)
      throw RunFailure("the energy has grown by " + percent(totals.growth / scale) +
                       " beyond the work done");
    grew = false;
  }


  template <int dim>
  void
  EnergyCheck<dim>::judge_structure(const unsigned int s, const double scale, const Report &report)
  {
    const auto &exchange             = report.exchanges[s];
    const StructureModel<dim> &model = *components.structures[s].model;
    const double gained              = -(exchange.numerical + exchange.unexplained);
    if (gained > allowed * scale && !is_light[s])
      throw RunFailure("the energy of the structure \"" + model.name() + "\" has grown by " +
                       percent(gained / scale) + " beyond the work done on it");

    totals.unexplained[s] += exchange.unexplained;
    totals.elastic_work[s] += exchange.elastic_work;
    totals.inelastic[s] += std::abs(exchange.inelastic);
    totals.gained[s] -= exchange.numerical;
    const double unexplained = std::abs(totals.unexplained[s]);
    if (model.conservative() && unexplained > allowed * totals.elastic_work[s] + round_off(s))
      throw Incurable("the load of the structure \"" + model.name() + "\" has done a work of " +
                      readable(totals.elastic_work[s]) + ", " +
                      percent(unexplained / totals.elastic_work[s]) +
                      " of which no change of its energy explains: the stress of its law is not "
                      "the derivative of its energy");

    const double energy = elastic_energy(model, exchange.elastic_energy);
    if (energy < std::min(0., initial_energy[s]) - 2 * (std::abs(initial_energy[s]) + stiffness[s]))
      throw Incurable("the elastic energy of the structure \"" + model.name() + "\" falls to " +
                      readable(energy) + " from " + readable(initial_energy[s]) +
                      ": its law gives energy without end");
  }


  template <int dim>
  typename EnergyCheck<dim>::Worst
  EnergyCheck<dim>::worst(const std::vector<double> &energies,
                          const std::vector<double> &works) const
  {
    Worst result{0., ""};
    for (unsigned int s = 0; s < energies.size(); ++s)
      {
        const double beyond = std::abs(energies[s]) - round_off(s);
        if (beyond > result.first * works[s])
          result = {beyond / works[s], components.structures[s].model->name()};
      }
    return result;
  }


  template <int dim>
  typename EnergyCheck<dim>::Worst
  EnergyCheck<dim>::unexplained() const
  {
    std::vector<double> energies = totals.unexplained;
    for (unsigned int s = 0; s < energies.size(); ++s)
      if (!components.structures[s].model->conservative())
        energies[s] = 0;
    return worst(energies, totals.elastic_work);
  }


  template <int dim>
  typename EnergyCheck<dim>::Worst
  EnergyCheck<dim>::gained() const
  {
    constexpr unsigned int first_steps = 15;
    std::vector<double> gains          = totals.gained;
    for (unsigned int s = 0; s < gains.size(); ++s)
      gains[s] = totals.steps > first_steps && !is_light[s] ? std::max(0., gains[s]) : 0.;
    return worst(gains, totals.elastic_work);
  }


  template <int dim>
  typename EnergyCheck<dim>::Worst
  EnergyCheck<dim>::driven() const
  {
    // Where viscosity takes much more than that, it matters less.
    std::vector<double> gains(totals.unexplained.size()), works = totals.elastic_work;
    for (unsigned int s = 0; s < gains.size(); ++s)
      {
        if (!components.structures[s].model->conservative())
          gains[s] = std::max(0., -totals.unexplained[s]);
        works[s] += totals.inelastic[s];
      }
    return worst(gains, works);
  }


  template class EnergyCheck<2>;
  template class EnergyCheck<3>;
} // namespace feib
