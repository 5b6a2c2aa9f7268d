// SPDX-License-Identifier: LGPL-2.1-or-later
#include "small_case.h"
#include "support/run_case.h"

#include <gtest/gtest.h>

using namespace feib::testing;
namespace fs = std::filesystem;

namespace
{
  /// A folder with the small case, the current one of what runs.
  class CommandLine : public ::testing::Test
  {
  protected:
    CommandLine()
    {
      folder.write("case.json", small_case);
    }

    RunResult
    host(const std::string &arguments, const unsigned int ranks = 1)
    {
      return run_host(arguments, ranks, folder.path.string());
    }

    /// Usage that ends with one sentence and leaves nothing behind.
    void
    refused(const std::string &arguments, const std::string &sentence)
    {
      const RunResult result = host(arguments);
      EXPECT_EQ(result.exit_code, 2) << arguments;
      EXPECT_EQ(result.output, "error: " + sentence + "\n");
      EXPECT_FALSE(fs::exists(folder / "output"));
      EXPECT_FALSE(fs::exists(folder / "out"));
    }

    TemporaryFolder folder;
  };
} // namespace

TEST_F(CommandLine, HelpAndVersion)
{
  const RunResult help = host("--help");
  EXPECT_EQ(help.exit_code, 0);
  for (const char *const option : {"--output",
                                   "--set",
                                   "--plugin-path",
                                   "--validate",
                                   "--list-plugins",
                                   "--describe",
                                   "--json",
                                   "--schema",
                                   "--log-level",
                                   "--version",
                                   "--overwrite"})
    EXPECT_TRUE(holds(help.output, option)) << option;

  const RunResult version = host("--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.output.substr(0, 10), "feib-host ");
}

TEST_F(CommandLine, UsageThatMakesNoSense)
{
  refused("--foo", "unknown option --foo; see feib-host --help");
  refused("", "which case? feib-host CASE.json runs it; see feib-host --help");
  refused("case.json other.json", "one case at a time, found case.json and other.json");
  refused("case.json --set /time/end",
          "--set /time/end has no value; write --set /json/pointer=VALUE");
  refused("case.json --json", "--json goes with --describe NAME");
  refused(
    "case.json --log-level loud",
    "there is no log level \"loud\"; the levels are trace, debug, info, warning, error and off");
  refused("none.json", "none.json: there is no such file");
  refused("case.json --plugin-path nowhere",
          "the plugin folder nowhere cannot be read: No such file or directory");
}

TEST_F(CommandLine, DescribesComponents)
{
  const RunResult text = host("--describe neo_hookean");
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_TRUE(holds(text.output, "constitutive_law/neo_hookean, from neo_hookean")) << text.output;
  EXPECT_TRUE(holds(text.output, "shear_modulus (string or number > 0, required)")) << text.output;
  EXPECT_EQ(host("--describe constitutive_law/neo_hookean").output, text.output);

  const RunResult json = host("--describe neo_hookean --json");
  EXPECT_EQ(json.exit_code, 0);
  EXPECT_TRUE(nlohmann::json::parse(json.output)["properties"].contains("shear_modulus"));

  const RunResult unknown = host("--describe neo_hokean");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_TRUE(holds(
    unknown.output,
    "there is no component \"neo_hokean\"; did you mean \"neo_hookean\"?; the components are"))
    << unknown.output;
  EXPECT_TRUE(holds(unknown.output, "\n  fluid_solver/navier_stokes\n")) << unknown.output;
}

TEST_F(CommandLine, PrintsTheSchemaOfCases)
{
  const RunResult result = host("--schema");
  EXPECT_EQ(result.exit_code, 0);
  const auto schema = nlohmann::json::parse(result.output);
  EXPECT_TRUE(schema["properties"]["fluid"]["properties"].contains("navier_stokes"));
  EXPECT_FALSE(schema.contains("fragments"));
}

TEST_F(CommandLine, ListsPlugins)
{
  const RunResult result = host("--list-plugins");
  EXPECT_EQ(result.exit_code, 0);
  for (const char *const component : {"constitutive_law/neo_hookean",
                                      "coupling_operator/variational",
                                      "fluid_solver/navier_stokes",
                                      "output_writer/vtu",
                                      "structure_model/membrane",
                                      "time_integrator/fe_be"})
    EXPECT_TRUE(holds(result.output, std::string("\n    ") + component + "\n")) << result.output;
}

TEST_F(CommandLine, FindsPluginsByVariable)
{
  const RunResult result =
    run_command("FEIB_PLUGIN_PATH=" + shell_quoted(folder.path.string()) + "; " +
                "export FEIB_PLUGIN_PATH; " + host_command() + " --list-plugins");
  EXPECT_TRUE(holds(result.output, "Looked in:\n  " + folder.path.string() + "\n"))
    << result.output;
}

TEST_F(CommandLine, ValidatesWithoutWriting)
{
  const RunResult result = host("--validate case.json --output out");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.output.rfind("case.json is valid\n", 0), 0U) << result.output;
  EXPECT_FALSE(fs::exists(folder / "out"));
  EXPECT_FALSE(fs::exists(folder / "output"));
}

TEST_F(CommandLine, RunsIntoAFolderNamedByTheCase)
{
  fs::create_directory(folder / "vessel");
  fs::copy(folder / "case.json", folder / "vessel/case.json");
  fs::copy(folder / "case.json", folder / "other.json");
  for (const std::string file : {"vessel/case.json", "other.json"})
    {
      const RunResult result = host(file);
      EXPECT_EQ(result.exit_code, 0) << result.output;
      EXPECT_TRUE(holds(result.output, "\ncompleted, results in output/")) << result.output;
      EXPECT_FALSE(holds(result.output, "%")) << "progress is for terminals: " << result.output;
    }
  for (const std::string name : {"output/vessel", "output/other"})
    {
      EXPECT_EQ(read_json(folder / (name + "/summary.json"))["status"], "completed");
      EXPECT_TRUE(holds(read_file(folder / (name + "/log.txt")), "info: Feib "));
    }
}

TEST_F(CommandLine, TheResolvedCaseIsTheExactRun)
{
  EXPECT_EQ(host("case.json --output out --set /time/end=0.2").exit_code, 0);
  EXPECT_EQ(read_json(folder / "out/resolved.json")["time"]["end"], 0.2);
  EXPECT_EQ(host("out/resolved.json --output again").exit_code, 0);
  EXPECT_EQ(read_file(folder / "again/resolved.json"), read_file(folder / "out/resolved.json"));
  EXPECT_EQ(read_json(folder / "again/summary.json")["steps"], 2);
}

TEST_F(CommandLine, NeverWritesIntoANonEmptyFolder)
{
  fs::create_directory(folder / "full");
  folder.write("full/precious.txt", "do not touch");
  const RunResult result = host("case.json --output full");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(
    result.output,
    "error: the output folder full is not empty; choose another with --output, or allow this one "
    "with --overwrite\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "full"), fs::directory_iterator()), 1);

  EXPECT_EQ(host("case.json --output full --overwrite").exit_code, 0);
  EXPECT_EQ(read_file(folder / "full/precious.txt"), "do not touch");
  EXPECT_TRUE(fs::exists(folder / "full/summary.json"));

  EXPECT_EQ(host("case.json --output case.json").output,
            "error: the output folder case.json is a file\n");
  fs::create_directory(folder / "empty");
  EXPECT_EQ(host("case.json --output empty").exit_code, 0);
}

TEST_F(CommandLine, AFolderThatCannotBeMadeIsARunTimeFailure)
{
  const RunResult result = host("case.json --output /dev/null/out");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(holds(result.output, "error: cannot make the folder /dev/null/out")) << result.output;
}

TEST_F(CommandLine, ASignalEndsTheRunInOrder)
{
  for (const std::string signal : {"TERM", "INT", "HUP", "USR2", "XCPU"})
    {
      const RunResult result = run_command(
        host_command() + " case.json --overwrite --output " + signal +
          " --set /time/step=1e-4 --set /time/end=1e4 --set /output=[] & pid=$!; until ls " +
          signal + "/log.txt >/dev/null 2>\&1; do kill -0 $pid || exit 99; done; kill -" + signal +
          " $pid; wait $pid",
        folder.path.string());
      EXPECT_EQ(result.exit_code, 1) << result.output;
      EXPECT_TRUE(holds(result.output, "stopped by")) << result.output;
      EXPECT_TRUE(holds(read_file(folder / (signal + "/log.txt")), "error: stopped by"));
      EXPECT_TRUE(holds(result.output, "\nstopped, results in " + signal + "\n")) << result.output;
      EXPECT_EQ(read_json(folder / (signal + "/summary.json"))["status"], "stopped");
    }
}

TEST_F(CommandLine, ASignalToOneOfTwoRanksEndsTheRunInOrder)
{
  // The first child of mpiexec: to whichever rank the signal goes, both stop.
  const RunResult result = run_command(
    host_command(2) +
      " case.json --output out --set /time/step=1e-4 --set /time/end=1e4 --set /output=[] & "
      "pid=$!; until ls out/log.txt >/dev/null 2>&1; do kill -0 $pid || exit 99; done; "
      "set -- $(cat /proc/$pid/task/$pid/children); kill -USR2 $1; wait $pid",
    folder.path.string());
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_EQ(read_json(folder / "out/summary.json")["status"], "stopped");
}

TEST_F(CommandLine, RunsBesideEachOther)
{
  // Open MPI's folder for temporary files goes with the program that ends, of which none may be
  // another's.
  const RunResult result = run_command(
    host_command() +
      " case.json --output out --set /time/step=1e-4 --set /time/end=1e4 --set /output=[] "
      "--set /checkpoint='{\"interval\": 1}' & pid=$!; "
      "until ls out/checkpoints >/dev/null 2>&1; do kill -0 $pid || exit 99; done; for i in 1 2 3; "
      "do " +
      shell_quoted(FEIB_HOST) + " --validate case.json; done; kill -TERM $pid; wait $pid",
    folder.path.string());
  EXPECT_EQ(read_json(folder / "out/summary.json")["status"], "stopped") << result.output;
  EXPECT_FALSE(holds(result.output, "mca_")) << result.output;
}

TEST_F(CommandLine, OneRunOwnsAFolder)
{
  const std::string busy = "error: another feib-host is writing into out; wait for its end, stop "
                           "it, or choose another folder\n";
  const RunResult result = run_command(
    host_command() +
      " case.json --output out --set /time/step=1e-4 --set /time/end=1e4 --set /output=[] "
      "--set /checkpoint='{\"interval\": 1}' & pid=$!; "
      "until ls out/checkpoints/*/* >/dev/null 2>&1; do kill -0 $pid || exit 99; done; " +
      shell_quoted(FEIB_HOST) + " case.json --output out --overwrite; echo \"exit code $?\"; " +
      shell_quoted(FEIB_HOST) + " --restart out; echo \"exit code $?\"; " +
      "grep -c 'another feib-host' out/log.txt; kill -TERM $pid; wait $pid; " +
      shell_quoted(FEIB_HOST) + " case.json --output out --overwrite",
    folder.path.string());
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const std::string refused = busy + "exit code 2\n";
  const auto first          = result.output.find(refused);
  ASSERT_NE(first, std::string::npos) << result.output;
  EXPECT_NE(result.output.find(refused + "0\n", first + 1), std::string::npos) << result.output;
}

TEST_F(CommandLine, ALogThatCannotBeWrittenIsSaid)
{
  std::filesystem::create_directory(folder / "out");
  std::filesystem::create_symlink("/dev/full", folder / "out/log.txt");
  const RunResult result = host("case.json --overwrite --output out");
  EXPECT_TRUE(holds(result.output, "warning: out/log.txt cannot be written; it ends here"))
    << result.output;
  EXPECT_EQ(read_json(folder / "out/summary.json")["steps"], 1);
}

TEST_F(CommandLine, ShowsProgressOnATerminal)
{
  const RunResult result =
    run_command("script -qec " + shell_quoted(host_command() + " case.json --output out") +
                  " /dev/null",
                folder.path.string());
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(holds(result.output, "\r\033[K100.0 %  step 1  time 0.1 of 0.1")) << result.output;
  EXPECT_FALSE(holds(read_file(folder / "out/log.txt"), "%"));
}

TEST_F(CommandLine, OneOfSeveralRanksSpeaks)
{
  EXPECT_EQ(host("--version", 2).output, host("--version").output);

  const RunResult usage = host("case.json --json", 2);
  EXPECT_EQ(usage.exit_code, 2);
  EXPECT_EQ(usage.output.find("error: --json"), usage.output.rfind("error: --json"))
    << usage.output;

  const RunResult bad = host("case.json --output out --set /time/end=-1", 2);
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_EQ(bad.output.find("/time/end: must"), bad.output.rfind("/time/end: must")) << bad.output;
  EXPECT_FALSE(fs::exists(folder / "out"));

  const RunResult good = host("case.json --output out", 2);
  EXPECT_EQ(good.exit_code, 0) << good.output;
  EXPECT_EQ(read_json(folder / "out/summary.json")["ranks"], 2);
}
