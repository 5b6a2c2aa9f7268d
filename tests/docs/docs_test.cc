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

  /// What links into a page may name: its headings in small letters, without marks, blanks as
  /// hyphens.
  std::set<std::string>
  anchors(const fs::path &page)
  {
    std::set<std::string> result;
    bool code = false;
    std::string line;
    for (std::istringstream text(read_file(page)); std::getline(text, line);)
      {
        code = code != (line.rfind("```", 0) == 0);
        if (code || line.rfind("#", 0) != 0)
          continue;
        std::string name;
        for (const unsigned char c : line.substr(std::min(line.find(' '), line.size() - 1) + 1))
          if (std::isalnum(c) || c == '-' || c == '_' || c >= 0x80)
            name += std::tolower(c);
          else if (c == ' ')
            name += '-';
        result.insert(name);
      }
    return result;
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

TEST(Docs, LinkedFilesAndSectionsExist)
{
  const std::regex link("\\]\\(([^):]+)\\)");
  unsigned int n = 0, n_sections = 0;
  for (const fs::path &page : pages())
    for (const std::string &target : matches(read_file(page), link))
      {
        const std::size_t hash = target.find('#');
        const fs::path file    = hash == 0 ? page : page.parent_path() / target.substr(0, hash);
        EXPECT_TRUE(fs::exists(file)) << page << ": " << target;
        ++n;
        if (hash != std::string::npos && file.extension() == ".md")
          {
            EXPECT_EQ(anchors(file).count(target.substr(hash + 1)), 1u) << page << ": " << target;
            ++n_sections;
          }
      }
  EXPECT_GE(n, 100u);
  EXPECT_GE(n_sections, 20u);
}

TEST(Docs, TablesHaveHeads)
{
  // Below the first row of a table stands one of dashes; else it is no table.
  const std::regex row("\\|[ :-].*\\|"), dashes("\\|[ :|-]*-[ :|-]*\\|");
  unsigned int n = 0;
  for (const fs::path &page : pages())
    {
      bool code = false, in_table = false;
      std::string line, first;
      for (std::istringstream text(read_file(page)); std::getline(text, line);)
        {
          code = code != (line.rfind("```", 0) == 0);
          if (code || !std::regex_match(line, row))
            {
              EXPECT_TRUE(first.empty()) << page << ": " << first;
              in_table = false;
              first.clear();
            }
          else if (!first.empty())
            {
              EXPECT_TRUE(std::regex_match(line, dashes)) << page << ": " << first;
              in_table = true;
              first.clear();
              ++n;
            }
          else if (!in_table)
            first = line;
        }
    }
  EXPECT_GE(n, 50u);
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
