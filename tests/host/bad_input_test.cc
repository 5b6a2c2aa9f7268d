// SPDX-License-Identifier: LGPL-2.1-or-later
#include "small_case.h"
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace feib::testing;
namespace fs = std::filesystem;

namespace
{
  /// Bad input gets a sentence with its place, exit code 2 and no folder.
  class BadInput : public ::testing::Test
  {
  protected:
    /// The small case with one part replaced.
    static std::string
    changed(const std::string &what, const std::string &with)
    {
      std::string text        = small_case;
      const std::size_t place = text.find(what);
      if (place == std::string::npos)
        throw std::logic_error("the case does not hold " + what);
      return text.replace(place, what.size(), with);
    }

    /// The small case with a structure.
    static std::string
    with_structure(const std::string &structure)
    {
      return changed("\"structures\": []", "\"structures\": [\n" + structure + " ]");
    }

    /// Runs a text; each line of the answer must start with the given text.
    void
    refused(const std::string &text, const std::vector<std::string> &lines)
    {
      folder.write("case.json", text);
      const RunResult result = run_host("case.json --output out", 1, folder.path.string());
      EXPECT_EQ(result.exit_code, 2);
      std::istringstream stream(result.output);
      std::vector<std::string> found;
      for (std::string line; std::getline(stream, line);)
        found.push_back(line);
      ASSERT_EQ(found.size(), lines.size()) << result.output;
      for (std::size_t i = 0; i < lines.size(); ++i)
        EXPECT_EQ(found[i].substr(0, lines[i].size()), lines[i]) << found[i];
      EXPECT_FALSE(fs::exists(folder / "out"));
    }

    TemporaryFolder folder;
  };
} // namespace

TEST_F(BadInput, SyntaxError)
{
  refused(changed("[2, 2] },", "[2, 2] }"),
          {"case.json:4:9: error: syntax error while parsing object - unexpected string literal"});
}

TEST_F(BadInput, DuplicateKey)
{
  refused(changed("\"step\": 0.1,", "\"step\": 0.1, \"step\": 0.2,"),
          {"case.json:6:26: error: /time/step: the key \"step\" stands here a second time"});
}

TEST_F(BadInput, UnknownKey)
{
  refused(
    changed("\"density\": 1,", "\"density\": 1, \"viscosty\": 1,"),
    {"case.json:4:59: error: /fluid/navier_stokes/viscosty: unknown key \"viscosty\"; did you mean "
     "\"viscosity\"?"});
}

TEST_F(BadInput, WrongType)
{
  refused(
    changed("\"density\": 1", "\"density\": \"heavy\""),
    {"case.json:4:44: error: /fluid/navier_stokes/density: must be a number, found the string "
     "\"heavy\""});
}

TEST_F(BadInput, OutOfRange)
{
  refused(
    changed("\"density\": 1", "\"density\": -1"),
    {"case.json:4:44: error: /fluid/navier_stokes/density: must be greater than 0, found -1"});
}

TEST_F(BadInput, UnknownComponent)
{
  refused(
    changed("\"structures\"", "\"coupling\": { \"magic\": {} }, \"structures\""),
    {"case.json:5:26: error: /coupling/magic: no plugin provides the coupling_operator \"magic\"; "
     "available are \"divergence_free\", \"regularised_delta\", \"variational\""});
}

TEST_F(BadInput, SeveralAtOnce)
{
  refused(
    changed("\"density\": 1, \"viscosity\": 1",
            "\"density\": 0, \"viscosity\": \"thick\", \"a_key\": 1"),
    {"case.json:4:44: error: /fluid/navier_stokes/density: must be greater than 0, found 0",
     "case.json:4:60: error: /fluid/navier_stokes/viscosity: must be a number",
     "case.json:4:78: error: /fluid/navier_stokes/a_key: unknown key \"a_key\"; allowed are"});
}

TEST_F(BadInput, Setting)
{
  folder.write("case.json", small_case);
  const RunResult result =
    run_host("case.json --output out --set /time/step=fast", 1, folder.path.string());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.output,
            "--set /time/step: error: /time/step: must be a number, found the string \"fast\"\n");
}

TEST_F(BadInput, NestedTooDeep)
{
  const auto nested = [](const std::string &open, const std::string &close, const int n) {
    std::string text = "{\"x\": ";
    for (int i = 0; i < n; ++i)
      text += open;
    for (int i = 0; i < n; ++i)
      text += close;
    return text + "}";
  };
  const std::string sentence = ": error: objects and arrays are nested more than 100 deep";
  refused(nested("[", "]", 50000), {"case.json:1:106" + sentence});
  refused(nested("[", "", 50000), {"case.json:1:106" + sentence});
  refused(nested("{\"a\":", "}", 50000), {"case.json:1:502" + sentence});
  refused(nested("[ /* ] \" */ \"]\", ", "", 1000), {"case.json:1:"});
  // Brackets in texts and comments nest nothing.
  refused("{\"x\": \"" + std::string(1000, '[') + "\\\"[\" } // " + std::string(1000, '['),
          {"case.json:1:1: error: the required key",
           "case.json:1:1: error: the required key",
           "case.json:1:1: error: the required key",
           "case.json:1:1: error: the required key",
           "case.json:1:7: error: /x: unknown key"});

  folder.write("case.json", small_case);
  const RunResult result =
    run_host("case.json --output out --set /constants=$(printf '[%.0s' $(seq 50000))",
             1,
             folder.path.string());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.output.substr(0, 50), "--set /constants: error: /constants: objects and a");
}

TEST_F(BadInput, NumbersBeyondNumbers)
{
  const std::string density = "case.json:4:44: error: ", field = "/fluid/navier_stokes/density: ";
  refused(changed("\"density\": 1", "\"density\": 1e400"),
          {density + "the number 1e400 is too large; the largest is 1.8e308"});
  refused(changed("\"density\": 1", "\"density\": -1e999 // 1e400"),
          {density + "the number -1e999 is too large"});
  refused(changed("\"density\": 1", "\"density\": -9223372036854775809"),
          {density + field + "must be greater than 0, found -9.2"});
  for (const std::string number : {"9223372036854775808", "18446744073709551615", "4294967296"})
    refused(changed("[2, 2]", "[" + number + ", 2]"),
            {"case.json:3:25: error: /domain/cells/0: must be an integer from -2147483648 to "
             "2147483647, found " +
             number});
  refused(changed("[2, 2]", "[18446744073709551616, 2]"),
          {"case.json:3:25: error: /domain/cells/0: must be an integer from -2147483648 to "
           "2147483647, found 1.8"});
}

TEST_F(BadInput, WholeNumbersAreIntegersHoweverWritten)
{
  refused(changed("[2, 2]", "[2.5, 2]"),
          {"case.json:3:25: error: /domain/cells/0: must be an integer, found the number 2.5"});
  folder.write("case.json", changed("[2, 2]", "[2.0, 2e0]"));
  const RunResult result = run_host("--validate case.json", 1, folder.path.string());
  EXPECT_EQ(result.exit_code, 0) << result.output;
}

TEST_F(BadInput, BoxesBeyondArithmetic)
{
  const std::vector<std::pair<std::string, std::string>> boxes = {
    {"[1, 1e-308]", "upper: the box reaches from 0 to 1e-308 in y; coordinates may be"},
    {"[1e308, 1]", "upper: the box reaches from 0 to 1e+308 in x; coordinates may be"},
    {"[1e308, 1e308]", "upper: the box reaches from 0 to 1e+308 in x; coordinates may be"},
    {"[1e200, 1e200]", "upper: the box reaches from 0 to 1e+200 in x; coordinates may be"},
    {"[1, 1e-30]", "cells: the cells are from 2.5e-31 to 0.25 long; at most 1e+06 times"},
    {"[1, 1], \"lower\": [-1e308, -1e308]", "upper: the box reaches from -1e+308 to 1 in x"},
    {"[1e15, 1], \"lower\": [999999999999999, 0]", "cells: the cells are 0.25 long, and"}};
  for (const auto &[upper, sentence] : boxes)
    {
      folder.write("case.json", changed("[2, 2]", "[4, 4], \"upper\": " + upper));
      const RunResult result = run_host("case.json --output out", 1, folder.path.string());
      EXPECT_EQ(result.exit_code, 2);
      EXPECT_NE(result.output.find("error: /domain/" + sentence), std::string::npos)
        << result.output;
      EXPECT_FALSE(fs::exists(folder / "out"));
    }
}

TEST_F(BadInput, NumbersInSmallUnitsAreReadable)
{
  refused(changed("[2, 2]", "[2, 2], \"lower\": [4e-7, 0], \"upper\": [3e-7, 1e-6]"),
          {"case.json:3:61: error: /domain/upper: the box is empty in x: from 4e-07 to 3e-07; "});
  refused(with_structure(R"({ "hyperelastic": { "name": "a", "mesh": { "rectangle": {
    "lower": [4e-7, 4e-7], "upper": [3e-7, 5e-7], "cells": [2, 2] } },
    "law": { "neo_hookean": { "shear_modulus": 1 } } } })"),
          {"case.json:7:37: error: /structures/0/hyperelastic/mesh/rectangle/upper: must be "
           "greater than \"lower\" in every direction, found 3e-07 and 4e-07"});
}

TEST_F(BadInput, NothingRawFromOutside)
{
  const auto only_text = [](const std::string &output) {
    return std::all_of(output.begin(), output.end(), [](const unsigned char c) {
      return c == '\n' || (c >= 0x20 && c < 0x7F);
    });
  };
  const auto said = [&](const std::string &text, const std::string &options, const char *part) {
    folder.write("case.json", text);
    const RunResult result = run_host("case.json --output out " + options, 1, folder.path.string());
    EXPECT_EQ(result.exit_code, 2) << result.output;
    EXPECT_TRUE(only_text(result.output)) << result.output;
    EXPECT_NE(result.output.find(part), std::string::npos) << result.output;
    EXPECT_LT(result.output.size(), 4000u);
  };
  said(changed("\"density\"", "\"\\u001b[2Jx\\n\\u202e\": 1, \"density\""),
       "",
       "unknown key \"\\u001b[2Jx\\u000a\\u202e\"");
  said(changed("\"density\": 1", "\"density\": \"\\u009b\\u007f\""), "", "\\u009b\\u007f");
  said(changed("\"density\": 1", "\"density\": \"\x1b[2J\""), "", "syntax error");
  said(changed("\"density\": 1", "\"density\": \"\xff\""), "", "syntax error");
  said(small_case, "--set $(printf '/time/\\033[2J')=1", "unknown key \"\\u001b[2J\"");
  said(small_case, "--set $(printf '/time/\\377')=1", "must be UTF-8 text");
  said(small_case, "--set /time/step=$(printf '\\033[2J')", "\\u001b[2J");
  said(small_case, "--set /$(printf 'a%.0s' $(seq 50000))=1", "aaaa...");
  said(changed("\"density\": 1", "\"density\": \"" + std::string(1000000, 'a') + "\""),
       "",
       "aaaa...");
  said(changed("\"density\"", "\"" + std::string(1000000, 'a') + "\": 1, \"density\""),
       "",
       "aaaa...");
}

TEST_F(BadInput, GmshFileMissing)
{
  refused(with_structure(
            R"({ "hyperelastic": { "name": "a", "mesh": { "gmsh": { "file": "none.msh" } },
  "law": { "neo_hookean": { "shear_modulus": 1 } } } })"),
          {"case.json:6:62: error: /structures/0/hyperelastic/mesh/gmsh/file: "});
}

TEST_F(BadInput, GmshFileOfTheWrongDimension)
{
  folder.write(
    "segments.msh",
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0.4 0.5 0\n2 0.6 0.5 0\n$EndNodes\n"
    "$Elements\n1\n1 1 2 1 1 1 2\n$EndElements\n");
  refused(with_structure(
            R"({ "hyperelastic": { "name": "a", "mesh": { "gmsh": { "file": "segments.msh" } },
  "law": { "neo_hookean": { "shear_modulus": 1 } } } })"),
          {"case.json:6:62: error: /structures/0/hyperelastic/mesh/gmsh/file: "});
}

TEST_F(BadInput, StructureOutsideTheBox)
{
  refused(
    with_structure(
      R"({ "hyperelastic": { "name": "a", "mesh": { "disc": { "centre": [0.9, 0.5], "radius": 0.2, "rings": 2 } },
  "law": { "neo_hookean": { "shear_modulus": 1 } } } })"),
    {"case.json:6:42: error: /structures/0/hyperelastic/mesh: the structure \"a\" is not inside "
     "the box"});
}

TEST_F(BadInput, SizesThatNoMachineHolds)
{
  refused(changed("\"step\": 0.1", "\"step\": 1e-300"),
          {"case.json:6:21: error: /time/step: the end is "});
  refused(changed("[2, 2]", "[100000, 100000]"),
          {"case.json:3:24: error: /domain/cells: found 1e+10 cells in all, at most 1e8 "
           "are allowed"});
}

TEST_F(BadInput, NamesOfStructuresThatClash)
{
  const std::string disc =
    R"("mesh": { "disc": { "centre": [0.5, 0.5], "radius": 0.2, "rings": 2 } },
  "law": { "neo_hookean": { "shear_modulus": 1 } } } })";
  refused(with_structure(R"({ "hyperelastic": { "name": "fluid", )" + disc),
          {"case.json:6:29: error: /structures/0/hyperelastic/name: found \"fluid\", the name of "
           "the fluid's own files"});
  refused(with_structure(R"({ "hyperelastic": { "name": "a", )" + disc + ",\n" +
                         R"({ "hyperelastic": { "name": "a", )" + disc),
          {"case.json:8:29: error: /structures/1/hyperelastic/name: found \"a\" a second time"});
}

TEST_F(BadInput, TwoOutputsOfOneName)
{
  const std::string probe =
    R"({ "probe": { "name": "a", "at": { "points": { "places": [[0, 0]] } } } })";
  refused(changed("\"structures\": []", "\"output\": [" + probe + ",\n" + probe + "]"),
          {"case.json:6:22: error: /output/1/probe/name: found \"a\" a second time; every probe "
           "needs a name of its own"});
}

TEST_F(BadInput, InvertedElements)
{
  refused(
    with_structure(
      R"({ "hyperelastic": { "name": "a", "mesh": { "disc": { "centre": [0.5, 0.5], "radius": 0.2, "rings": 2 } },
  "initial_position": ["1 - s1", "s2"],
  "law": { "neo_hookean": { "shear_modulus": 1, "stress_free": true } } } })"),
    {"case.json:7:23: error: /structures/0/hyperelastic/initial_position: inverts element"});
}

TEST_F(BadInput, ExpressionThatDoesNotParse)
{
  refused(changed("\"viscosity\": 1", "\"viscosity\": 1, \"body_force\": [0, \"sin(x) * height\"]"),
          {"case.json:4:81: error: /fluid/navier_stokes/body_force/1: the expression \"sin(x) * "
           "height\" cannot "
           "be read: "});
}

TEST_F(BadInput, ExpressionsThatAreTooFew)
{
  refused(changed("[2, 2] }", "[2, 2, 2] }"), {"case.json:3:24: error: /domain/cells: "});
}
