// SPDX-License-Identifier: LGPL-2.1-or-later
#include "program_options.h"

#include <feib/error.h>

#include <vector>

namespace feib
{
  namespace po = boost::program_options;

  po::variables_map
  parse_options(const int argc,
                const char *const *argv,
                po::options_description options,
                const std::string &rest,
                const std::string &program)
  {
    po::variables_map values;
    const std::string help = "; see " + program + " --help";
    try
      {
        options.add_options()(rest.c_str(), po::value<std::vector<std::string>>());
        po::positional_options_description positional;
        positional.add(rest.c_str(), -1);
        po::store(po::command_line_parser(argc, argv)
                    .options(options)
                    .positional(positional)
                    .style(po::command_line_style::allow_long |
                           po::command_line_style::long_allow_adjacent |
                           po::command_line_style::long_allow_next)
                    .run(),
                  values);
      }
    catch (const po::unknown_option &failure)
      {
        throw Error("unknown option " + failure.get_option_name() + help);
      }
    catch (const po::error &failure)
      {
        throw Error(failure.what() + help);
      }
    return values;
  }
} // namespace feib
