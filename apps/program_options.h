// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_apps_program_options_h
#define feib_apps_program_options_h

#include <boost/program_options.hpp>

#include <string>

namespace feib
{
  /// What was given on the command line of a program: its long options, never abbreviated, and the
  /// rest as a vector of strings by the name @p rest. Throws Error, which names @p program.
  boost::program_options::variables_map
  parse_options(int argc,
                const char *const *argv,
                boost::program_options::options_description options,
                const std::string &rest,
                const std::string &program);
} // namespace feib

#endif
