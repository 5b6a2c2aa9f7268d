// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_simulation_h
#define feib_simulation_h

#include <feib/case.h>
#include <feib/registry.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace feib
{
  /// How far a run has come; told after every step.
  struct Progress
  {
    unsigned int step;
    double time, end;
    double dt;
    double wall_seconds;
  };

  /// What a run may be asked for from outside.
  enum class Request
  {
    none,
    checkpoint,
    stop // with a checkpoint
  };

  /// A checkpoint that a run may go on from.
  struct CheckpointInfo
  {
    std::string folder;
    std::string case_text;      // the exact run, as JSON
    std::string case_directory; // that file names in the case are meant from
    std::map<std::string, std::string> versions;
    unsigned int step = 0;
    double time       = 0;

    /// The newest sound one in the output folder of a run; warns of damaged ones. Throws Error when
    /// there is none. Collective.
    static CheckpointInfo newest(const std::string &run_folder, MPI_Comm communicator);

    /// Throws Error when a run of this case by these programs and files would not go on with what
    /// the checkpoint holds; ends, outputs, step control and checkpoints may differ.
    void check(const Case &description, const std::map<std::string, std::string> &versions) const;
  };

  /// One run of a case, in 2 or 3 dimensions: builds the components the case names, then
  /// refinement -> integrator step -> ledger row -> output, checkpoints, and a summary at the end.
  class Simulation
  {
  public:
    virtual ~Simulation() = default;

    /// Builds all components, makes the first mesh and checks what a schema cannot (structures
    /// inside the box, expressions at the places where they are used, the components' check(),
    /// ...). Throws Error with all issues; writes nothing. @p goes_on: run() will begin with a
    /// checkpoint, so that the earlier flow of "initial_state" need not be there any more.
    /// Collective.
    static std::unique_ptr<Simulation> create(const Case &description, bool goes_on = false);

    /// What a run would take: cells, unknowns, memory, structures, limits of the step; lines of
    /// text. Collective.
    virtual std::string forecast() = 0;

    struct Options
    {
      /// An existing, writable folder.
      std::string directory;
      /// Called on rank 0 after every step; may be empty.
      std::function<void(const Progress &)> on_progress;
      /// Asked after every step, with the same answer on every rank: what a signal asks for. May
      /// be empty.
      std::function<Request()> requested;
      /// What a checkpoint says of the programs and input files it is made by: names, and versions
      /// or checksums.
      std::map<std::string, std::string> versions;
      /// The checkpoint to go on from, a folder; empty: from the start.
      std::string restart;
    };

    /// Runs, writes everything, summary.json included, and logs how it went; the last line begins
    /// with the status. Whether the end was reached: with trouble or a signal the last good state
    /// is written as far as possible, and the status is "failed" or "stopped". Throws LoneFailure
    /// when only this rank failed and the others do not answer.
    virtual bool run(const Options &options) = 0;
  };
} // namespace feib

#endif
