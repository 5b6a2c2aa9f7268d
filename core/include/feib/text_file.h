// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_text_file_h
#define feib_text_file_h

#include <mpi.h>

#include <string>

namespace feib
{
  /// The text of a file, read by the first rank and told to all: the others need not be able to
  /// read it, and all agree on a failure, thrown as Error("NAMED: is a folder") and the like. Only
  /// @p regular files: waiting for somebody to write into a fifo is not what a run should do.
  /// Collective (MPI need not run).
  std::string read_text_file(const std::string &file,
                             const std::string &named,
                             bool regular,
                             MPI_Comm communicator = MPI_COMM_WORLD);
} // namespace feib

#endif
