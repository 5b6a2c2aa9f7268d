// SPDX-License-Identifier: LGPL-2.1-or-later
// What Feib makes of schemas and documents is what other validators make of them.
#include "support/run_host.h"

#include <feib/case.h>
#include <feib/schema.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <set>

using namespace feib;
using namespace feib::testing;
namespace fs = std::filesystem;
using Json   = nlohmann::json;

namespace
{
  /// The cases of the tree: cases/*, templates, and whole cases in the documentation.
  std::vector<Json>
  good_cases()
  {
    std::vector<Json> result;
    for (const char *const folder : {"cases", "plugins/template"})
      for (const auto &entry : fs::directory_iterator(fs::path(FEIB_SOURCE) / folder))
        result.push_back(Json::parse(Case::plain(read_file(entry.path() / "case.json"))));
    return result;
  }


  /// The JSON pointers of all values of a document.
  void
  add_pointers(const Json &value, const Json::json_pointer &place, std::vector<std::string> &result)
  {
    result.push_back(place.to_string());
    if (value.is_object())
      for (const auto &[key, entry] : value.items())
        add_pointers(entry, place / key, result);
    else if (value.is_array())
      for (std::size_t i = 0; i < value.size(); ++i)
        add_pointers(value[i], place / i, result);
  }


  /// A case with one fault in it, or what may be one.
  std::vector<Json>
  changed(const Json &document)
  {
    const Json things[] = {nullptr,
                           true,
                           -1,
                           0,
                           2.0,
                           2.5,
                           1e300,
                           "",
                           "no such thing",
                           Json::array(),
                           {1, 2, 3, 4},
                           Json::object(),
                           {{"odd", 1}}};
    std::vector<Json> result;
    std::vector<std::string> pointers;
    add_pointers(document, Json::json_pointer(), pointers);
    for (const std::string &text : pointers)
      {
        const Json::json_pointer pointer(text);
        for (const Json &thing : things)
          {
            result.push_back(document);
            result.back()[pointer] = thing;
          }
        if (document[pointer].is_object())
          {
            result.push_back(document);
            result.back()[pointer]["odd"] = 1;
          }
        if (!pointer.empty() && document[pointer.parent_pointer()].is_object())
          {
            result.push_back(document);
            result.back()[pointer.parent_pointer()].erase(pointer.back());
          }
      }
    return result;
  }


  /// Integers that no variable of a component holds are refused by Feib, beyond any schema.
  bool
  beyond_integers(const Json &value)
  {
    if (value.is_number())
      return std::abs(value.get<double>()) > 2147483647.;
    return value.is_structured() && std::any_of(value.begin(), value.end(), [](const Json &part) {
             return beyond_integers(part);
           });
  }
} // namespace


TEST(Validators, PythonJudgesCasesAsWeDo)
{
  const RunResult printed = run_host("--schema");
  ASSERT_EQ(printed.exit_code, 0) << printed.output;
  const Schema schema(printed.output);
  std::vector<Json> documents;
  for (const Json &document : good_cases())
    {
      documents.push_back(document);
      const auto more = changed(document);
      documents.insert(documents.end(), more.begin(), more.end());
    }
  documents.erase(std::remove_if(documents.begin(), documents.end(), beyond_integers),
                  documents.end());
  // Every seventh is enough: 14 changes of each place and the good ones come round.
  std::vector<Json> some;
  for (std::size_t i = 0; i < documents.size(); i += 7)
    some.push_back(documents[i]);
  for (const Json &document : good_cases())
    some.push_back(document);

  const TemporaryFolder folder;
  std::string lines;
  for (const Json &document : some)
    lines += document.dump() + "\n";
  const std::string command = std::string(FEIB_PYTHON3) + " " + shell_quoted(FEIB_JUDGE) + " " +
                              shell_quoted(folder.write("schema.json", printed.output)) + " " +
                              shell_quoted(folder.write("documents", lines));
  const RunResult judged = run_command(command);
  if (judged.exit_code == 77)
    GTEST_SKIP() << "there is no module jsonschema (Debian's python3-jsonschema)";
  ASSERT_EQ(judged.exit_code, 0) << judged.output;
  ASSERT_EQ(judged.output.size(), 2 * some.size()) << judged.output.substr(0, 1000);
  unsigned int n_accepted = 0;
  for (std::size_t i = 0; i < some.size(); ++i)
    {
      const bool accepted    = judged.output[2 * i] == '1';
      const std::string text = some[i].dump();
      const Issues issues    = schema.explain(text);
      n_accepted += accepted;
      EXPECT_EQ(issues.empty(), accepted)
        << text << '\n'
        << (issues.empty() ? "" : issues[0].pointer + ": " + issues[0].message);
      EXPECT_EQ(schema.accepts(text), accepted) << text;
    }
  std::cout << some.size() << " documents, " << n_accepted << " of them accepted\n";
  EXPECT_GT(n_accepted, good_cases().size());
  EXPECT_LT(n_accepted, some.size() / 2);
}


namespace
{
  /// The keywords and types that the schemas of components may have
  /// (schemas/component.schema.json), and what that file itself uses.
  bool
  is_ours(const Json &schema)
  {
    static const Json rules                = Json::parse(Schema::component_rules().text());
    static const Json &keywords            = rules["definitions"]["schema"]["properties"],
                      &types               = rules["definitions"]["type"]["enum"];
    static const std::set<std::string> own = {"$schema", "allOf", "if", "then", "else"};
    if (!schema.is_object())
      return false;
    for (const auto &[key, value] : schema.items())
      {
        if (!keywords.contains(key) && own.count(key) == 0)
          return false;
        if (key == "type")
          for (const Json &type : value.is_array() ? value : Json::array({value}))
            if (std::find(types.begin(), types.end(), type) == types.end())
              return false;
        if (key == "properties" || key == "allOf")
          {
            for (const Json &part : value)
              if (!is_ours(part))
                return false;
          }
        else if ((key == "items" || key == "if" || key == "then" || key == "else" ||
                  (key == "additionalProperties" && !value.is_boolean())) &&
                 !is_ours(value))
          return false;
      }
    return true;
  }


  struct Count
  {
    unsigned int passed = 0, failed = 0, unsupported = 0;
  };
} // namespace


// The part of the standard that schemas of components may use must be right; of the rest the counts
// are printed.
TEST(Validators, OfficialSuite)
{
  const fs::path folder = fs::path(FEIB_SCHEMA_SUITE) / "draft7";
  if (!fs::exists(folder))
    GTEST_SKIP() << "the official suite is not there (Debian's json-schema-test-suite)";
  Count all;
  unsigned int n_ours = 0;
  std::set<fs::path> files;
  for (const auto &entry : fs::directory_iterator(folder))
    if (entry.is_regular_file())
      files.insert(entry.path());
  for (const fs::path &file : files)
    {
      Count count;
      std::string failures;
      for (const Json &group : Json::parse(read_file(file)))
        for (const Json &test : group["tests"])
          {
            const std::string document = test["data"].dump(),
                              name     = file.stem().string() + ": " +
                                     group["description"].get<std::string>() + ": " +
                                     test["description"].get<std::string>();
            const bool valid = test["valid"], ours = is_ours(group["schema"]);
            try
              {
                const Schema schema(group["schema"].dump());
                const bool accepted = schema.accepts(document);
                ++(accepted == valid ? count.passed : count.failed);
                if (accepted != valid)
                  failures += "    " + name + "\n";
                if (!ours)
                  continue;
                ++n_ours;
                EXPECT_EQ(accepted, valid) << name;
                EXPECT_EQ(schema.explain(document).empty(), valid) << name;
              }
            catch (const std::exception &failure)
              {
                ++count.unsupported;
                failures += "    " + name + ": " + failure.what() + "\n";
                EXPECT_FALSE(ours) << name << ": " << failure.what();
              }
          }
      if (!failures.empty())
        std::cout << file.stem().string() << ": " << count.passed << " passed, " << count.failed
                  << " failed, " << count.unsupported << " unsupported\n"
                  << failures;
      all.passed += count.passed;
      all.failed += count.failed;
      all.unsupported += count.unsupported;
    }
  std::cout << "draft 7, required: " << all.passed << " passed, " << all.failed << " failed, "
            << all.unsupported << " unsupported; " << n_ours << " of keywords of components\n";
  EXPECT_EQ(all.failed, 0u);
  EXPECT_GT(n_ours, 100u);
  EXPECT_GT(all.passed, 300u);
}
