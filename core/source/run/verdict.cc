// SPDX-License-Identifier: LGPL-2.1-or-later
#include "verdict.h"

#include <feib/log.h>

#include <algorithm>

namespace feib
{
  void
  Verdict::warn(const std::string &kind,
                const double time,
                const double value,
                const std::string &message)
  {
    const auto known = std::find_if(list.begin(), list.end(), [&](const Warning &warning) {
      return warning.kind == kind;
    });
    if (known != list.end())
      {
        ++known->count;
        known->worst = std::max(known->worst, value);
        return;
      }
    list.push_back({kind, message, time, 1, value});
    log::warning(message);
  }


  const Warning *
  Verdict::find(const std::string &kind) const
  {
    for (const Warning &warning : list)
      if (warning.kind == kind)
        return &warning;
    return nullptr;
  }


  std::string
  Verdict::status(const End end) const
  {
    switch (end)
      {
        case End::completed:
          return list.empty() ? "completed" : "completed_with_warnings";
        case End::stopped:
          return "stopped";
        default:
          return "failed";
      }
  }


  std::string
  Verdict::sentence(const End end) const
  {
    std::string kinds;
    for (const Warning &warning : list)
      kinds += (kinds.empty() ? "" : ", ") + warning.kind + " " + std::to_string(warning.count) +
               (warning.count == 1 ? " time" : " times");
    return status(end) + (kinds.empty() ? "" : " (" + kinds + ")");
  }


  Json
  Verdict::to_json() const
  {
    Json result = Json::array();
    for (const Warning &warning : list)
      result.push_back({{"kind", warning.kind},
                        {"message", warning.message},
                        {"first_time", warning.time},
                        {"count", warning.count},
                        {"worst", warning.worst}});
    return result;
  }
} // namespace feib
