// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_timers_h
#define feib_timers_h

#include <feib/archive.h>

#include <chrono>
#include <map>
#include <string>

namespace feib
{
  /// Seconds by phase, of this rank.
  class Timers
  {
  public:
    /// Charges the time until its end to a phase; the time of a nested section is not charged
    /// twice.
    class Section
    {
    public:
      Section(Timers &timers, const std::string &phase);
      ~Section();
      Section(const Section &)            = delete;
      Section &operator=(const Section &) = delete;

    private:
      Timers &timers;
      std::string phase;
      Section *enclosing;
      std::chrono::steady_clock::time_point start;
      double nested = 0;
    };

    const std::map<std::string, double> &
    seconds() const
    {
      return phases;
    }

    void
    archive(Archive &archive)
    {
      archive("seconds", phases);
    }

  private:
    std::map<std::string, double> phases;
    Section *current = nullptr;
  };
} // namespace feib

#endif
