// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_summary_h
#define feib_summary_h

#include "accounts.h"
#include "json.h"
#include "statistics.h"
#include "verdict.h"

namespace feib
{
  /// Any number of durations in little memory: counts by size, in classes 2 % wide.
  class Durations
  {
  public:
    void add(double seconds);

    /// 0 when there are none. The median is the middle of its class.
    double median() const;

    double
    largest() const
    {
      return maximum;
    }

    void
    archive(Archive &archive)
    {
      archive("counts", counts);
      archive("largest", maximum);
    }

  private:
    std::vector<std::uint64_t> counts; // from a microsecond on
    double maximum = 0;
  };


  /// How a run went, beside its accounts.
  struct RunRecord
  {
    unsigned int step      = 0;
    double time            = 0;
    double wall_seconds    = 0;
    double stability_limit = std::numeric_limits<double>::infinity(); // before the first step
    unsigned int retries   = 0;
    unsigned int remeshes  = 0; // changes of the mesh, and what they took
    double remesh_seconds  = 0;
    Durations step_seconds;

    void
    archive(Archive &archive)
    {
      archive("step", step);
      archive("time", time);
      archive("wall_seconds", wall_seconds);
      archive("stability_limit", stability_limit);
      archive("retries", retries);
      archive("remeshes", remeshes);
      archive("remesh_seconds", remesh_seconds);
      archive("step_seconds", step_seconds);
    }
  };

  /// How a run ended.
  struct Ending
  {
    Verdict::End how = Verdict::End::completed;
    std::string message; // when it is not completed: why
  };

  /// Writes summary.json. Throws RunFailure. Collective.
  template <int dim>
  void write_summary(const std::string &directory,
                     const Ending &ending,
                     const Verdict &verdict,
                     const Components<dim> &components,
                     const Accounts<dim> &accounts,
                     const Statistics &statistics,
                     const RunRecord &record);

  /// What one rank can write of it when the others do not answer, and into log.txt.
  void write_lone_summary(const std::string &directory,
                          const Ending &ending,
                          const Verdict &verdict,
                          const RunRecord &record);
} // namespace feib

#endif
