// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs every case with the settings of its expected.json and compares summary.json with what is
// expected there: {"settings": {"/pointer": value}, "expect": {"/pointer": {"is": v} | {"at_most":
// v} |
// {"at_least": v} | {"near": v, "within": w}}}.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <cmath>

namespace
{
  using namespace feib::testing;
  using Json = nlohmann::json;

  std::vector<std::string>
  case_names()
  {
    std::vector<std::string> names;
    for (const auto &entry : std::filesystem::directory_iterator(FEIB_SOURCE "/cases"))
      if (std::filesystem::exists(entry.path() / "case.json"))
        names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

  class Cases : public ::testing::TestWithParam<std::string>
  {};
} // namespace

TEST_P(Cases, AsExpected)
{
  const std::string folder = FEIB_SOURCE "/cases/" + GetParam();
  const TemporaryFolder temporary;
  const RunResult valid = run_host("--validate " + shell_quoted(folder + "/case.json"));
  ASSERT_EQ(valid.exit_code, 0) << valid.output;

  const Json expected = read_json(folder + "/expected.json");
  std::string arguments =
    shell_quoted(folder + "/case.json") + " --output " + shell_quoted(temporary / "results");
  for (const auto &[pointer, value] : expected.at("settings").items())
    arguments += " --set " + shell_quoted(pointer + "=" + value.dump());
  const RunResult run = run_host(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const Json summary = read_json(temporary / "results/summary.json");

  ASSERT_FALSE(expected.at("expect").empty());
  for (const auto &[pointer, rule] : expected.at("expect").items())
    {
      const Json found = summary.at(Json::json_pointer(pointer));
      std::cout << pointer << " = " << found << ", expected " << rule << std::endl;
      ASSERT_EQ(rule.size(), rule.contains("near") ? 2u : 1u) << pointer << ": one rule each";
      if (rule.contains("is"))
        EXPECT_EQ(found, rule["is"]) << pointer;
      else if (rule.contains("at_most"))
        EXPECT_LE(found.get<double>(), rule["at_most"].get<double>()) << pointer;
      else if (rule.contains("at_least"))
        EXPECT_GE(found.get<double>(), rule["at_least"].get<double>()) << pointer;
      else
        EXPECT_NEAR(found.get<double>(),
                    rule.at("near").get<double>(),
                    rule.at("within").get<double>())
          << pointer;
    }
}

INSTANTIATE_TEST_SUITE_P(, Cases, ::testing::ValuesIn(case_names()), [](const auto &info) {
  return info.param;
});
