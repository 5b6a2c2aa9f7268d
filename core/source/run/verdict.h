// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_verdict_h
#define feib_verdict_h

#include "json.h"

#include <feib/archive.h>

#include <string>
#include <vector>

namespace feib
{
  /// Something doubtful about a run that does not end it.
  struct Warning
  {
    std::string kind;       // one word; one entry per kind
    std::string message;    // of the first
    double time        = 0; // of the first
    unsigned int count = 0;
    double worst       = 0; // the largest of what the kind measures

    void
    archive(Archive &archive)
    {
      archive("kind", kind);
      archive("message", message);
      archive("time", time);
      archive("count", count);
      archive("worst", worst);
    }
  };

  /// Gathers what is doubtful about a run, and says in the end how far it can be believed. The
  /// kinds are listed in docs/start.md.
  class Verdict
  {
  public:
    enum class End
    {
      completed,
      stopped, // by a signal
      failed
    };

    /// Counts a warning; the first one of a kind is logged.
    void warn(const std::string &kind, double time, double value, const std::string &message);

    const std::vector<Warning> &
    warnings() const
    {
      return list;
    }

    /// The warning of a kind, or null.
    const Warning *find(const std::string &kind) const;

    /// completed, completed_with_warnings, stopped or failed.
    std::string status(End end) const;

    /// The status in words, with the kinds of warnings: the last line of a run.
    std::string sentence(End end) const;

    /// The list `warnings` of summary.json.
    Json to_json() const;

    void
    archive(Archive &archive)
    {
      archive("warnings", list);
    }

  private:
    std::vector<Warning> list;
  };
} // namespace feib

#endif
