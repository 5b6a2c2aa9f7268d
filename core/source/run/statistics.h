// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_statistics_h
#define feib_statistics_h

#include "json.h"
#include "verdict.h"

#include <feib/archive.h>
#include <feib/ledger.h>
#include <feib/parameters.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace feib
{
  /// Means and ranges of the ledger's columns over a window of time.
  class Statistics
  {
  public:
    /// From the block "statistics" of a case, if any. Throws Error when the window is empty or
    /// begins after the run's end.
    explicit Statistics(const Parameters &description);

    /// After a step.
    void add(const Ledger &ledger);

    /// {"from", "to", "columns": {name: {"mean", "smallest", "largest", "amplitude"}}}; of lifts
    /// with "frequency" and "periods" where there is a whole period. Null without a window or
    /// steps in it.
    Json to_json() const;

    /// At the end of a run: warns when a window that the case gives holds no step.
    void check_end(double time, Verdict &verdict) const;

    /// Of a lift; none without a whole period.
    std::optional<double> frequency(const std::string &column) const;

    void archive(Archive &archive);

  private:
    struct Sum
    {
      double integral = 0, smallest = 0, largest = 0;
      std::vector<double> series; // of lifts, with the times

      void archive(Archive &archive);
    };

    /// The times at which a series passes its mean upwards.
    std::vector<double> passes(const Sum &sum) const;

    bool wanted    = false;
    bool asked_for = false; // by the case, not for lifts alone
    double from = 0, to = 0;
    double first = 0, duration = 0; // what was seen: from, and how long
    std::vector<double> times;      // half way through the steps seen
    std::map<std::string, Sum> sums;
  };
} // namespace feib

#endif
