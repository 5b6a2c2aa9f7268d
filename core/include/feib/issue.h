// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_issue_h
#define feib_issue_h

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace feib
{
  /// One thing that is wrong with a case: where (a JSON pointer into the case) and what, in a
  /// sentence that says what was found and what is allowed.
  struct Issue
  {
    std::string pointer;
    std::string message;
    /// The offset in the text of the case, where no pointer can name the place (a syntax error).
    std::optional<std::size_t> offset = {};
  };

  using Issues = std::vector<Issue>;
} // namespace feib

#endif
