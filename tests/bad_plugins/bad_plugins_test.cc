// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/run_host.h"

#include <feib/plugin.h>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <filesystem>

using namespace feib::testing;

namespace
{
  /// What --list-plugins says with the folder first on the path.
  std::string
  listed(const std::string &folder)
  {
    const RunResult result = run_host("--list-plugins --plugin-path " + shell_quoted(folder));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return result.output;
  }

  /// The reason why a plugin of the folder was skipped.
  std::string
  reason(const std::string &output, const std::string &folder, const std::string &plugin)
  {
    const std::string line  = "\n  " + folder + "/" + plugin + ".feib.so: ";
    const std::size_t start = output.find(line, output.find("\nSkipped:"));
    if (start == std::string::npos)
      return "not skipped";
    return output.substr(start + line.size(), output.find('\n', start + 1) - start - line.size());
  }

  std::string
  bad(const std::string &plugin)
  {
    static const std::string output = listed(FEIB_BAD_PLUGINS);
    EXPECT_NE(output.find("\n    constitutive_law/good_law\n"), std::string::npos)
      << "the rest must remain usable: " << output;
    EXPECT_EQ(output.find("constitutive_law/" + plugin + "_law"), std::string::npos)
      << "a refused plugin must not leave anything: " << output;
    return reason(output, FEIB_BAD_PLUGINS, plugin);
  }
} // namespace

// Two plugins may call two things by one name.
TEST(Plugins, ExportTheirDescriptionAndNothingElse)
{
  unsigned int n = 0;
  for (const auto &entry : std::filesystem::directory_iterator(FEIB_PLUGINS))
    if (entry.path().extension() == ".so")
      {
        ++n;
        const RunResult symbols =
          run_command("nm -D --defined-only --format=posix " + shell_quoted(entry.path()));
        EXPECT_EQ(symbols.output.substr(0, symbols.output.find(' ')), "feib_plugin")
          << entry.path();
        EXPECT_EQ(std::count(symbols.output.begin(), symbols.output.end(), '\n'), 1)
          << entry.path();
      }
  EXPECT_GT(n, 15u);
}

TEST(BadPlugins, OlderAbi)
{
  EXPECT_EQ(bad("older_abi"),
            "was built for interface version 0; this is version " + std::to_string(FEIB_ABI) +
              ": rebuild it");
}

TEST(BadPlugins, OtherBuildType)
{
  const std::string text = bad("other_build");
  EXPECT_EQ(text.substr(0, 24), "was built with \"deal.II ");
  EXPECT_NE(text.find("debug"), std::string::npos);
  EXPECT_NE(text.find("release"), std::string::npos);
}

TEST(BadPlugins, HeadersChangedWithoutANewBuild)
{
  const std::string text = bad("other_headers");
  EXPECT_NE(text.find(", headers 0123456789abcdef\"; this is \"" FEIB_BUILD_TAG "\": rebuild it"),
            std::string::npos)
    << text;
}

TEST(BadPlugins, WrongSize)
{
  EXPECT_EQ(bad("small_description"),
            "has a description of 8 bytes, and not of " + std::to_string(sizeof(FeibPlugin)) +
              ": it is not a Feib plugin");
  EXPECT_EQ(bad("a_function"),
            "has a symbol feib_plugin that is not data: it is not a Feib plugin");
}

// --schema > file and --describe NAME --json must stay what they say they are.
TEST(BadPlugins, Printing)
{
  EXPECT_EQ(
    bad("printing").rfind("prints while it is loaded, \"hello from the plugin\\u000a...", 0), 0u)
    << bad("printing");
  const RunResult schema = run_host("--schema --plugin-path " + shell_quoted(FEIB_BAD_PLUGINS));
  EXPECT_EQ(schema.exit_code, 0);
  EXPECT_TRUE(nlohmann::json::accept(schema.output)) << schema.output.substr(0, 100);
}

TEST(BadPlugins, SchemasThatNobodyCanRead)
{
  EXPECT_EQ(bad("large_schema").substr(0, 59),
            "the schema of the constitutive_law \"large_schema_law\" has 1");
  EXPECT_NE(bad("large_schema").find(" bytes; at most 1048576 are allowed"), std::string::npos);
  EXPECT_NE(bad("deep_schema").find("nested deeper than 100 levels"), std::string::npos)
    << bad("deep_schema");
  EXPECT_NE(bad("foreign_letters").find("is not UTF-8"), std::string::npos)
    << bad("foreign_letters");
}

TEST(BadPlugins, MissingSymbol)
{
  EXPECT_EQ(bad("missing_symbol"),
            "cannot be loaded: undefined symbol: _Z23a_function_nobody_wrotev");
}

TEST(BadPlugins, NotAPlugin)
{
  EXPECT_EQ(bad("no_plugin"), "has no symbol feib_plugin: it is not a Feib plugin");
}

TEST(BadPlugins, DuplicateComponent)
{
  EXPECT_EQ(bad("duplicate"),
            "the constitutive_law \"good_law\" exists already, from " +
              std::string(FEIB_BAD_PLUGINS "/a_good.feib.so"));
}

TEST(BadPlugins, SchemaThatBreaksTheRules)
{
  EXPECT_EQ(
    bad("bad_schema"),
    "the schema of the constitutive_law \"worse_schema_law\" breaks the rules at /properties/c: "
    "must be required, have a default, or say in its description what holds \"when not given\"");
}

TEST(BadPlugins, Throwing)
{
  EXPECT_EQ(bad("throwing"), "cannot find the licence key");
}

TEST(BadPlugins, ThrowingWhatIsNoException)
{
  EXPECT_EQ(bad("throwing_int"),
            "throws something that is no std::exception while it adds its components");
}

TEST(BadPlugins, HolesInThePlainData)
{
  EXPECT_EQ(bad("no_build_tag"), "has no build tag: it is not a Feib plugin");
  EXPECT_EQ(bad("no_name"), "has no name: it is not a Feib plugin");
  EXPECT_EQ(bad("no_version"), "has no version: it is not a Feib plugin");
  EXPECT_EQ(bad("no_function"), "has no function that adds components: it is not a Feib plugin");
  EXPECT_EQ(bad("endless_name"), "has a name without end: it is not a Feib plugin");
}

TEST(BadPlugins, WhatIsNoFileIsNotOpened)
{
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "fifo.feib.so").c_str(), 0600), 0);
  std::filesystem::create_symlink("fifo.feib.so", folder / "link_to_fifo.feib.so");
  std::filesystem::create_symlink("/dev/zero", folder / "device.feib.so");
  std::filesystem::create_symlink("nothing", folder / "dangling.feib.so");
  std::filesystem::create_symlink("loop.feib.so", folder / "loop.feib.so");
  std::filesystem::create_directory(folder / "folder.feib.so");
  const std::string output = listed(folder.path.string());
  const auto why           = [&](const std::string &plugin) {
    return reason(output, folder.path.string(), plugin);
  };
  EXPECT_EQ(why("fifo"), "is a fifo, not a file");
  EXPECT_EQ(why("link_to_fifo"), "is a fifo, not a file");
  EXPECT_EQ(why("device"), "is a device, not a file");
  EXPECT_EQ(why("dangling"), "is a link to nothing");
  EXPECT_EQ(why("loop").substr(0, 14), "cannot be read");
  EXPECT_EQ(why("folder"), "is a folder");
}

namespace
{
  RunResult
  ended(const std::string &how, const unsigned int ranks = 1)
  {
    return run_command("export FEIB_TEST_END=" + how + "; " + host_command(ranks) +
                       " --list-plugins --plugin-path " + shell_quoted(FEIB_BAD_PLUGINS "/ending"));
  }
} // namespace

TEST(BadPlugins, EndingTheProgramIsSaid)
{
  const std::string sentence = "error: the plugin " FEIB_BAD_PLUGINS
                               "/ending/ending.feib.so ended the program while it was loaded\n";
  for (const std::string &how : {std::string("exit"),
                                 std::string("quick_exit"),
                                 std::string("terminate"),
                                 std::string("throw"),
                                 std::to_string(SIGABRT),
                                 std::to_string(SIGSEGV),
                                 std::to_string(SIGFPE)})
    {
      const RunResult result = ended(how);
      EXPECT_EQ(result.exit_code,
                how == "exit" || how == "quick_exit"   ? 1
                : how == "terminate" || how == "throw" ? 128 + SIGABRT
                                                       : 128 + std::stoi(how))
        << result.output;
      EXPECT_NE(result.output.find(sentence), std::string::npos) << how << ": " << result.output;
    }
  EXPECT_EQ(ended("''").exit_code, 0) << "without being told it loads";
  EXPECT_NE(ended("exit", 2).exit_code, 0);
}

namespace
{
  /// Whether a text is a pattern with "..." for anything.
  bool
  fits(const std::string &text, const std::string &pattern)
  {
    std::size_t at = 0, begin = 0;
    while (true)
      {
        const std::size_t end   = pattern.find("...", begin);
        const std::string part  = pattern.substr(begin, end - begin);
        const std::size_t place = text.find(part, at);
        if (place == std::string::npos || (begin == 0 && place != 0))
          return false;
        at = place + part.size();
        if (end == std::string::npos)
          return at == text.size();
        begin = end + 3;
        if (begin == pattern.size())
          return true;
      }
  }

  /// All that --list-plugins says of the files it skips in a folder.
  std::vector<std::string>
  reasons(const std::string &folder)
  {
    std::vector<std::string> result;
    std::istringstream lines(listed(folder));
    const std::string start = "  " + folder + "/", middle = ".feib.so: ";
    for (std::string line; std::getline(lines, line);)
      if (const std::size_t place = line.find(middle);
          line.rfind(start, 0) == 0 && place != std::string::npos)
        result.push_back(line.substr(place + middle.size()));
    return result;
  }
} // namespace

// What docs/writing_a_plugin.md lists is what is printed, and all of it.
TEST(BadPlugins, EveryReasonIsDocumented)
{
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "fifo.feib.so").c_str(), 0600), 0);
  std::filesystem::create_symlink("/dev/zero", folder / "device.feib.so");
  std::filesystem::create_symlink("nothing", folder / "dangling.feib.so");
  std::filesystem::create_symlink("loop.feib.so", folder / "loop.feib.so");
  std::filesystem::create_directory(folder / "folder.feib.so");
  folder.write("text.feib.so", "text");
  std::string library = read_file(FEIB_BAD_PLUGINS "/a_good.feib.so");
  folder.write("short.feib.so", library.substr(0, library.size() / 2));
  library[4] = 1; // the class of 32 bits
  folder.write("small.feib.so", library);
  std::vector<std::string> printed = reasons(folder.path.string());
  for (const std::string &reason : reasons(FEIB_BAD_PLUGINS))
    printed.push_back(reason);
  const std::string missing = run_host("--check-plugin " + shell_quoted(folder / "none")).output,
                    before  = ": refused: ";
  printed.push_back(missing.substr(missing.find(before) + before.size()));
  printed.back().pop_back(); // the end of the line
  ASSERT_GT(printed.size(), 25u);

  const std::string page = read_file(FEIB_SOURCE "/docs/writing_a_plugin.md");
  const std::size_t begin =
    page.find("\n", page.find("```text\n", page.find("## Why did my plugin not load?"))) + 1;
  std::istringstream lines(page.substr(begin, page.find("```", begin) - begin));
  std::vector<std::string> patterns;
  for (std::string line; std::getline(lines, line);)
    patterns.push_back(line);
  for (const std::string &pattern : patterns)
    EXPECT_TRUE(std::any_of(printed.begin(),
                            printed.end(),
                            [&](const std::string &reason) { return fits(reason, pattern); }))
      << "nothing was refused like this: " << pattern;
  for (const std::string &reason : printed)
    EXPECT_TRUE(reason == "cannot find the licence key" || // the plugin's own
                std::any_of(patterns.begin(),
                            patterns.end(),
                            [&](const std::string &pattern) { return fits(reason, pattern); }))
      << "docs/writing_a_plugin.md does not have it: " << reason;
}

/// What --check-plugin says.
TEST(CheckPlugin, SaysWhatARunSays)
{
  const auto check = [](const std::string &file) {
    return run_host("--check-plugin " + shell_quoted(file));
  };
  for (const std::string plugin : {"older_abi", "other_headers", "bad_schema", "throwing"})
    {
      const std::string file = FEIB_BAD_PLUGINS "/" + plugin + ".feib.so";
      const RunResult result = check(file);
      EXPECT_EQ(result.exit_code, 2);
      EXPECT_EQ(result.output, file + ": refused: " + bad(plugin) + "\n");
    }
  const RunResult missing = check("nowhere/nothing.feib.so");
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_EQ(missing.output, "nowhere/nothing.feib.so: refused: does not exist\n");
}

TEST(CheckPlugin, EndsWellForGoodOnesOnAnyNumberOfRanks)
{
  const TemporaryFolder folder;
  for (const std::string plugin : {"gent", "midpoint", "vtu"})
    for (const unsigned int ranks : {1, 2})
      {
        const RunResult result = run_host("--check-plugin " FEIB_PLUGINS "/" + plugin + ".feib.so",
                                          ranks,
                                          folder.path.string());
        EXPECT_EQ(result.exit_code, 0) << result.output;
        EXPECT_NE(result.output.find(" checks passed\n"), std::string::npos) << result.output;
        EXPECT_EQ(result.output.find("not checked without a compiler") == std::string::npos,
                  plugin == "gent")
          << result.output;
      }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
}

TEST(CheckPlugin, WhatAComponentThrowsIsAFinding)
{
  const RunResult result = run_host("--check-plugin " FEIB_BAD_PLUGINS "/a_good.feib.so");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.output.find(
              "\nconstitutive_law/good_law\n  an example for every dimension: ok\n"),
            std::string::npos)
    << result.output;
  EXPECT_NE(result.output.find("\"failing_law\" cannot be made: the table is empty"),
            std::string::npos)
    << result.output;
}

TEST(CheckPlugin, EndingTheProgramDoesNotPass)
{
  const RunResult result =
    run_command("export FEIB_TEST_END='when made'; " + host_command() +
                " --check-plugin " FEIB_BAD_PLUGINS "/ending/ending.feib.so");
  EXPECT_EQ(result.exit_code, 2) << result.output;
  EXPECT_NE(result.output.find("error: the plugin ended the program while it was checked"),
            std::string::npos)
    << result.output;
}

TEST(CheckPlugin, DoesNothingElse)
{
  for (const std::string more : {"case.json", "--validate", "--describe gent", "--schema"})
    {
      const RunResult result = run_host("--check-plugin x.feib.so " + more);
      EXPECT_EQ(result.exit_code, 2);
      EXPECT_NE(result.output.find(
                  "--check-plugin FILE.so looks at a plugin and does nothing else"),
                std::string::npos)
        << result.output;
    }
}

TEST(BadPlugins, SignalsWhilePluginsAreLoaded)
{
  for (const auto &[number, name] : {std::pair<int, std::string>{SIGINT, "INT"},
                                     {SIGTERM, "TERM"},
                                     {SIGHUP, "HUP"},
                                     {SIGUSR2, "USR2"},
                                     {SIGXCPU, "XCPU"}})
    {
      const RunResult result = ended(std::to_string(number));
      EXPECT_EQ(result.exit_code, 128 + number);
      EXPECT_EQ(result.output, "error: stopped by the signal " + name + " before the run began\n");
    }
}

namespace
{
  /// A square of a law of these plugins, with its stiffness c.
  std::string
  square(const std::string &law, const std::string &c)
  {
    return R"({
      "dimension": 2,
      "domain": { "cells": [2, 2] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 1 } },
      "structures": [ { "hyperelastic": { "name": "a", "law": { ")" +
           law + R"(": { "c": )" + c + R"( } },
        "mesh": { "rectangle": { "lower": [0.4, 0.4], "upper": [0.6, 0.6], "cells": [1, 1] } } } } ],
      "time": { "step": 0.1, "end": 0.1 } })";
  }

  RunResult
  run_square(const TemporaryFolder &folder,
             const std::string &law,
             const std::string &c,
             const unsigned int ranks)
  {
    const std::string file = folder.write("case.json", square(law, c));
    return run_host("--output " + shell_quoted(folder / "out") + " --plugin-path " +
                      shell_quoted(FEIB_BAD_PLUGINS) + " " + shell_quoted(file),
                    ranks);
  }

  const std::vector<std::pair<std::string, std::string>> ways_of_failing = {
    {"1", "it throws something that is no std::exception"},
    {"2", "the table is empty"},
    {"4", "out of memory"}};
} // namespace

TEST(BadPlugins, AComponentThatCannotBeMadeIsNamed)
{
  for (const auto &[c, why] : std::vector<std::pair<std::string, std::string>>{
         {"1", "it throws something that is no std::exception"},
         {"2", "the table is empty"},
         {"3",
          "a component asks for /structures/0/hyperelastic/law/failing_law/not_in_the_schema"}})
    for (const unsigned int ranks : {1, 2})
      {
        const TemporaryFolder folder;
        const RunResult result = run_square(folder, "failing_law", c, ranks);
        EXPECT_EQ(result.exit_code, 1) << result.output;
        for (const std::string &part :
             {std::string("error: /structures/0/hyperelastic"),
              "/law/failing_law: the constitutive_law \"failing_law\" cannot be made: " + why,
              std::string("from the plugin " FEIB_BAD_PLUGINS "/a_good.feib.so")})
          EXPECT_NE(result.output.find(part), std::string::npos) << part << '\n' << result.output;
        EXPECT_FALSE(std::filesystem::exists(folder / "out"));
      }
}

TEST(BadPlugins, WhatALawThrowsIsSaidBeforeTheRun)
{
  for (const auto &[c, why] : ways_of_failing)
    for (const unsigned int ranks : {1, 2})
      {
        const TemporaryFolder folder;
        const RunResult result = run_square(folder, "throwing_stress", c, ranks);
        EXPECT_EQ(result.exit_code, 2) << result.output;
        for (const std::string &part : {std::string("error: /structures/0/hyperelastic/law: "),
                                        "structure \"a\" fails in its stress: " + why})
          EXPECT_NE(result.output.find(part), std::string::npos) << part << '\n' << result.output;
        EXPECT_FALSE(std::filesystem::exists(folder / "out"));
      }
}

TEST(BadPlugins, NotALibrary)
{
  const TemporaryFolder folder;
  folder.write("text.feib.so",
               "This is not a library, but longer than the header of one would be.\n");
  folder.write("empty.feib.so", "");
  const std::string output = listed(folder.path.string());
  EXPECT_EQ(reason(output, folder.path.string(), "text"), "is not a shared library");
  EXPECT_EQ(reason(output, folder.path.string(), "empty"), "is not a shared library");
}

TEST(BadPlugins, Truncated)
{
  const std::string whole = read_file(FEIB_BAD_PLUGINS "/a_good.feib.so");
  const TemporaryFolder folder;
  for (const std::size_t size :
       {std::size_t(100), whole.size() / 4, whole.size() / 2, whole.size() - 1})
    folder.write("head_" + std::to_string(size) + ".feib.so", whole.substr(0, size));
  const std::string output = listed(folder.path.string());
  for (const std::size_t size :
       {std::size_t(100), whole.size() / 4, whole.size() / 2, whole.size() - 1})
    EXPECT_EQ(reason(output, folder.path.string(), "head_" + std::to_string(size)), "is truncated")
      << output;
}

TEST(BadPlugins, GoodOnesBesideThemBuildACase)
{
  const TemporaryFolder folder;
  const std::string file = folder.write("case.json", R"({
    "dimension": 2,
    "domain": { "cells": [2, 2] },
    "fluid": { "navier_stokes": { "density": 1, "viscosity": 1 } },
    "time": { "step": 0.1, "end": 0.1 } })");
  const RunResult result = run_host("--validate --plugin-path " + shell_quoted(FEIB_BAD_PLUGINS) +
                                    " " + shell_quoted(file));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.output.rfind(file + " is valid\n", 0), 0U) << result.output;
}
