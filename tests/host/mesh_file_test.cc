// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/run_host.h"

#include <gtest/gtest.h>

using namespace feib::testing;
namespace fs = std::filesystem;

namespace
{
  /// Two triangles side by side, which do not share the nodes between them.
  const char *const halves = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
6
1 0.25 0.25 0
2 0.75 0.25 0
3 0.75 0.75 0
4 0.25 0.25 0
5 0.75 0.75 0
6 0.25 0.75 0
$EndNodes
$Elements
2
7 2 2 0 1 1 2 3
8 2 2 0 1 4 5 6
$EndElements
)";

  const char *const a_case = R"({
  "dimension": 2,
  "domain": { "cells": [2, 2] },
  "fluid": { "navier_stokes": { "density": 1, "viscosity": 1 } },
  "structures": [ { "hyperelastic": { "name": "body",
    "mesh": { "gmsh": { "file": "body.msh" } },
    "law": { "neo_hookean": { "shear_modulus": 1 } } } } ],
  "time": { "step": 0.01, "end": 0.01 }
}
)";

  class MeshFile : public ::testing::Test
  {
  protected:
    MeshFile()
    {
      folder.write("case.json", a_case);
      folder.write("body.msh", halves);
    }

    /// The mesh is refused, and nothing is written.
    void
    refused(const std::string &sentence)
    {
      const RunResult result = run_host("case.json --output out", 1, folder.path.string());
      EXPECT_EQ(result.exit_code, 2);
      EXPECT_EQ(result.output, sentence);
      EXPECT_FALSE(fs::exists(folder / "out"));
    }

    std::string
    changed(const std::string &what, const std::string &with) const
    {
      std::string text = halves;
      return text.replace(text.find(what), what.size(), with);
    }

    /// Runs feib-host on two ranks, each in a folder and with arguments of its own.
    static RunResult
    run_two(const std::string &folder,
            const std::string &arguments,
            const std::string &other_folder,
            const std::string &other_arguments)
    {
      // One program, as mpiexec of Open MPI 5.0.7 does not survive two.
      const std::string host = shell_quoted(FEIB_HOST);
      std::string command    = host_command();
      command.resize(command.size() - host.size());
      const std::string script = "if [ \"$OMPI_COMM_WORLD_RANK\" = 0 ]; then cd " +
                                 shell_quoted(folder) + " && exec " + host + " " + arguments +
                                 "; else cd " + shell_quoted(other_folder) + " && exec " + host +
                                 " " + other_arguments + "; fi";
      return run_command(command + FEIB_MPIEXEC + " --oversubscribe -np 2 sh -c " +
                         shell_quoted(script));
    }

    TemporaryFolder folder;
  };
} // namespace

TEST_F(MeshFile, WhatIsWrongHasItsPlaceInBothFiles)
{
  const std::string place =
    "case.json:6:33: error: /structures/0/hyperelastic/mesh/gmsh/file: file \"./body.msh\"";
  folder.write("body.msh", changed("8 2 2 0 1 4 5 6", "8 2 2 0 1 4 5 9"));
  const std::string sentence = place + ", line 16: element 8 has node 9, which does not exist\n";
  refused(sentence);
  EXPECT_EQ(run_host("case.json --validate", 1, folder.path.string()).output, sentence);
  folder.write("body.msh", changed("8 2 2 0 1 4 5 6", "8 2 2 0 1 1 3 2"));
  refused(place + ": element 8 repeats element 7: it has the same nodes\n");
  folder.write("body.msh", changed("6 0.25 0.75 0", "6 0.70 0.75 0.5"));
  refused(place + ": has nodes outside the plane z = 0, where a structure in dimension 2 must "
                  "lie, as node 6 in line 11 with z = 0.5\n");
  fs::remove(folder / "body.msh");
  refused(place + ": there is no such file\n");
}

// Numbers of nodes and elements are those of the file in what is said about places, too.
TEST_F(MeshFile, NumbersAreThoseOfTheFile)
{
  const std::string structure = "/structures/0/hyperelastic/";
  const auto error            = [&](const std::string &map) {
    const RunResult result =
      run_host("case.json --output out --set '" + structure + "initial_position=" + map + "'",
               1,
               folder.path.string());
    EXPECT_EQ(result.exit_code, 2);
    return result.output;
  };
  const auto contains = [](const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
  };
  std::string message = error(R"(["s1", "s2 > 0.7 && s1 < 0.3 ? 2 : s2"])");
  EXPECT_TRUE(contains(message, "node 6 starts at (0.25 2)")) << message;
  message = error(R"(["s2 > 0.7 ? 0.75 : s1", "s2 > 0.7 && s1 < 0.3 ? 0.3 : s2"])");
  EXPECT_TRUE(contains(message, "/initial_position: folds the body: 1 of its 2 elements"))
    << message;
  EXPECT_TRUE(contains(message, "as element 8 at the reference place (")) << message;
}

// However fine the fluid's cells are: 2 triangles whose longest edge is 0.707.
TEST_F(MeshFile, ElementsAreSplitToARatioOfTheCells)
{
  const auto elements = [&](const std::string &more) {
    const RunResult result = run_host(
      "case.json --validate --set '/structures/0/hyperelastic/mesh={\"refined\": {\"mesh\": "
      "{\"gmsh\": {\"file\": \"body.msh\", \"merge\": true}}, \"longest_edge\": 0.75, "
      "\"unit\": \"cells\"}}'" +
        more,
      1,
      folder.path.string());
    EXPECT_EQ(result.exit_code, 0) << result.output;
    const std::string words = " nodes, ";
    return std::stoi(result.output.substr(result.output.find(words) + words.size()));
  };
  EXPECT_EQ(elements(""), 2 * 4); // 0.75 of 1/2
  EXPECT_EQ(elements(" --set '/refinement={\"immersed_cells\": {\"level\": 1}}'"), 2 * 16);
  EXPECT_EQ(elements(" --set /domain/cells=[2,16]"), 2 * 256); // the shortest edge
}

TEST_F(MeshFile, NodesAtOnePlaceAreAWarningUntilMerged)
{
  const std::string sentence =
    "the structure \"body\": 2 of its nodes lie where others do, as nodes 1 and 4, and are not "
    "joined: they move apart. The mesh has 2 parts; \"merge\": true";
  RunResult result = run_host("case.json --output out", 1, folder.path.string());
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.output.find("warning: " + sentence), std::string::npos) << result.output;
  EXPECT_NE(read_file(folder / "out/log.txt").find(sentence), std::string::npos);
  const auto warning = read_json(folder / "out/summary.json")["warnings"][0];
  EXPECT_EQ(warning["kind"], "unmerged_nodes");
  EXPECT_EQ(warning["worst"], 2);
  EXPECT_EQ(warning["count"], 1);
  EXPECT_NE(run_host("case.json --validate", 1, folder.path.string()).output.find(sentence),
            std::string::npos);

  result = run_host("case.json --output out --overwrite --set "
                    "/structures/0/hyperelastic/mesh/gmsh/merge=true",
                    1,
                    folder.path.string());
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.output.find("unmerged_nodes"), std::string::npos) << result.output;
}

// The other rank's folder is empty: it can read neither the case nor the mesh.
TEST_F(MeshFile, OneRankReadsForAll)
{
  const TemporaryFolder empty;
  const std::string arguments = "case.json --output " + shell_quoted(folder / "out");
  RunResult result = run_two(folder.path.string(), arguments, empty.path.string(), arguments);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(fs::exists(folder / "out/summary.json"));

  fs::remove_all(folder / "out");
  fs::remove(folder / "body.msh");
  empty.write("body.msh", halves);
  result = run_two(folder.path.string(), arguments, empty.path.string(), arguments);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.output.find("there is no such file"), std::string::npos) << result.output;
}

// A rank that cannot read a folder of plugins ends the others, too.
TEST_F(MeshFile, AllRanksHaveTheSamePlugins)
{
  const std::string here = folder.path.string();
  for (const bool first : {true, false})
    {
      const std::string there = "case.json --validate", nowhere = there + " --plugin-path nowhere";
      const RunResult result =
        run_two(here, first ? nowhere : there, here, first ? there : nowhere);
      EXPECT_EQ(result.exit_code, 2);
      EXPECT_NE(result.output.find("the plugin folder nowhere cannot be read"), std::string::npos)
        << result.output;
    }
}
