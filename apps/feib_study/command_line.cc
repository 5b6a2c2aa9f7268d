// SPDX-License-Identifier: LGPL-2.1-or-later
#include "command_line.h"

#include "../program_options.h"

#include <feib/error.h>

#include <boost/program_options.hpp>

#include <filesystem>
#include <sstream>

namespace feib
{
  namespace
  {
    namespace po = boost::program_options;

    po::options_description
    options()
    {
      po::options_description options("Options", 100);
      // clang-format off
      options.add_options()
        ("output", po::value<std::string>()->value_name("DIR"),
         "folder for the runs and the table; when not given output/NAME, NAME being the name of the "
         "file without .json or .study.json")
        ("jobs", po::value<int>()->value_name("N"),
         "runs at the same time; when not given as many as there are cores for")
        ("plugin-path", po::value<std::vector<std::string>>()->composing()->value_name("DIR"),
         "handed on to feib-host; may be repeated")
        ("validate", "check the study and the case of every combination, run nothing, write nothing")
        ("version", "print the version")
        ("help", "print this");
      // clang-format on
      return options;
    }


    std::string
    default_output(const std::string &study_file)
    {
      std::string name = std::filesystem::path(study_file).filename().string();
      for (const std::string ending : {".json", ".study"})
        if (name.size() > ending.size() &&
            name.compare(name.size() - ending.size(), ending.size(), ending) == 0)
          name.erase(name.size() - ending.size());
      return (std::filesystem::path("output") / name).string();
    }
  } // namespace


  StudyCommandLine::StudyCommandLine(const int argc, const char *const *argv)
  {
    const po::variables_map values = parse_options(argc, argv, options(), "study", "feib-study");

    validate  = values.count("validate") != 0;
    version   = values.count("version") != 0;
    show_help = values.count("help") != 0;
    if (values.count("plugin-path") != 0)
      plugin_path = values["plugin-path"].as<std::vector<std::string>>();
    if (values.count("jobs") != 0)
      {
        if (values["jobs"].as<int>() < 1)
          throw Error("--jobs must be at least 1, found " +
                      std::to_string(values["jobs"].as<int>()));
        jobs = values["jobs"].as<int>();
      }

    const auto studies = values.count("study") != 0 ? values["study"].as<std::vector<std::string>>()
                                                    : std::vector<std::string>();
    if (studies.size() > 1)
      throw Error("one study at a time, found " + studies[0] + " and " + studies[1]);
    if (!studies.empty())
      study_file = studies[0];
    else if (!version && !show_help)
      throw Error("which study? feib-study STUDY.json runs it; see feib-study --help");
    if (values.count("output") != 0)
      output = values["output"].as<std::string>();
    else if (!study_file.empty())
      output = default_output(study_file);
  }


  std::string
  StudyCommandLine::help()
  {
    std::ostringstream text;
    text << "feib-study STUDY.json [options]\n"
            "Runs a case for every combination of settings and prints a table of the results.\n"
            "Runs that an earlier call has finished are not repeated.\n\n"
         << options()
         << "\nExit codes: 0 all runs ended (completed or failed), 1 trouble while running or "
            "interrupted, 2 a study, a case or a command line that cannot be run.\n";
    return text.str();
  }
} // namespace feib
