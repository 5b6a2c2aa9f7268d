// SPDX-License-Identifier: LGPL-2.1-or-later
#include "statistics.h"

#include <feib/message.h>

#include <algorithm>

namespace feib
{
  namespace
  {
    /// Columns whose mean says something.
    bool
    counts(const std::string &column)
    {
      for (const char *start : {"step", "time", "dt", "seconds_"})
        if (column.rfind(start, 0) == 0 && column.rfind("time_error", 0) != 0)
          return false;
      return true;
    }
  } // namespace


  Statistics::Statistics(const Parameters &description)
  {
    wanted = description.has("statistics") || description.has("coefficients");
    if (!wanted)
      return;
    const double end = description.child("time").number("end");
    from             = end / 2;
    to               = end;
    asked_for        = description.has("statistics");
    if (!asked_for)
      return;
    const Parameters block = description.child("statistics");
    if (block.has("from"))
      from = block.number("from");
    if (block.has("to"))
      to = block.number("to");
    if (!(from < to && from < end))
      block.fail(block.has("from") ? "from" : "to",
                 "the window goes from " + readable(from) + " to " + readable(to) +
                   ", the run to " + readable(end) + ": nothing is in it");
  }


  void
  Statistics::add(const Ledger &ledger)
  {
    // Rows stand for their steps: those that begin in the window.
    const double time = ledger.last("time"), dt = ledger.last("dt");
    if (!wanted || time - dt < from - 1e-9 * dt || time > to + 1e-9 * dt)
      return;
    // What a run saw that was to end earlier, before the window.
    if (duration > 0 && first + duration <= from + 1e-9 * dt)
      {
        duration = 0;
        times.clear();
        sums.clear();
      }
    if (duration == 0)
      first = time - dt;
    const auto &columns = ledger.columns();
    const auto &row     = ledger.last_row();
    for (std::size_t i = 0; i < columns.size(); ++i)
      if (counts(columns[i]))
        {
          Sum &sum = sums[columns[i]];
          sum.integral += dt * row[i];
          sum.smallest = duration == 0 ? row[i] : std::min(sum.smallest, row[i]);
          sum.largest  = duration == 0 ? row[i] : std::max(sum.largest, row[i]);
          if (columns[i].rfind("lift_", 0) == 0)
            sum.series.push_back(row[i]);
        }
    times.push_back(time - dt / 2);
    duration += dt;
  }


  void
  Statistics::check_end(const double time, Verdict &verdict) const
  {
    if (asked_for && duration == 0)
      verdict.warn("statistics",
                   time,
                   0.,
                   "no step lies in the window of the statistics, from " + readable(from) + " to " +
                     readable(to) + ": there are none");
  }


  std::vector<double>
  Statistics::passes(const Sum &sum) const
  {
    const double mean = sum.integral / duration;
    std::vector<double> result;
    for (std::size_t i = 1; i < sum.series.size(); ++i)
      if (const double before = sum.series[i - 1] - mean, after = sum.series[i] - mean;
          before < 0 && after >= 0)
        result.push_back(times[i - 1] + (times[i] - times[i - 1]) * before / (before - after));
    return result;
  }


  std::optional<double>
  Statistics::frequency(const std::string &column) const
  {
    const auto found = sums.find(column);
    if (found == sums.end())
      return {};
    const std::vector<double> at = passes(found->second);
    if (at.size() < 2)
      return {};
    return (at.size() - 1) / (at.back() - at.front());
  }


  Json
  Statistics::to_json() const
  {
    if (duration == 0)
      return nullptr;
    Json columns = Json::object();
    for (const auto &[name, sum] : sums)
      {
        Json &column = columns[name];
        column       = {{"mean", sum.integral / duration},
                        {"smallest", sum.smallest},
                        {"largest", sum.largest},
                        {"amplitude", (sum.largest - sum.smallest) / 2}};
        if (const auto f = frequency(name))
          {
            column["frequency"] = *f;
            column["periods"]   = passes(sum).size() - 1;
          }
      }
    return {{"from", first}, {"to", first + duration}, {"columns", columns}};
  }


  void
  Statistics::Sum::archive(Archive &archive)
  {
    archive("integral", integral);
    archive("smallest", smallest);
    archive("largest", largest);
    archive("series", series);
  }


  void
  Statistics::archive(Archive &archive)
  {
    archive("first", first);
    archive("duration", duration);
    archive("times", times);
    archive("sums", sums);
  }
} // namespace feib
