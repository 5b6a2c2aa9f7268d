// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_simulation_h
#define feib_simulation_h

#include <feib/case.h>
#include <feib/registry.h>

#include <functional>
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

  /// One run of a case, in 2 or 3 dimensions: builds the components the case names, then
  /// integrator step -> ledger row -> refinement -> output, and a summary at the end.
  class Simulation
  {
  public:
    virtual ~Simulation() = default;

    /// Builds all components, makes the first mesh and checks what a schema cannot (structures
    /// inside the box, expressions at the places where they are used, the components' check(),
    /// ...). Throws Error with all issues; writes nothing. Collective.
    static std::unique_ptr<Simulation> create(const Case &description);

    /// What a run would take: cells, unknowns, memory, structures, limits of the step; lines of
    /// text. Collective.
    virtual std::string forecast() = 0;

    struct Options
    {
      /// An existing, writable folder.
      std::string directory;
      /// Called on rank 0 after every step; may be empty.
      std::function<void(const Progress &)> on_progress;
      /// Asked after every step, on every rank: whether to stop early (a signal). May be empty.
      std::function<bool()> stop_requested;
    };

    /// Runs, writes everything, summary.json included, and logs how it went; the last line begins
    /// with the status. Whether the end was reached: with trouble or a signal the last good state
    /// is written as far as possible, and the status is "failed" or "stopped". Throws LoneFailure
    /// when only this rank failed and the others do not answer.
    virtual bool run(const Options &options) = 0;
  };
} // namespace feib

#endif
