// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_study_command_line_h
#define feib_study_command_line_h

#include <string>
#include <vector>

namespace feib
{
  /// What the user asks of feib-study.
  struct StudyCommandLine
  {
    /// Throws Error on usage that makes no sense.
    StudyCommandLine(int argc, const char *const *argv);

    /// The text of --help.
    static std::string help();

    std::string study_file;
    std::string output; // the folder the runs and the table go to
    std::vector<std::string> plugin_path;
    unsigned int jobs = 0; // 0: as many as the cores allow

    bool validate  = false;
    bool version   = false;
    bool show_help = false;
  };
} // namespace feib

#endif
