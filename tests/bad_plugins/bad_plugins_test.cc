// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/run_host.h"

#include <feib/plugin.h>

#include <gtest/gtest.h>

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
