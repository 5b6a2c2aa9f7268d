// SPDX-License-Identifier: LGPL-2.1-or-later
// The documentation against the built program: the committed schema, whole cases, options and
// files.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <vector>

namespace
{
  using namespace feib::testing;
  namespace fs = std::filesystem;
  using Json   = nlohmann::json;

  const fs::path source = FEIB_SOURCE;

  /// README.md, CONTRIBUTING.md, docs/*.md and the README of every case and plugin.
  std::vector<fs::path>
  pages()
  {
    std::vector<fs::path> files = {source / "README.md", source / "CONTRIBUTING.md"};
    for (const char *const folder : {"docs", "cases", "plugins"})
      for (const auto &entry : fs::recursive_directory_iterator(source / folder))
        if (entry.path().extension() == ".md")
          files.push_back(entry.path());
    return files;
  }

  /// The first groups of all matches.
  std::vector<std::string>
  matches(const std::string &text, const std::regex &pattern)
  {
    std::vector<std::string> found;
    for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
      found.push_back((*match)[1]);
    return found;
  }

  /// The texts of the code blocks of a language.
  std::vector<std::string>
  blocks(const std::string &text, const std::string &language)
  {
    std::vector<std::string> found;
    const std::string opening = "```" + language + "\n";
    for (std::size_t at = text.find(opening); at != std::string::npos; at = text.find(opening, at))
      {
        at += opening.size();
        const std::size_t end = text.find("```", at);
        found.push_back(text.substr(at, end - at));
        at = end + 3;
      }
    return found;
  }
} // namespace

TEST(Docs, TheCommittedSchemaIsCurrent)
{
  const RunResult schema = run_host("--schema");
  ASSERT_EQ(schema.exit_code, 0) << schema.output;
  EXPECT_TRUE(Json::parse(schema.output) == read_json(source / "schemas/feib-case.schema.json"))
    << "tools/case-format build/bin/feib-host writes it";
}

TEST(Docs, WholeCasesAreValid)
{
  const TemporaryFolder folder;
  unsigned int n = 0;
  for (const fs::path &page : pages())
    for (const std::string &block : blocks(read_file(page), "json"))
      if (block.find("\"dimension\"") != std::string::npos)
        {
          const std::string file = folder.write("case.json", block);
          const RunResult result = run_host("--validate " + shell_quoted(file));
          EXPECT_EQ(result.exit_code, 0) << page << "\n" << result.output;
          ++n;
        }
  EXPECT_GE(n, 2u);
}

TEST(Docs, OptionsOfTheHostExist)
{
  const std::string help = run_host("--help").output;
  // tools/run hands its options on.
  const std::regex command("((?:feib-host|tools/run) [^\\n`]*)");
  const std::regex option("(--[a-z][a-z-]*)");
  std::set<std::string> named;
  for (const fs::path &page : pages())
    for (const std::string &line : matches(read_file(page), command))
      for (const std::string &name : matches(line, option))
        {
          named.insert(name);
          EXPECT_TRUE(std::regex_search(help, std::regex(name + "[ \\n]"))) << page << ": " << line;
        }
  EXPECT_GE(named.size(), 6u);
}

TEST(Docs, LinkedFilesExist)
{
  const std::regex link("\\]\\(([^)#:]+)(?:#[^)]*)?\\)");
  unsigned int n = 0;
  for (const fs::path &page : pages())
    for (const std::string &target : matches(read_file(page), link))
      {
        EXPECT_TRUE(fs::exists(page.parent_path() / target)) << page << ": " << target;
        ++n;
      }
  EXPECT_GE(n, 10u);
}

TEST(Docs, ReadmeLinksEveryPage)
{
  const std::string readme = read_file(source / "README.md");
  unsigned int n           = 0;
  for (const auto &entry : fs::directory_iterator(source / "docs"))
    if (entry.path().extension() == ".md")
      {
        const std::string link = "](docs/" + entry.path().filename().string() + ")";
        EXPECT_NE(readme.find(link), std::string::npos) << entry.path();
        ++n;
      }
  EXPECT_GE(n, 8u);
}

TEST(Docs, EveryCaseHasItsPage)
{
  for (const auto &entry : fs::directory_iterator(source / "cases"))
    for (const char *const file : {"case.json", "expected.json", "README.md", "picture.png"})
      EXPECT_TRUE(fs::exists(entry.path() / file)) << entry.path() / file;
}
