// SPDX-License-Identifier: LGPL-2.1-or-later
#include "checkpoints.h"

#include <feib/message.h>
#include <feib/simulation.h>

namespace feib
{
  namespace
  {
    /// What decides nothing about the states that follow, or what the user may well decide anew.
    const char *const free_to_change[] = {"/$schema",
                                          "/title",
                                          "/time/end",
                                          "/time/step",
                                          "/time/control",
                                          "/time/energy_growth",
                                          "/time/measure_tolerance",
                                          "/output",
                                          "/checkpoint",
                                          "/exact"};

    bool
    may_change(const std::string &pointer)
    {
      for (const std::string head : free_to_change)
        if (pointer == head || pointer.rfind(head + "/", 0) == 0)
          return true;
      return false;
    }


    std::string
    text_of(const Json &value)
    {
      const std::string text = value.dump();
      return text.size() > 100 ? text.substr(0, 97) + "..." : text;
    }


    /// Adds an issue for everything that differs.
    void
    compare(const Json &now, const Json &before, const std::string &pointer, Issues &issues)
    {
      if (now == before || may_change(pointer))
        return;
      if (now.is_object() && before.is_object())
        {
          for (const auto &[key, value] : now.items())
            compare(value, before.value(key, Json()), pointer + pointer_part(key), issues);
          for (const auto &[key, value] : before.items())
            if (!now.contains(key))
              compare(Json(), value, pointer + pointer_part(key), issues);
        }
      else if (now.is_array() && before.is_array() && now.size() == before.size())
        for (std::size_t i = 0; i < now.size(); ++i)
          compare(now[i], before[i], pointer + "/" + std::to_string(i), issues);
      else
        issues.push_back({pointer,
                          "found " + text_of(now) + ", and the run to go on with had " +
                            text_of(before) +
                            "; its end, step, control, outputs and checkpoints may change"});
    }
  } // namespace


  CheckpointInfo
  CheckpointInfo::newest(const std::string &run_folder, const MPI_Comm communicator)
  {
    const auto [folder, manifest] = Checkpoints::newest(run_folder, communicator);
    CheckpointInfo result;
    result.folder         = folder;
    result.case_text      = manifest.at("case").dump(2);
    result.case_directory = manifest.at("case_directory").get<std::string>();
    result.step           = manifest.at("step").get<unsigned int>();
    result.time           = manifest.at("time").get<double>();
    for (const auto &[name, version] : manifest.at("versions").items())
      result.versions[name] = version.get<std::string>();
    return result;
  }


  void
  CheckpointInfo::check(const Case &description,
                        const std::map<std::string, std::string> &present) const
  {
    Issues issues;
    compare(Json::parse(description.resolved()), Json::parse(case_text), "", issues);
    for (const auto &[name, version] : versions)
      {
        const auto now = present.find(name);
        if (name[0] == '/') // a file, of which it is said elsewhere when it is not there
          {
            if (now != present.end() && now->second != version)
              issues.push_back(
                {name, "names a file that has changed since " + folder + " was written"});
          }
        else if (now == present.end() || now->second != version)
          issues.push_back(
            {"",
             "the checkpoint " + folder + " was written with " + name + " " + version +
               (now == present.end() ? ", which is not used now" : ", this is " + now->second)});
      }
    if (const double end = description.parameters().child("time").number("end"); end < time)
      issues.push_back({"/time/end",
                        "found " + readable(end) + ", and the checkpoint " + folder +
                          " is of the time " + readable(time) + " already"});
    if (!issues.empty())
      throw Error(issues);
  }
} // namespace feib
