// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_judge_h
#define feib_judge_h

#include "accounts.h"
#include "energy_check.h"
#include "swing_check.h"
#include "verdict.h"

#include <optional>

namespace feib
{
  /// Judges a run while it goes: which steps fail, and what is doubtful about those that do not.
  template <int dim>
  class Judge
  {
  public:
    using Report = typename TimeIntegrator<dim>::Report;

    /// @p time: the block of a case.
    Judge(Components<dim> &components, const Accounts<dim> &accounts, const Parameters &time);

    Verdict verdict;

    /// To be called before anything else, with the structures as the case gives them: what the
    /// checks compare with.
    void begin();

    /// Of a run that starts, not of one that goes on: what is doubtful about its meshes, and the
    /// limit of the step, which is returned.
    double start();

    /// Throws RunFailure when the state a step led to is none: structures beyond the box or torn,
    /// velocities not finite. Collective.
    void check_state() const;

    /// The energies of a step, see EnergyCheck. Throws RunFailure.
    void judge_energies(double before, double after, const Report &report);

    /// Forgets the failure of the last step, before another one.
    void forget_failure();

    /// Whether the last step failed because energy grew.
    bool grew() const;

    /// Warns of a step to be taken that exceeds a limit.
    void check_limits(double time, double dt);

    /// Warns of what is doubtful in the state that a step has reached.
    void check_result(double time);

    /// Warns of what takes too long to look for in every step, at the end.
    void check_end(double time);

    /// What a failure with steps up to @p dt from the present state comes from, as the end of a
    /// sentence.
    std::string cause(double time, double dt);

    /// Steps of @p dt beside the limit of the scheme, with a remedy.
    std::string stability_sentence(double dt);

    /// On a new mesh: parts of faces that end within cells, where fluid passes through the wall
    /// beside them.
    void check_parts(double time);

    /// What is undone with a step.
    void
    archive_step(Archive &archive)
    {
      archive("energies", energies->totals);
    }

    /// What is not.
    void
    archive(Archive &archive)
    {
      archive("verdict", verdict);
      archive("swings", swings);
      archive("largest_velocity", largest_velocity);
      archive("largest_kinetic", largest_kinetic);
      archive("calm_limit", calm_limit);
    }

  private:
    /// Explicit schemes gain a little by theory.
    static constexpr double tolerated_gain = .1;

    static std::string driven_sentence(double part, const std::string &structure);

    /// Structures that gain energy, or lose measure.
    void check_energies(double time);
    void check_measures(double time);

    /// Light structures whose mass takes away more than the fluid about them has.
    void check_kinetic_energy(double time);

    /// Whether anything has moved by more than round-off so far.
    bool moves(double time) const;

    /// Flows too rough for the mesh, which have lost what they were.
    void check_resolution(double time);

    /// Forces that swing faster than the steps follow.
    void check_forces(double time);

    /// Momentum that changes though nothing in a periodic box can change it.
    void check_momentum(double time);

    Components<dim> &components;
    const Accounts<dim> &accounts;
    const double energy_growth, measure_tolerance;
    std::optional<EnergyCheck<dim>> energies; // from the initial state on
    std::vector<double> initial_measures;     // of each structure
    SwingCheck swings;
    double largest_velocity = 0; // so far
    double largest_kinetic  = 0; // the largest kinetic energy so far, without its sign
    double calm_limit       = 0; // of the step, when energy last did not grow
  };
} // namespace feib

#endif
