// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_command_line_h
#define feib_command_line_h

#include <feib/case.h>

#include "new_plugin.h"

#include <string>
#include <vector>

namespace feib
{
  /// What the user asks of feib-host.
  struct CommandLine
  {
    /// Throws Error on usage that makes no sense.
    CommandLine(int argc, const char *const *argv);

    /// The text of --help.
    static std::string help();

    std::string case_file;
    std::string output;  // the folder the results go to
    std::string restart; // the output folder of a run to go on with
    Case::Settings settings;
    std::vector<std::string> plugin_path;
    std::string describe;
    std::string check_plugin; // a file
    NewPlugin new_plugin;     // of no kind: none is to be written
    std::string log_level;

    bool validate     = false;
    bool list_plugins = false;
    bool json         = false;
    bool schema       = false;
    bool version      = false;
    bool show_help    = false;
    bool overwrite    = false;
  };
} // namespace feib

#endif
