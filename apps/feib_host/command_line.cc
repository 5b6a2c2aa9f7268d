// SPDX-License-Identifier: LGPL-2.1-or-later
#include "command_line.h"

#include "../program_options.h"

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
         "folder for the results; when not given output/NAME, NAME being the folder of a case called "
         "case.json, else the name of the file without .json")
        ("overwrite", "allow DIR to hold files; those of the same name are replaced")
        ("restart", po::value<std::string>()->value_name("DIR"),
         "go on with the run whose results are in DIR, from its newest checkpoint; instead of a case")
        ("set", po::value<std::vector<std::string>>()->composing()->value_name("/POINTER=VALUE"),
         "change the case: VALUE is JSON, or else a text; may be repeated")
        ("plugin-path", po::value<std::vector<std::string>>()->composing()->value_name("DIR"),
         "look for plugins here first, then in FEIB_PLUGIN_PATH, then where Feib keeps its own; may be repeated")
        ("validate", "check the case and build everything, run nothing, write nothing")
        ("list-plugins", "what was found, and why a plugin was skipped")
        ("describe", po::value<std::string>()->value_name("NAME"), "the parameters of a component")
        ("json", "with --describe: its JSON Schema")
        ("check-plugin", po::value<std::string>()->value_name("FILE.so"),
         "ask of a plugin what can be asked without a compiler, of laws all that their kit asks; writes nothing")
        ("new-plugin", po::value<std::string>()->value_name("KIND NAME"),
         "write the beginning of a plugin, a component of that kind (e.g. constitutive_law): sources, test, case")
        ("energy-only", "with --new-plugin constitutive_law: a law that is given by its energy alone")
        ("with-state", "with --new-plugin constitutive_law: a law that remembers, e.g. how far it was stretched")
        ("dir", po::value<std::string>()->value_name("DIR"),
         "with --new-plugin: the folder to make; when not given NAME")
        ("schema", "print the JSON Schema of cases, for the plugins found")
        ("log-level", po::value<std::string>()->default_value("info")->value_name("L"),
         "trace, debug, info, warning, error or off")
        ("version", "print the version")
        ("help", "print this");
      // clang-format on
      return options;
    }


    std::string
    default_output(const std::string &case_file)
    {
      const std::filesystem::path file   = std::filesystem::absolute(case_file).lexically_normal();
      const std::filesystem::path folder = file.parent_path().filename();
      const bool named_by_folder         = file.filename() == "case.json" && !folder.empty();
      return (std::filesystem::path("output") / (named_by_folder ? folder : file.stem())).string();
    }


    /// Of no kind when none is asked for.
    NewPlugin
    plugin_to_write(const po::variables_map &values, const std::vector<std::string> &names)
    {
      NewPlugin plugin;
      if (values.count("energy-only") != 0)
        plugin.style = "energy_only";
      if (values.count("with-state") != 0)
        {
          if (!plugin.style.empty())
            throw Error("--energy-only and --with-state are two templates; choose one");
          plugin.style = "with_state";
        }
      if (values.count("dir") != 0)
        plugin.directory = values["dir"].as<std::string>();
      if (values.count("new-plugin") == 0)
        {
          if (!plugin.style.empty() || !plugin.directory.empty())
            throw Error("--energy-only, --with-state and --dir go with --new-plugin KIND NAME");
          return plugin;
        }
      plugin.kind = values["new-plugin"].as<std::string>();
      if (names.size() != 1 || plugin.kind.empty())
        throw Error("--new-plugin takes a kind and a name; write --new-plugin constitutive_law "
                    "my_law");
      if (!plugin.style.empty() && plugin.kind != "constitutive_law")
        throw Error("--energy-only and --with-state go with --new-plugin constitutive_law NAME");
      for (const char *const option : {"restart", "output", "overwrite", "set", "validate"})
        if (values.count(option) != 0)
          throw Error(std::string("--new-plugin runs no case: --") + option +
                      " does not go with it");
      plugin.name = names[0];
      if (plugin.directory.empty())
        plugin.directory = plugin.name;
      return plugin;
    }
  } // namespace


  CommandLine::CommandLine(const int argc, const char *const *argv)
  {
    const po::variables_map values = parse_options(argc, argv, options(), "case", "feib-host");

    validate     = values.count("validate") != 0;
    list_plugins = values.count("list-plugins") != 0;
    json         = values.count("json") != 0;
    schema       = values.count("schema") != 0;
    version      = values.count("version") != 0;
    show_help    = values.count("help") != 0;
    overwrite    = values.count("overwrite") != 0;
    log_level    = values["log-level"].as<std::string>();
    if (values.count("plugin-path") != 0)
      plugin_path = values["plugin-path"].as<std::vector<std::string>>();
    if (values.count("describe") != 0)
      describe = values["describe"].as<std::string>();
    if (values.count("set") != 0)
      for (const std::string &setting : values["set"].as<std::vector<std::string>>())
        {
          const std::size_t equals = setting.find('=');
          if (equals == std::string::npos)
            throw Error("--set " + setting + " has no value; write --set /json/pointer=VALUE");
          settings.emplace_back(setting.substr(0, equals), setting.substr(equals + 1));
        }
    if (json && describe.empty())
      throw Error("--json goes with --describe NAME");

    if (values.count("check-plugin") != 0)
      {
        check_plugin = values["check-plugin"].as<std::string>();
        for (const char *const option : {"case",
                                         "restart",
                                         "output",
                                         "overwrite",
                                         "set",
                                         "validate",
                                         "new-plugin",
                                         "describe",
                                         "list-plugins",
                                         "schema"})
          if (values.count(option) != 0)
            throw Error("--check-plugin FILE.so looks at a plugin and does nothing else; found " +
                        std::string(option == std::string("case") ? "a case" : "--") +
                        (option == std::string("case") ? "" : option) + " too");
      }
    if (values.count("restart") != 0)
      restart = values["restart"].as<std::string>();
    const auto cases = values.count("case") != 0 ? values["case"].as<std::vector<std::string>>()
                                                 : std::vector<std::string>();
    new_plugin       = plugin_to_write(values, cases);
    if (!new_plugin.kind.empty())
      return;
    if (cases.size() > 1)
      throw Error("one case at a time, found " + cases[0] + " and " + cases[1]);
    if (!restart.empty())
      {
        if (!cases.empty())
          throw Error("--restart " + restart + " goes on with the case it was begun with; found " +
                      cases[0] + " too");
        if (values.count("output") != 0 || overwrite)
          throw Error("--restart goes on in the folder of the run: --output and --overwrite do not "
                      "go with it");
      }
    if (!cases.empty())
      case_file = cases[0];
    else if (restart.empty() && describe.empty() && check_plugin.empty() && !list_plugins &&
             !schema && !version && !show_help)
      throw Error("which case? feib-host CASE.json runs it; see feib-host --help");
    if (values.count("output") != 0)
      output = values["output"].as<std::string>();
    else if (!restart.empty())
      output = restart;
    else if (!case_file.empty())
      output = default_output(case_file);
  }


  std::string
  CommandLine::help()
  {
    std::ostringstream text;
    text << "feib-host CASE.json [options]\n"
            "feib-host --restart DIR [options]\n"
            "feib-host --new-plugin KIND NAME [--energy-only | --with-state] [--dir DIR]\n"
            "feib-host --check-plugin FILE.so\n"
            "Runs an immersed fluid-structure simulation.\n\n"
         << options()
         << "\nExit codes: 0 done, 1 trouble while running, 2 a case or a command line that cannot "
            "be run, a plugin that fails a check.\n";
    return text.str();
  }
} // namespace feib
