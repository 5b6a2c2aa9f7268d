// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/error.h>

namespace feib
{
  namespace
  {
    std::string
    joined(const Issues &issues)
    {
      std::string text;
      for (const Issue &issue : issues)
        text += (text.empty() ? "" : "\n") + (issue.pointer.empty() ? "" : issue.pointer + ": ") +
                issue.message;
      return text;
    }
  } // namespace


  Error::Error(const std::string &message)
    : Error(Issues{{"", message}})
  {}


  Error::Error(const std::string &pointer, const std::string &message)
    : Error(Issues{{pointer, message}})
  {}


  Error::Error(Issues issues)
    : std::runtime_error(joined(issues))
    , issue_list(std::move(issues))
  {}


  const Issues &
  Error::issues() const
  {
    return issue_list;
  }
} // namespace feib
