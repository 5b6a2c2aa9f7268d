// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_error_h
#define feib_error_h

#include <feib/issue.h>

#include <stdexcept>

namespace feib
{
  /// A mistake of the user's: a case, a file or a command line that cannot be run. The host prints
  /// every issue with its place in the case and ends with exit code 2; nothing has been written.
  class Error : public std::runtime_error
  {
  public:
    /// An error that has no place in the case (a command line, a missing file).
    explicit Error(const std::string &message);

    /// An error at the value of the case that the JSON pointer names.
    Error(const std::string &pointer, const std::string &message);

    /// Several errors at once.
    explicit Error(Issues issues);

    const Issues &issues() const;

  private:
    Issues issue_list;
  };

  /// Trouble while running: a solver that diverges, a structure that leaves the box, a full disk.
  /// The host keeps the last good state on disk and ends with exit code 1. Thrown by all ranks
  /// alike.
  class RunFailure : public std::runtime_error
  {
  public:
    using std::runtime_error::runtime_error;
  };
} // namespace feib

#endif
