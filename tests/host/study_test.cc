// SPDX-License-Identifier: LGPL-2.1-or-later
// feib-study, run as a user runs it.
#include "small_case.h"
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <set>
#include <vector>

namespace
{
  using namespace feib::testing;
  namespace fs = std::filesystem;
  using Json   = nlohmann::json;

  /// The fields of a text in the format of RFC 4180.
  std::vector<std::vector<std::string>>
  read_csv(const std::string &file)
  {
    const std::string text = read_file(file);
    std::vector<std::vector<std::string>> rows;
    std::vector<std::string> row(1);
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i)
      if (quoted && text.compare(i, 2, "\"\"") == 0)
        row.back() += text[i++];
      else if (text[i] == '"')
        quoted = !quoted;
      else if (quoted)
        row.back() += text[i];
      else if (text[i] == ',')
        row.emplace_back();
      else if (text.compare(i, 2, "\r\n") == 0)
        {
          rows.push_back(row);
          row.assign(1, "");
          ++i;
        }
      else
        row.back() += text[i];
    EXPECT_EQ(row, std::vector<std::string>(1)) << "the last line does not end";
    return rows;
  }

  /// A folder with a case, the current one of what runs.
  class Study : public ::testing::Test
  {
  protected:
    Study()
    {
      folder.write("case.json", small_case);
    }

    /// Writes the study and runs it, its results going to the folder "out".
    RunResult
    study(const std::string &text)
    {
      folder.write("study.json", text);
      return run_command(command + " study.json --output out --jobs 4", folder.path.string());
    }

    /// The study must end with exit code 2, having written nothing but these words.
    void
    refused(const std::string &text, const std::string &words)
    {
      const RunResult result = study(text);
      EXPECT_EQ(result.exit_code, 2);
      EXPECT_EQ(result.output, words);
      EXPECT_FALSE(fs::exists(folder / "out"));
    }

    Json
    summary(const std::string &run) const
    {
      return read_json(folder / ("out/runs/" + run + "/summary.json"));
    }

    const std::string command = shell_quoted(FEIB_STUDY);
    TemporaryFolder folder;
  };

  using StudyRuns  = Study;
  using StudyInput = Study;
} // namespace

TEST_F(StudyRuns, TheTableHoldsWhatTheRunsSay)
{
  const RunResult result = study(R"({
  // Comments are allowed.
  "title": "A fluid set going",
  "case": "case.json",
  "set": { "/output": [], "/time/end": 0.2 },
  "axes": [
    { "name": "fluid", "values": [
      { "label": "thin", "set": { "/fluid/navier_stokes/body_force": [ "y^2", 0 ] } },
      { "label": "thick, \"honey\"", "set": { "/fluid/navier_stokes/body_force": [ "y^2", 0 ],
                                          "/fluid/navier_stokes/viscosity": 5 } } ] },
    { "name": "dt", "pointer": [ "/time/step" ], "values": [ 0.1, 0.05, 0.025 ] } ],
  "columns": [
    { "name": "kinetic", "pointer": "/energy/kinetic" },
    { "name": "steps", "pointer": "/steps" },
    { "name": "rounded", "pointer": "/time", "format": "%.2f s" },
    { "name": "none", "pointer": "/structures/0/name" } ],
  "rates": [
    { "axis": "dt", "column": "steps" },
    { "axis": "dt", "column": "kinetic", "of": "differences" } ]
})");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(holds(result.output, "/6] fluid=thick, \"honey\", dt=0.025: completed"))
    << result.output;
  EXPECT_TRUE(holds(result.output, "runs done: 6, found done: 0, results in out\n"));

  const auto table = read_csv(folder / "out/table.csv");
  ASSERT_EQ(table.size(), 7u);
  EXPECT_EQ(table[0],
            (std::vector<std::string>{"fluid",
                                      "dt",
                                      "status",
                                      "kinetic",
                                      "rate(kinetic)",
                                      "steps",
                                      "rate(steps)",
                                      "rounded",
                                      "none"}));
  const std::string labels[]  = {"thin", "thick, \"honey\""};
  const std::string folders[] = {"thin", "thick___honey_"};
  const double steps[]        = {0.1, 0.05, 0.025};
  const std::string texts[]   = {"0.1", "0.05", "0.025"};
  for (unsigned int i = 0; i < 6; ++i)
    {
      const auto &row = table[i + 1];
      ASSERT_EQ(row.size(), table[0].size());
      EXPECT_EQ(row[0], labels[i / 3]);
      EXPECT_EQ(std::stod(row[1]), steps[i % 3]);
      EXPECT_EQ(row[2], "completed");
      const Json run = summary("fluid=" + folders[i / 3] + ",dt=" + texts[i % 3]);
      EXPECT_EQ(std::stod(row[3]), run["energy"]["kinetic"].get<double>()) << "all digits";
      EXPECT_GT(std::stod(row[3]), 0);
      EXPECT_EQ(row[5], run["steps"].dump());
      EXPECT_EQ(row[6], i % 3 == 0 ? "" : "-1") << "twice the steps for half the step";
      EXPECT_EQ(row[8], "");
      if (i % 3 < 2)
        {
          EXPECT_EQ(row[4], "");
        }
      else
        {
          const auto kinetic = [&](const unsigned int j) { return std::stod(table[j][3]); };
          EXPECT_DOUBLE_EQ(std::stod(row[4]),
                           std::log(std::abs((kinetic(i + 1) - kinetic(i)) /
                                             (kinetic(i) - kinetic(i - 1)))) /
                             std::log(0.5));
        }
    }

  const std::string markdown = read_file(folder / "out/table.md");
  EXPECT_TRUE(holds(result.output, markdown));
  EXPECT_EQ(markdown.substr(0, 20), "A fluid set going\n\n|");
  std::istringstream lines(markdown.substr(19));
  std::string header, rule, first;
  std::getline(lines, header);
  std::getline(lines, rule);
  std::getline(lines, first);
  EXPECT_EQ(header.substr(0, 36), "| fluid          |    dt | status   ") << header;
  EXPECT_EQ(rule.substr(0, 36), "| :------------- | ----: | :--------") << rule;
  EXPECT_EQ(first.substr(0, 36), "| thin           |   0.1 | completed") << first;
  EXPECT_TRUE(holds(first, " |  0.20 s |")) << first;
  EXPECT_EQ(header.size(), rule.size());
  EXPECT_EQ(header.size(), first.size());
}

TEST_F(StudyRuns, WhatIsDoneIsNotRepeated)
{
  const std::string text = R"({ "case": "case.json", "set": { "/output": [] },
  "axes": [ { "name": "end", "pointer": "/time/end", "values": [ 0.1, 0.2 ] } ],
  "columns": [ { "name": "steps", "pointer": "/steps" } ] })";
  EXPECT_TRUE(holds(study(text).output, "runs done: 2, found done: 0,"));
  const std::string table = read_file(folder / "out/table.csv");
  EXPECT_EQ(table,
            "end,status,steps\r\n0.10000000000000001,completed,1\r\n"
            "0.20000000000000001,completed,2\r\n");

  fs::remove(folder / "out/table.csv");
  EXPECT_TRUE(holds(study(text).output, "runs done: 0, found done: 2,"));
  EXPECT_EQ(read_file(folder / "out/table.csv"), table);

  fs::remove(folder / "out/runs/end=0.2/run.json");
  const RunResult one = study(text);
  EXPECT_TRUE(holds(one.output, "end=0.2: completed")) << one.output;
  EXPECT_TRUE(holds(one.output, "runs done: 1, found done: 1,")) << one.output;

  // Another setting of one run, then another case.
  std::string changed = text;
  changed.replace(changed.find("0.1, 0.2"), 8, "0.1");
  changed.replace(changed.find("[] }"), 4, "[], \"/title\": \"new\" }");
  EXPECT_TRUE(holds(study(changed).output, "runs done: 1, found done: 0,"));
  folder.write("case.json", std::string("// the same, but who knows\n") + small_case);
  EXPECT_TRUE(holds(study(changed).output, "runs done: 1, found done: 0,"));

  const RunResult locked =
    run_command("flock out/runs " + command + " study.json --output out", folder.path.string());
  EXPECT_EQ(locked.exit_code, 1);
  EXPECT_TRUE(holds(locked.output, "error: another feib-study works in out")) << locked.output;
}

TEST_F(StudyRuns, BisectsTheStepOfAStiffMembrane)
{
  const std::string text = R"json({ "case": "case.json",
  "set": { "/output": [], "/time/end": 0.05, "/time/control": { "fixed": { "minimum_step": 0.1 } },
    "/structures": [ { "membrane": { "name": "m",
    "mesh": { "closed_curve": { "length": 1, "elements": 16 } },
    "initial_position": [ "0.5+0.24*cos(2*pi*s1)", "0.5+0.16*sin(2*pi*s1)" ],
    "law": { "anisotropic_linear": { "stiffness": 1 } } } } ] },
  "axes": [ { "name": "stiffness", "values": [ 1, 1000, 1000000 ],
              "pointer": "/structures/0/membrane/law/anisotropic_linear/stiffness" } ],
  "bisect": { "name": "dt", "pointer": ["/time/step", "/time/control/fixed/minimum_step"],
    "lower": 1e-3, "upper": 0.05, "ratio": 3 },
  "columns": [ { "name": "steps", "pointer": "/steps" } ] })json";
  const RunResult result = study(text);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const auto table = read_csv(folder / "out/table.csv");
  ASSERT_EQ(table.size(), 4u);
  EXPECT_EQ(table[0], (std::vector<std::string>{"stiffness", "dt", "status", "steps"}));
  EXPECT_EQ(table[1], (std::vector<std::string>{"1", "> 0.05", "completed", "1"}));
  EXPECT_EQ(table[3], (std::vector<std::string>{"1000000", "< 0.001", "failed", ""}));

  // The runs themselves bracket the limit.
  double completed = 0, failed = 1;
  for (const auto &entry : fs::directory_iterator(folder / "out/runs"))
    if (entry.path().filename().string().rfind("stiffness=1000,", 0) == 0)
      {
        const double dt = read_json(entry.path() / "resolved.json")["time"]["step"];
        if (read_json(entry.path() / "summary.json")["status"] != "failed")
          completed = std::max(completed, dt);
        else
          failed = std::min(failed, dt);
      }
  EXPECT_EQ(table[2][0], "1000");
  EXPECT_EQ(std::stod(table[2][1]), completed);
  EXPECT_EQ(table[2][2], "completed_with_warnings"); // above the forecast
  EXPECT_EQ(std::stod(table[2][3]), std::ceil(0.05 / completed));
  EXPECT_LT(completed, failed);
  EXPECT_LE(failed, 3 * completed);
  EXPECT_LT(failed, 0.05);

  EXPECT_TRUE(holds(study(text).output, "runs done: 0,"));
}

TEST_F(StudyRuns, AnInterruptedStudyGoesOnWhereItWas)
{
  const auto text = [](const std::string &end) {
    return R"({ "case": "case.json", "set": { "/output": [] }, "axes": [ { "name": "run", "values": [
  { "label": "short", "set": {} },
  { "label": "long", "set": { "/time/step": 1e-4, "/time/end": )" +
           end + " } } ] } ] }";
  };
  folder.write("study.json", text("1e4"));
  const RunResult interrupted = run_command(
    command +
      " study.json --output out --jobs 1 & pid=$!; "
      "until ls out/runs/run=long/log.txt >/dev/null 2>&1; do kill -0 $pid || exit 99; done; "
      "kill -TERM $pid; wait $pid",
    folder.path.string());
  EXPECT_EQ(interrupted.exit_code, 1) << interrupted.output;
  EXPECT_TRUE(holds(interrupted.output, "[1/2] run=short: completed")) << interrupted.output;
  EXPECT_TRUE(
    holds(interrupted.output, "[2/2] run=long: no result, see out/runs/run=long/host.txt"))
    << interrupted.output;
  EXPECT_TRUE(holds(interrupted.output, "error: stopped by a signal; the same command goes on"))
    << interrupted.output;
  EXPECT_TRUE(holds(read_file(folder / "out/runs/run=long/host.txt"), "stopped by a signal"));
  EXPECT_FALSE(fs::exists(folder / "out/runs/run=long/run.json"));
  EXPECT_FALSE(fs::exists(folder / "out/table.csv"));

  const RunResult resumed = study(text("1e-3"));
  EXPECT_EQ(resumed.exit_code, 0) << resumed.output;
  EXPECT_TRUE(holds(resumed.output, "runs done: 1, found done: 1,")) << resumed.output;
  EXPECT_EQ(summary("run=long")["steps"], 10);
}

TEST_F(StudyRuns, ARunThatIsKilledIsNoResult)
{
  folder.write("study.json",
               R"({ "case": "case.json", "set": { "/output": [], "/time/step": 1e-4 },
  "axes": [ { "name": "end", "pointer": "/time/end", "values": [ 1e4 ] } ] })");
  const std::string log = "out/runs/end=10000/log.txt";
  // The log names no process: the only child of the study is the run.
  const RunResult result =
    run_command(command + " study.json --output out & pid=$!; until ls " + log +
                  " >/dev/null 2>\&1; do kill -0 $pid || exit 99; done; "
                  "kill -KILL $(cat /proc/$pid/task/$pid/children); wait $pid",
                folder.path.string());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(holds(result.output, "[1/1] end=10000: no result, Killed")) << result.output;
  EXPECT_TRUE(holds(result.output, "| 10000 | no result |")) << result.output;
  EXPECT_TRUE(holds(result.output, "error: runs without a result: 1; the same command repeats"))
    << result.output;
}

TEST_F(StudyRuns, RunsOnSeveralRanksEvenUnderMpi)
{
  folder.write("study.json", R"({ "case": "case.json", "ranks": 2, "set": { "/output": [] },
  "axes": [ { "name": "dt", "pointer": "/time/step", "values": [ 0.1 ] } ] })");
  const RunResult result = run_command(
    "unset $(env | grep -oE '^(OMPI_COMM|OMPI_MCA_(ess|orte|pmix)|PMIX|PRTE)[A-Za-z0-9_]*'); " +
      shell_quoted(FEIB_MPIEXEC) + " -np 1 --oversubscribe " + command + " study.json --output out",
    folder.path.string());
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(summary("dt=0.1")["ranks"], 2);
}

TEST_F(StudyRuns, RunsShareNoFolderOfMpi)
{
  // A file stands where programs of Open MPI 4 have their common folder: whoever needs it fails.
  fs::create_directory(folder / "tmp");
  folder.write("study.json", R"({ "case": "case.json", "ranks": 2, "set": { "/output": [] },
  "axes": [ { "name": "dt", "pointer": "/time/step", "values": [ 0.1, 0.05 ] } ] })");
  const RunResult result =
    run_command("export TMPDIR=$PWD/tmp; touch tmp/ompi.$(hostname).$(id -u); " + command +
                  " study.json --output out --jobs 2",
                folder.path.string());
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(summary("dt=0.1")["status"], "completed");
  EXPECT_EQ(summary("dt=0.05")["status"], "completed");
  EXPECT_EQ(run_command("ls tmp | grep -v '^ompi'", folder.path.string()).output, "");
}

TEST_F(StudyInput, MistakesAreAnsweredWithTheirPlaces)
{
  refused(R"({ "case": "case.json", "tittle": "",
  "axes": [ { "name": "a", "pointer": "/time/step", "values": [] },
            { "name": "b", "values": [ 1 ] } ] })",
          "study.json:1:34: error: /tittle: unknown key \"tittle\"; did you mean \"title\"?\n"
          "study.json:2:63: error: /axes/0/values: must have at least 1 entry, found 0\n"
          "study.json:3:40: error: /axes/1/values/0: must be an object, found the number 1\n");
  refused(
    R"({ "case": "none.json", "set": { "time": 1 },
  "axes": [ { "name": "a", "pointer": "/x", "values": [ 1, 1.0, "x y", "x_y" ] },
            { "name": "a", "pointer": "/x", "values": [ 1 ] } ],
  "bisect": { "name": "status", "pointer": "/x", "lower": 2, "upper": 1 },
  "columns": [ { "name": "c", "pointer": "x" }, { "name": "d", "pointer": "/x", "format": "%s" } ],
  "rates": [ { "axis": "a", "column": "c" }, { "axis": "b", "column": "e" } ] })",
    "study.json:1:11: error: /case: none.json: there is no such file\n"
    "study.json:1:31: error: /set: a JSON pointer starts with /, e.g. \"/time/step\", found "
    "\"time\"\n"
    "study.json:2:60: error: /axes/0/values/1: the value 1 stands here a second time\n"
    "study.json:2:72: error: /axes/0/values/3: \"x y\" and \"x_y\" would give their runs the same "
    "folder, \"x_y\"\n"
    "study.json:3:23: error: /axes/1/name: the name \"a\" stands here a second time\n"
    "study.json:4:23: error: /bisect/name: \"status\" is the name of a column that every table "
    "has\n"
    "study.json:4:71: error: /bisect/upper: must be greater than \"lower\", 2, found 1\n"
    "study.json:5:42: error: /columns/0/pointer: must be a JSON pointer, e.g. \"/energy/kinetic\", "
    "found \"x\"\n"
    "study.json:5:91: error: /columns/1/format: must format one number with %e, %f or %g, e.g. "
    "\"%.3e\", found \"%s\"\n"
    "study.json:6:24: error: /rates/0/axis: rates need an axis whose values are all numbers; those "
    "of \"a\" are not\n"
    "study.json:6:56: error: /rates/1/axis: must be \"a\" or \"a\", found \"b\"\n"
    "study.json:6:71: error: /rates/1/column: must be \"status\", \"c\" or \"d\", found \"e\"\n");
  refused(R"({ "case": "case.json" })",
          "study.json:1:1: error: must have at least one entry in \"axes\", or a \"bisect\"\n");
  refused(R"({ "case": "case.json", "case": "case.json" })",
          "study.json:1:24: error: /case: the key \"case\" stands here a second time\n");
}

TEST_F(StudyInput, OneBadCaseStopsItBeforeAnyRun)
{
  refused(R"({ "case": "case.json",
  "axes": [ { "name": "dt", "pointer": "/time/step", "values": [ 0.1, -1, "x" ] } ] })",
          "error: the case with dt=-1 cannot be run:\n"
          "--set /time/step: error: /time/step: must be greater than 0, found -1\n");
}

TEST_F(StudyInput, CommandLine)
{
  const auto result = [&](const std::string &arguments) {
    return run_command(command + " " + arguments, folder.path.string());
  };
  EXPECT_EQ(result("").output,
            "error: which study? feib-study STUDY.json runs it; see feib-study --help\n");
  EXPECT_EQ(result("none.json").output, "error: none.json: there is no such file\n");
  const RunResult no_jobs = result("a.json --jobs 0");
  EXPECT_EQ(no_jobs.exit_code, 2);
  EXPECT_EQ(no_jobs.output, "error: --jobs must be at least 1, found 0\n");
  EXPECT_EQ(result("--version").output.substr(0, 11), "feib-study ");

  fs::create_directory(folder / "studies");
  folder.write("studies/step.study.json", R"({ "case": "../case.json",
  "axes": [ { "name": "dt", "pointer": "/time/step", "values": [ 0.1 ] } ] })");
  EXPECT_EQ(result("studies/step.study.json --validate").output,
            "studies/step.study.json is valid; combinations: 1\n");
  EXPECT_FALSE(fs::exists(folder / "output"));
  EXPECT_EQ(result("studies/step.study.json").exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "output/step/table.md"));
}

TEST_F(StudyInput, ThePageAndTheStudiesOfTheProjectAreCurrent)
{
  const std::string help = run_command(command + " --help").output;
  const std::string page = read_file(FEIB_SOURCE "/docs/studies.md");
  const std::regex option("--[a-z][a-z-]+");
  std::set<std::string> options;
  for (std::sregex_iterator match(help.begin(), help.end(), option), end; match != end; ++match)
    options.insert(match->str());
  EXPECT_EQ(options.size(), 6u);
  for (const std::string &name : options)
    EXPECT_TRUE(holds(page, "`" + name)) << name;

  bool shows_one = false;
  for (const auto &entry : fs::directory_iterator(FEIB_SOURCE "/docs/studies"))
    {
      const std::string text = read_file(entry.path().string());
      shows_one              = shows_one || holds(page, "```json\n" + text + "```");
      // Valid with the first value of each axis: checking them all takes long.
      Json document    = Json::parse(text, nullptr, true, true);
      document["case"] = fs::absolute(entry.path().parent_path() / document["case"]).string();
      for (Json &axis : document["axes"])
        axis["values"] = Json::array({axis["values"][0]});
      const RunResult result = run_command(
        command + " --validate " + shell_quoted(folder.write("study.json", document.dump())));
      EXPECT_EQ(result.exit_code, 0) << entry.path() << ": " << result.output;
    }
  EXPECT_TRUE(shows_one);
}
