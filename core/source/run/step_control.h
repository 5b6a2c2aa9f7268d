// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_step_control_h
#define feib_step_control_h

#include <feib/archive.h>
#include <feib/parameters.h>

#include <limits>

namespace feib
{
  /// Chooses the time steps: the block "time" of a case.
  ///
  /// With `fixed` control every multiple of the given step is hit exactly. With `adaptive` control
  /// the step follows from the flow, the stability estimate of the scheme and its error estimate;
  /// it changes rarely, because a new step means a new factorisation of the fluid's matrix. With
  /// both, a step that fails is tried again with half its length.
  class StepControl
  {
  public:
    /// @p length: the shortest edge of the box, which the displacement error is measured against.
    /// Throws Error.
    StepControl(const Parameters &time, double length);

    /// What the choice depends on, at the present state.
    struct State
    {
      double cfl_rate           = 0; // times dt is the CFL number
      double stability_limit    = std::numeric_limits<double>::infinity();
      double displacement_error = -1; // of the last step; negative: the scheme has none
    };

    /// Whether the state matters.
    bool
    adaptive() const
    {
      return is_adaptive;
    }

    /// The step to take first.
    double start(const State &state);

    /// The end of the step to take now.
    double
    next_time() const
    {
      return present + next_dt() >= target() * (1 - 1e-12) ? target() : present + next_dt();
    }

    /// The length of the step to take now.
    double next_dt() const;

    bool
    finished() const
    {
      return present >= end;
    }

    /// Whether the step just computed is accurate enough to be kept.
    bool accurate(double displacement_error) const;

    /// The step was taken.
    void accept(const State &state);

    /// The step failed, or was not accurate; half of it is to be tried. False: that would be
    /// shorter than allowed.
    bool halve();

    /// A run may go on with another end, another step or another control.
    void archive(Archive &archive);

  private:
    /// The time that is to be hit exactly.
    double target() const;

    double allowed(const State &state) const;

    double step, end, shortest, longest, growth;
    bool is_adaptive;
    double cfl = 0, stability = 0, tolerance = 0; // adaptive alone
    double n_steps = 0;                           // fixed alone

    double present        = 0; // the time reached
    double grid           = 0; // fixed: how many multiples of the step have been passed
    double dt             = 0;
    unsigned int patience = 0; // steps to take after a failure before the next may be longer
  };
} // namespace feib

#endif
