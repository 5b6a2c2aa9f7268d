// SPDX-License-Identifier: LGPL-2.1-or-later
#include "step_control.h"

#include <feib/message.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace feib
{
  namespace
  {
    std::string
    text(const double number)
    {
      std::ostringstream stream;
      stream << number;
      return stream.str();
    }
  } // namespace


  StepControl::StepControl(const Parameters &time, const double length)
    : step(time.number("step"))
    , end(time.number("end"))
  {
    // A rest that is a step but for round-off is a whole step.
    n_steps = std::max(1., std::ceil(end / step - 1e-6));
    if (!(n_steps <= 1e9))
      time.fail("step",
                "the end is " + readable(end / step) + " steps away, at most 1e9 are allowed");
    const auto [name, control] = time.child("control").choice();
    is_adaptive                = name == "adaptive";
    shortest = control.has("minimum_step") ? control.number("minimum_step") : step / 1024;
    longest  = step;
    growth   = 2;
    if (is_adaptive)
      {
        longest   = control.has("maximum_step") ? control.number("maximum_step")
                                                : std::numeric_limits<double>::infinity();
        growth    = control.number("growth");
        cfl       = control.number("cfl");
        stability = control.number("stability");
        tolerance = control.number("tolerance") * length;
        if (shortest > longest)
          control.fail("maximum_step", "is smaller than the smallest step, " + text(shortest));
      }
    if (shortest > step)
      control.fail("minimum_step", "is larger than the step, " + text(step));
  }


  double
  StepControl::target() const
  {
    if (is_adaptive)
      return end;
    return grid + 1 >= n_steps ? end : (grid + 1) * step;
  }


  double
  StepControl::next_dt() const
  {
    // The last piece may be longer by round-off, but is never a sliver.
    const double rest = target() - present;
    if (rest <= dt * (1 + 1e-6))
      return rest;
    return is_adaptive && rest < 2 * dt ? rest / 2 : dt;
  }


  double
  StepControl::allowed(const State &state) const
  {
    if (!is_adaptive)
      return step;
    double result = std::min(longest, stability * state.stability_limit);
    if (state.cfl_rate > 0)
      result = std::min(result, cfl / state.cfl_rate);
    if (std::isinf(state.displacement_error))
      result = std::min(result, dt); // not known yet: no reason to grow
    else if (state.displacement_error > 0)
      // The error of a step grows with its third power.
      result = std::min(result, dt * std::cbrt(.7 * tolerance / state.displacement_error));
    return std::max(result, shortest);
  }


  double
  StepControl::start(const State &state)
  {
    dt = std::min(step, allowed(state));
    return dt;
  }


  bool
  StepControl::accurate(const double displacement_error) const
  {
    return !is_adaptive || displacement_error <= tolerance || std::isinf(displacement_error);
  }


  void
  StepControl::accept(const State &state)
  {
    const bool shortened = next_dt() < dt * (1 - 1e-6);
    present              = next_time();
    if (!is_adaptive && present >= target())
      ++grid;
    const double limit = allowed(state);
    if (patience > 0)
      --patience;
    if (limit < dt)
      // A little below the limit, that the next step need not change again. The error estimate of
      // an accepted step asks for no more than its own step.
      dt = std::max(shortest, std::min(dt, .9 * limit));
    else if (limit >= growth * dt && !shortened && patience == 0)
      dt *= growth;
    else if (!is_adaptive && patience == 0)
      dt = std::min(step, growth * dt);
  }


  void
  StepControl::archive(Archive &archive)
  {
    double step_before = step;
    archive("time", present);
    archive("grid", grid);
    archive("step", step_before);
    archive("dt", dt);
    archive("patience", patience);
    if (!archive.reading())
      return;
    // The run before may have had another step, another end or no multiples to hit. What is one but
    // for round-off has been passed, so that the next step is no sliver.
    grid = std::floor(present / step + 1e-6);
    if (!is_adaptive)
      dt = step_before != step ? step : std::min(dt, step);
    dt = std::min(std::max(dt, shortest), longest);
  }


  bool
  StepControl::halve()
  {
    const double half = next_dt() / 2;
    // A step that does not advance the time would never end.
    if (half < shortest * (1 - 1e-6) || !(half >= std::numeric_limits<double>::min()) ||
        present + half == present)
      return false;
    dt       = half;
    patience = 4;
    return true;
  }
} // namespace feib
