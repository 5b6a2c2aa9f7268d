// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_failure_h
#define feib_failure_h

#include <feib/error.h>

#include <mpi.h>

#include <functional>
#include <string>

namespace feib
{
  /// A failure that no shorter step cures: the run ends without trying one.
  class Incurable : public RunFailure
  {
  public:
    using RunFailure::RunFailure;
  };

  /// A failure of this rank that the others did not hear of: they are somewhere else, perhaps
  /// waiting for this one. All that is left is to say so and to abort.
  class LoneFailure : public std::runtime_error
  {
  public:
    using std::runtime_error::runtime_error;
  };

  /// Runs an action on every rank. When it throws anything on any rank, all ranks throw the same
  /// RunFailure (Incurable if that was thrown), with @p where in front of what was said. The action
  /// is local to its rank, or one whose parts agree by themselves; when it is not and the ranks do
  /// not meet within half a minute, the rank that failed throws LoneFailure. Collective.
  void
  agree(MPI_Comm communicator, const std::function<void()> &action, const std::string &where = "");
} // namespace feib

#endif
