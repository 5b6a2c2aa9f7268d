// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_log_h
#define feib_log_h

#include <string>

/// Logging for the core and for plugins: one logger for the whole program, rank 0 speaks.
namespace feib::log
{
  /// Level by name: trace, debug, info, warning, error, off. Throws Error on another name.
  void set_level(const std::string &level);

  /// From now on lines also go to this file (rank 0). The file records every level from info on,
  /// and the lower ones when the console shows them. Collective. Throws RunFailure when it cannot
  /// be written. @p append: after what is in it, instead of anew.
  void open_file(const std::string &file, bool append = false);

  /// Shows a line that the next one replaces, on a terminal only; never in the file.
  void status(const std::string &line);

  void debug(const std::string &message);
  void info(const std::string &message);
  void warning(const std::string &message);
  void error(const std::string &message);
} // namespace feib::log

#endif
