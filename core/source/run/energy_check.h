// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_energy_check_h
#define feib_energy_check_h

#include "components.h"

namespace feib
{
  /// Judges the energies of a step before it is accepted: what grows from nowhere is a failure.
  /// Neither the work of a moving wall nor what viscosity takes elsewhere hides anything:
  /// structures are judged by themselves, and growth is counted from where it began.
  template <int dim>
  class EnergyCheck
  {
  public:
    using Report = typename TimeIntegrator<dim>::Report;

    /// Of the run up to the present step: a part of the state, to be undone with a step.
    struct Totals
    {
      unsigned int steps = 0;
      double growth = 0; // energy from nowhere beyond what was dissipated, since it last vanished
      std::vector<double> unexplained, elastic_work, inelastic, gained; // of each structure

      void
      archive(Archive &archive)
      {
        archive("steps", steps);
        archive("growth", growth);
        archive("unexplained", unexplained);
        archive("elastic_work", elastic_work);
        archive("inelastic", inelastic);
        archive("gained", gained);
      }
    };
    Totals totals;
    bool grew = false; // whether judge() failed because of growth

    /// At the initial state. @p allowed: growth relative to the energy there is.
    EnergyCheck(const Components<dim> &components, double allowed);

    /// The fluid's and structures' energies before and after a step. Throws RunFailure.
    void judge(double before, double after, const Report &report);

    /// A structure and a part of the work of its load since the beginning.
    using Worst = std::pair<double, std::string>;

    /// The structure with the largest part that no change of its energy explains, though its load
    /// is said to be the derivative of one; 0 without.
    Worst unexplained() const;

    /// The structure with the largest part that the time scheme has given it, as an explicit one
    /// does to modes too fast for its step; 0 without. Of a structure that starts without stress a
    /// first-order explicit scheme gives all of the energy in the first step, 1/n after n: nothing
    /// is said within the first steps. Nor of structures lighter than the fluid, whose inertia
    /// gains what the fluid's loses.
    Worst gained() const;

    /// Of the loads that are no derivatives of energies, because of where on faces they act: the
    /// structure with the largest part that came from nowhere, however short the steps, beside the
    /// work and what viscosity took; 0 without.
    Worst driven() const;

  private:
    void judge_structure(unsigned int s, double scale, const Report &report);

    Worst worst(const std::vector<double> &energies, const std::vector<double> &works) const;

    /// Below which unexplained energy of a structure is round-off.
    double round_off(unsigned int s) const;

    const Components<dim> &components;
    const double allowed;
    double unit = 0;                               // energy below which growth means nothing
    std::vector<double> initial_energy, stiffness; // of each structure, energies
    std::vector<bool> is_light;                    // whether excess masses are negative
  };
} // namespace feib

#endif
