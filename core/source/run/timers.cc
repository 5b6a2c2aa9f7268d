// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/timers.h>

namespace feib
{
  Timers::Section::Section(Timers &timers, const std::string &phase)
    : timers(timers)
    , phase(phase)
    , enclosing(timers.current)
    , start(std::chrono::steady_clock::now())
  {
    timers.current = this;
  }


  Timers::Section::~Section()
  {
    const double elapsed =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    timers.phases[phase] += elapsed - nested;
    if (enclosing != nullptr)
      enclosing->nested += elapsed;
    timers.current = enclosing;
  }
} // namespace feib
