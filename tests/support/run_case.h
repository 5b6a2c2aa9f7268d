// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_tests_run_case_h
#define feib_tests_run_case_h

#include "support/run_host.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

namespace feib::testing
{
  inline bool
  holds(const std::string &text, const std::string &part)
  {
    return text.find(part) != std::string::npos;
  }


  /// The columns of numbers of a file such as ledger.csv.
  using Table = std::map<std::string, std::vector<double>>;

  inline Table
  read_table(const std::string &file)
  {
    std::istringstream text(read_file(file));
    std::string line, cell;
    std::getline(text, line);
    std::vector<std::string> names;
    for (std::istringstream header(line); std::getline(header, cell, ',');)
      names.push_back(cell);
    Table table;
    while (std::getline(text, line))
      {
        std::istringstream row(line);
        for (const std::string &name : names)
          {
            std::getline(row, cell, ',');
            table[name].push_back(std::stod(cell));
          }
      }
    return table;
  }


  /// What a run said and left behind; of a case that was refused, nothing but its output.
  struct CaseRun
  {
    int exit_code;
    std::string output, log;
    nlohmann::json summary;
    Table ledger, probe; // of the outputs ledger_csv and probe (named "p"), if any

    bool
    warned(const std::string &kind) const
    {
      for (const auto &warning : summary["warnings"])
        if (warning["kind"] == kind)
          return true;
      return false;
    }
  };


  /// Runs the case of a file with these settings (options of feib-host) in a folder of its own.
  inline CaseRun
  run_case(const std::string &file, const std::string &settings, const unsigned int ranks = 1)
  {
    const TemporaryFolder folder;
    const RunResult host =
      run_host(shell_quoted(file) + " --output " + shell_quoted(folder / "out") + " " + settings,
               ranks);
    CaseRun result{host.exit_code, host.output, "", {}, {}, {}};
    if (!std::filesystem::exists(folder / "out"))
      return result;
    if (!std::filesystem::exists(folder / "out/summary.json"))
      throw std::runtime_error("exit code " + std::to_string(host.exit_code) +
                               " and no summary.json: " + host.output);
    result.summary = read_json(folder / "out/summary.json");
    result.log     = read_file(folder / "out/log.txt");
    for (const auto &[name, table] :
         {std::pair{"out/ledger.csv", &result.ledger}, std::pair{"out/probe_p.csv", &result.probe}})
      if (std::filesystem::exists(folder / name))
        *table = read_table(folder / name);
    return result;
  }


  /// Runs the case of a text, which must come to its end.
  inline CaseRun
  run_text(const std::string &text, const std::string &settings = "", const unsigned int ranks = 1)
  {
    const TemporaryFolder folder;
    const CaseRun result = run_case(folder.write("case.json", text), settings, ranks);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return result;
  }


  /// The time scheme of that name in place of the case's.
  inline std::string
  scheme_setting(const std::string &scheme)
  {
    return "--set " + shell_quoted("/time/integrator={\"" + scheme + "\":{}}");
  }
} // namespace feib::testing

#endif
