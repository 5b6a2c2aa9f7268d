// SPDX-License-Identifier: LGPL-2.1-or-later
// feib-host --new-plugin, and the templates it copies.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <set>

using namespace feib::testing;
namespace fs = std::filesystem;

namespace
{
  /// The folders of plugins/template with the names of the plugins in them.
  std::map<std::string, std::string>
  templates()
  {
    std::map<std::string, std::string> result;
    for (const auto &folder : fs::directory_iterator(FEIB_SOURCE "/plugins/template"))
      for (const auto &file : fs::directory_iterator(folder))
        if (const std::string name = file.path().filename().string();
            name.find(".schema.json") != std::string::npos)
          result[folder.path().filename().string()] = name.substr(0, name.find('.'));
    return result;
  }


  class NewPlugin : public ::testing::Test
  {
  protected:
    RunResult
    host(const std::string &arguments, const unsigned int ranks = 1)
    {
      return run_host(arguments, ranks, folder.path.string());
    }

    /// Ends with one sentence and leaves nothing behind.
    void
    refused(const std::string &arguments, const std::string &sentence)
    {
      const RunResult result = host(arguments);
      EXPECT_EQ(result.exit_code, 2) << arguments;
      EXPECT_EQ(result.output, "error: " + sentence + "\n");
      EXPECT_TRUE(fs::is_empty(folder.path)) << arguments;
    }

    TemporaryFolder folder;
  };
} // namespace


TEST_F(NewPlugin, HasNothingOfTheTemplateButItsText)
{
  ASSERT_GE(templates().size(), 8u);
  for (const auto &[kind, old] : templates())
    {
      SCOPED_TRACE(kind);
      const std::string option    = kind == "constitutive_law.energy_only"  ? " --energy-only"
                                    : kind == "constitutive_law.with_state" ? " --with-state"
                                                                            : "";
      const std::string name      = "Soft_" + kind.substr(0, kind.find('.')) + "2",
                        directory = "in/" + kind;
      const RunResult result = host("--new-plugin " + kind.substr(0, kind.find('.')) + " " + name +
                                    option + " --dir " + directory);
      ASSERT_EQ(result.exit_code, 0) << result.output;
      std::set<std::string> files;
      for (const auto &file : fs::directory_iterator(folder / directory))
        {
          files.insert(file.path().filename().string());
          const std::string text = read_file(file.path().string());
          EXPECT_TRUE(holds(text, name)) << file.path();
          EXPECT_FALSE(holds(text, old)) << file.path();
          EXPECT_TRUE(
            holds(result.output, "\n  " + directory + "/" + file.path().filename().string() + "\n"))
            << result.output;
        }
      EXPECT_EQ(files,
                (std::set<std::string>{"CMakeLists.txt",
                                       "README.md",
                                       "case.json",
                                       name + ".cc",
                                       name + ".schema.json",
                                       name + "_test.cc"}));
    }
  EXPECT_TRUE(holds(read_file(folder / "in/output_writer/Soft_output_writer2.cc"),
                    "class SoftOutputWriter2 : public"));
}


TEST_F(NewPlugin, IsWrittenIntoAFolderOfItsNameByOneRank)
{
  const RunResult result = host("--new-plugin constitutive_law rubber", 2);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "rubber/rubber.cc"));
  EXPECT_TRUE(holds(result.output, "\n  cmake -S rubber -B rubber/build "));
  EXPECT_TRUE(holds(result.output, " rubber/case.json --plugin-path rubber/build/plugins\n"));
}


TEST_F(NewPlugin, WhatWillNotDo)
{
  refused("--new-plugin law rubber",
          "there is no template of a plugin of the kind \"law\"; the kinds are constitutive_law, "
          "coupling_operator, output_writer, refinement_strategy, structure_force, "
          "time_integrator");
  refused("--new-plugin constitutive_law.energy_only rubber",
          "there is no template of a plugin of the kind \"constitutive_law.energy_only\"; the "
          "kinds are constitutive_law, coupling_operator, output_writer, refinement_strategy, "
          "structure_force, time_integrator");
  for (const std::string name : {"my-law", "2law", "lös"})
    refused("--new-plugin constitutive_law " + name,
            "the name \"" + name +
              "\" will not do: a name begins with a letter and holds letters, digits and _");
  refused("--new-plugin constitutive_law test",
          "the name \"test\" will not do: CMake has a target of this name");
  const RunResult known = host("--new-plugin constitutive_law neo_hookean");
  EXPECT_EQ(known.exit_code, 2);
  EXPECT_TRUE(
    holds(known.output, "error: the constitutive_law \"neo_hookean\" exists already, from "))
    << known.output;
  refused("--new-plugin constitutive_law",
          "--new-plugin takes a kind and a name; write --new-plugin constitutive_law my_law");
  refused("--new-plugin output_writer rubber --energy-only",
          "--energy-only and --with-state go with --new-plugin constitutive_law NAME");
  refused("--new-plugin constitutive_law rubber --energy-only --with-state",
          "--energy-only and --with-state are two templates; choose one");
  refused("case.json --dir there",
          "--energy-only, --with-state and --dir go with --new-plugin KIND NAME");
  refused("--new-plugin output_writer rubber --validate",
          "--new-plugin runs no case: --validate does not go with it");

  fs::create_directory(folder / "rubber");
  const RunResult there = host("--new-plugin constitutive_law rubber");
  EXPECT_EQ(there.exit_code, 2);
  EXPECT_EQ(there.output,
            "error: the folder rubber exists already; choose another with --dir, or another "
            "name\n");
  EXPECT_TRUE(fs::is_empty(folder / "rubber"));
}


TEST_F(NewPlugin, CasesOfTheTemplatesAreValid)
{
  for (const auto &[kind, name] : templates())
    {
      const RunResult result =
        host("--validate " + shell_quoted(FEIB_SOURCE "/plugins/template/" + kind + "/case.json") +
             " --plugin-path " + shell_quoted(FEIB_TEMPLATE_PLUGINS));
      EXPECT_EQ(result.exit_code, 0) << result.output;
    }
}
