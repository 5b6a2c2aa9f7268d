// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_study_runs_h
#define feib_study_runs_h

#include "command_line.h"
#include "processes.h"
#include "study.h"

#include <filesystem>
#include <map>

namespace feib
{
  /// One run of the case.
  struct Run
  {
    std::string label; // for people: "scheme=fe_be, dt=0.1"
    std::string folder;
    Settings settings;
  };


  /// What became of a run.
  struct Outcome
  {
    std::string status; // "completed", "completed_with_warnings", "failed" or "no result"
    Json summary;       // what summary.json holds; null without result

    bool
    completed() const
    {
      return status.rfind("completed", 0) == 0;
    }
  };


  /// One combination of values of the axes, a row of the table.
  struct Combination
  {
    std::vector<std::size_t> values; // of each axis, an index
    Json limit;                      // what the bisection found
    Outcome outcome;                 // of its run; of the largest completed one of a bisection
  };


  /// The runs of a study: which there are, which are done, and doing the others.
  class Runs
  {
  public:
    Runs(const Study &study, const StudyCommandLine &command);

    /// Lets feib-host check the case of every combination that has no result yet. Throws Error with
    /// the host's own words at the first that cannot be run.
    void validate();

    /// Runs what has no result yet. Throws RunFailure when interrupted.
    void run();

    const std::vector<Combination> &
    combinations() const
    {
      return all;
    }

    /// Runs this call has done, runs found done, and runs that ended without a result.
    unsigned int n_done = 0, n_found = 0, n_lost = 0;

  private:
    const Study &study;
    const StudyCommandLine &command;
    const unsigned int jobs;
    ProcessQueue queue;
    std::vector<Combination> all;
    std::map<std::string, Outcome> outcomes; // by folder of the run

    /// The run of a combination, or the one of its bisection with a value.
    Run make_run(const Combination &combination, std::optional<double> value = {}) const;

    /// The command that lets feib-host work on a run, without MPI or with it.
    std::vector<std::string> host(const Run &run, unsigned int ranks) const;

    /// The outcome of a run of this call or, if its record fits, of an earlier one.
    const Outcome *find(const Run &run);

    /// The text of run.json: whatever decides on the result of a run, and how it ended.
    std::string record(const Run &run, int exit_code) const;

    /// Goes on with a combination as far as the results are known, then queues the next run.
    void proceed(Combination &combination);

    void start(const Run &run, Combination &combination);

    void finish(const Run &run, int exit_code);
  };


  /// Writes a file whole or not at all. Throws RunFailure when it cannot.
  void write_file(const std::filesystem::path &file, const std::string &text);
} // namespace feib

#endif
