// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_checkpoints_h
#define feib_source_checkpoints_h

#include "json.h"

#include <feib/parameters.h>

#include <deal.II/base/mpi.h>

#include <chrono>
#include <functional>
#include <string>

namespace feib
{
  /// The checkpoints of a run: which are written when, how many are kept, and which one to go on
  /// from. They are folders in `checkpoints` of the run's folder, named by the step.
  class Checkpoints
  {
  public:
    /// From the block "checkpoint" of a case.
    explicit Checkpoints(const Parameters &parameters);

    /// Whether one is due after this step; the same on all ranks. Collective.
    bool due(unsigned int step, MPI_Comm communicator) const;

    /// Writes one: @p fill gets the archive and the state's folder, which takes the name it is
    /// found by when all is on the disk; those beyond the number to keep go. @p manifest: what the
    /// checkpoint says of itself. Throws RunFailure. Collective.
    void write(const std::string &run_folder,
               unsigned int step,
               Json manifest,
               MPI_Comm communicator,
               const std::function<void(const std::string &folder)> &fill);

    /// The newest sound checkpoint of a run's folder and its manifest; warns of damaged ones.
    /// Throws Error when there is none. Collective.
    static std::pair<std::string, Json> newest(const std::string &run_folder,
                                               MPI_Comm communicator);

  private:
    const unsigned int interval, keep;
    const double seconds;
    std::chrono::steady_clock::time_point last;
    int last_step = -1;
  };
} // namespace feib

#endif
