// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components.h"

#include <feib/case.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace feib;
using namespace feib::testing;
using Json = nlohmann::json;

namespace
{
  const Registry &
  registry()
  {
    static const Registry registry = small_registry();
    return registry;
  }

  /// What a user reads about a text.
  std::string
  problems(const std::string &text, const Case::Settings &settings = {})
  {
    try
      {
        const Case description(text, "folder/case.json", registry(), settings);
        return "";
      }
    catch (const Error &error)
      {
        return Case::format(error.issues(), text, "folder/case.json", settings);
      }
  }

  std::string
  replaced(const std::string &what, const std::string &with)
  {
    std::string text        = small_case;
    const std::size_t place = text.find(what);
    if (place == std::string::npos)
      throw std::logic_error("the case does not hold " + what);
    return text.replace(place, what.size(), with);
  }
} // namespace

TEST(Case, KnowsItsParametersAndItsResolvedText)
{
  const Case description(small_case, "folder/case.json", registry());
  const Parameters &p = description.parameters();
  EXPECT_EQ(p.integer("dimension"), 2);
  EXPECT_EQ(p.pointer(), "");
  EXPECT_EQ(p.directory(), "folder");
  const auto [name, block] = p.child("fluid").choice();
  EXPECT_EQ(name, "stokes");
  EXPECT_EQ(block.pointer(), "/fluid/stokes");
  EXPECT_EQ(block.number("density"), 1);
  EXPECT_EQ(p.children("output").size(), 2u);

  const Case again(description.resolved(), "case.json", registry());
  EXPECT_EQ(again.resolved(), description.resolved());
  EXPECT_EQ(again.parameters().directory(), ".");
}

TEST(Case, AllowsComments)
{
  EXPECT_EQ(problems(replaced("\"dimension\": 2,",
                              "// a \"comment\" {\n /* and [ one */ \"dimension\": /* 3 */ 2,")),
            "");
}

TEST(Case, PlainJsonKeepsTheOrderOfKeys)
{
  EXPECT_EQ(Case::plain("{ \"b\": 1, // first\n \"a\": [0.10] }"), "{\"b\":1,\"a\":[0.1]}");
  EXPECT_THROW(Case::plain("{ \"a\": 1, \"a\": 1 }"), Error);
  EXPECT_THROW(Case::plain("{"), Error);
}

TEST(Case, PlacesOfIssues)
{
  EXPECT_EQ(
    problems(replaced("1.0 } }", "-1 } }")),
    "folder/case.json:4:39: error: /fluid/stokes/viscosity: must be greater than 0, found -1\n");
  // Comments, escapes and letters of several bytes do not move the place.
  EXPECT_EQ(problems(
              replaced("\"dimension\": 2",
                       "// { \" \n\"title\": \"\\\"\xC3\xA4}\", /* } \n */ \"dimension\": 5")),
            "folder/case.json:4:18: error: /dimension: must be one of 2, 3, found 5\n");
  EXPECT_EQ(problems(replaced("[4, 4]", "[4, 4, \n 0]")),
            "folder/case.json:4:2: error: /domain/cells/2: must be at least 1, found 0\n");
  // What is missing is placed at what should hold it.
  EXPECT_EQ(problems(replaced("\"step\": 0.1, ", "")),
            "folder/case.json:5:11: error: /time: the required key \"step\" is missing\n");
  EXPECT_EQ(problems("{}").substr(0, 31), "folder/case.json:1:1: error: th");
  EXPECT_EQ(
    problems(replaced("\"step\"", "\"a/b~c\": 1, \"step\"")),
    "folder/case.json:5:22: error: /time/a~1b~0c: unknown key \"a/b~c\"; allowed are "
    "\"step\", \"end\", \"control\", \"energy_growth\", \"measure_tolerance\", \"integrator\"\n");
}

TEST(Case, SyntaxErrors)
{
  EXPECT_EQ(problems("{\n  \"dimension\": 2\n  \"domain\": {} }").substr(0, 37),
            "folder/case.json:3:10: error: syntax ");
  EXPECT_EQ(problems("").substr(0, 30), "folder/case.json:1:1: error: s");
  EXPECT_NE(problems("{ \"a\": 1e999 }"), "");
  EXPECT_NE(problems("{ \"a\": \"\xFF\" }"), "");
  EXPECT_NE(problems("{ /* "), "");
  EXPECT_NE(problems("[1"), "");
}

TEST(Case, RefusesDuplicateKeys)
{
  EXPECT_EQ(
    problems(replaced("\"step\": 0.1,", "\"step\": 0.1, \"st\\u0065p\": 0.2,")),
    "folder/case.json:5:26: error: /time/step: the key \"step\" stands here a second time\n");
}

TEST(Case, ReportsEverythingAtOnce)
{
  const std::string text =
    problems(replaced("\"step\": 0.1, \"end\": 1.0", "\"step\": \"a\", \"edn\": 1.0"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3) << text;
}

TEST(Case, Settings)
{
  const Case description(small_case,
                         "case.json",
                         registry(),
                         {{"/time/end", "2.5"},
                          {"/title", "a title"},
                          {"/domain/cells/1", "8"},
                          {"/structures", R"([{"body": {"law": {"spring": {"c": 1}}}}])"}});
  const Parameters &p = description.parameters();
  EXPECT_EQ(p.child("time").number("end"), 2.5);
  EXPECT_EQ(p.string("title"), "a title");
  EXPECT_EQ(p.child("domain").integers("cells"), (std::vector<int>{4, 8}));
  EXPECT_EQ(p.children("structures").size(), 1u);

  EXPECT_EQ(problems(small_case, {{"/time/end", "-1"}}),
            "--set /time/end: error: /time/end: must be greater than 0, found -1\n");
  EXPECT_EQ(problems(small_case, {{"/fluid", R"({"stokes": {"viscosity": 0}})"}}),
            "--set /fluid: error: /fluid/stokes/viscosity: must be greater than 0, found 0\n");
  EXPECT_EQ(problems(small_case, {{"time/end", "1"}}).substr(0, 23), "--set time/end: error: ");
  EXPECT_EQ(
    problems(small_case, {{"/tme/end", "1"}}),
    "--set /tme/end: error: /tme/end: the case has no /tme; set that, with all it holds as JSON\n");
  EXPECT_EQ(
    problems(small_case, {{"/domain/cells/2", "1"}}),
    "--set /domain/cells/2: error: /domain/cells/2: /domain/cells has 2 entries, no \"2\"\n");
  EXPECT_NE(problems(small_case, {{"/dimension/x", "1"}}), "");
  EXPECT_NE(problems(small_case, {{"/title", "\xFF"}}), "");
}

TEST(Case, ADefaultMayNeedAPluginThatIsNotThere)
{
  Registry few;
  few.add<fluid_solver_interface, fluid_solver_component>("stokes", stokes_schema);
  try
    {
      const Case description(small_case, "case.json", few);
      FAIL();
    }
  catch (const Error &error)
    {
      const std::string text = Case::format(error.issues(), small_case, "case.json");
      EXPECT_NE(text.find("case.json:1:1: error: /coupling/divergence_free: no plugin provides the "
                          "coupling_operator \"divergence_free\""),
                std::string::npos)
        << text;
    }
}

TEST(Case, Constants)
{
  const Case description(small_case, "case.json", registry(), {{"/constants", R"({"mu": 2})"}});
  const auto constants = description.parameters().child("fluid").constants();
  EXPECT_EQ(constants.size(), 3u);
  EXPECT_EQ(constants.at("mu"), 2);
  EXPECT_DOUBLE_EQ(constants.at("pi"), M_PI);
  EXPECT_DOUBLE_EQ(constants.at("e"), M_E);
  for (const std::string name : {"x", "t", "s1", "sin", "if", "pi", "1a", "a b", ""})
    {
      const std::string text = problems(small_case, {{"/constants", Json{{name, 1}}.dump()}});
      EXPECT_EQ(text.substr(0, 36 + name.size()), "--set /constants: error: /constants/" + name)
        << name;
    }
}

TEST(Case, FilesThatCannotBeRead)
{
  EXPECT_THROW(Case::read("no/such/case.json"), Error);
  EXPECT_THROW(Case::read("/"), Error);
}
