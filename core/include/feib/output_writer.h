// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_output_writer_h
#define feib_output_writer_h

#include <feib/archive.h>
#include <feib/check_context.h>
#include <feib/eulerian_space.h>
#include <feib/immersed_structure.h>
#include <feib/ledger.h>

#include <string>

namespace feib
{
  /// Writes what a person or a program looks at.
  template <int dim>
  class OutputWriter
  {
  public:
    static constexpr const char *kind = "output_writer";

    /// The state at the end of a step.
    struct Snapshot
    {
      unsigned int step;
      double time;
      const std::string &directory;
      const EulerianSpace<dim> &space;
      const std::vector<ImmersedStructure<dim>> &structures;
      const Ledger &ledger;
    };

    virtual ~OutputWriter() = default;

    /// Before a run, when nothing has been written: throws Error with all that the case asks for
    /// and that cannot be. Collective.
    virtual void
    check(const CheckContext<dim> &)
    {}

    /// What the object carries from step to step. Collective.
    virtual void
    archive(Archive &)
    {}

    /// Steps between two calls of write(); the first and the last state are always written.
    virtual unsigned int interval() const = 0;

    /// After archive() has read: goes on with the files in a folder, without what was written to
    /// them after the archived state. @p communicator: the ranks of the space. Collective. Throws
    /// RunFailure, on all ranks, when they are not there.
    virtual void
    reopen(const std::string &directory, const MPI_Comm communicator)
    {
      (void)directory;
      (void)communicator;
    }

    /// Collective. Throws RunFailure, on all ranks, when a file cannot be written.
    virtual void write(const Snapshot &snapshot) = 0;
  };
} // namespace feib

#endif
