// SPDX-License-Identifier: LGPL-2.1-or-later
// Trouble while running: a clear message, the last good state on disk, exit code 1.
#include "support/run_case.h"

#include <gtest/gtest.h>

namespace
{
  using namespace feib::testing;

  const char *const elliptic_membrane = FEIB_SOURCE "/cases/elliptic_membrane/case.json";

  /// Failures are final and growing energy is no failure.
  std::string
  no_safeguards(const double step)
  {
    return " --set /time/energy_growth=1e9 --set '/time/control={\"fixed\": {\"minimum_step\": " +
           std::to_string(step) + "}}'";
  }
} // namespace

TEST(RunFailure, AnUnstableStepEndsWithTheLastGoodState)
{
  for (const unsigned int ranks : {1, 2})
    {
      const TemporaryFolder folder;
      // Closed walls and a time step far beyond the limit of the explicit scheme; without
      // convection, which would fail first.
      const RunResult run = run_host(
        shell_quoted(elliptic_membrane) + " --output " + shell_quoted(folder / "out") +
          " --set /domain/periodic=[] --set /domain/cells=[16,16]"
          " --set /time/step=0.1 --set /time/end=10 --set /fluid/navier_stokes/convection=none" +
          no_safeguards(.1),
        ranks);
      EXPECT_EQ(run.exit_code, 1) << run.output;
      EXPECT_TRUE(holds(run.output, "error: the structure \"membrane\" leaves the box: node"))
        << run.output;
      const auto summary = read_json(folder / "out/summary.json");
      EXPECT_EQ(summary["status"], "failed");
      EXPECT_TRUE(holds(summary["message"], "leaves the box"));
      EXPECT_TRUE(holds(read_file(folder / "out/log.txt"), "leaves the box"));

      // The last row of the ledger and the last output are of the step the message names.
      const int steps = summary["steps"];
      EXPECT_TRUE(
        holds(summary["message"], "the last good state is step " + std::to_string(steps)));
      char last[32];
      std::snprintf(last, sizeof last, "fluid_%06d.pvtu", steps);
      EXPECT_TRUE(std::filesystem::exists(folder / (std::string("out/") + last)));
      std::istringstream ledger(read_file(folder / "out/ledger.csv"));
      std::string line;
      int rows = -1; // the header
      while (std::getline(ledger, line))
        {
          EXPECT_FALSE(holds(line, "nan") || holds(line, "inf")) << line;
          ++rows;
        }
      EXPECT_EQ(rows, steps + 1);
    }
}

TEST(RunFailure, APeriodicBoxHasNoOutsideButElementsAreNotLongerThanIt)
{
  const TemporaryFolder folder;
  const RunResult run =
    run_host(shell_quoted(elliptic_membrane) + " --output " + shell_quoted(folder / "out") +
             " --set /domain/cells=[16,16] --set /time/step=0.05 --set /time/end=5 --set /output=[]"
             " --set /fluid/navier_stokes/convection=none"
             " --set '/refinement={\"immersed_cells\": {\"level\": 1, \"interval\": 1}}'" +
             no_safeguards(.05));
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_TRUE(holds(run.output, "one of its elements is longer than the box")) << run.output;
}

/// A ring in a stream comes where its coupling is not made for.
TEST(RunFailure, AStructureThatComesWhereItsCouplingRefusesItIsTold)
{
  const TemporaryFolder folder;
  folder.write("case.json", R"json({
    "dimension": 2,
    "domain": { "cells": [8, 8], "boundary": {
      "x_min": { "velocity": { "value": ["1", "0"] } }, "x_max": { "outflow": {} },
      "y_min": { "free_slip": {} }, "y_max": { "free_slip": {} } } },
    "fluid": { "navier_stokes": { "density": 1, "viscosity": 1, "convection": "none",
                                  "initial_velocity": ["1", "0"] } },
    "structures": [ { "membrane": { "name": "ring",
      "mesh": { "closed_curve": { "length": 0.5, "elements": 16 } },
      "initial_position": ["0.5 + 0.08*cos(4*pi*s1)", "0.5 + 0.08*sin(4*pi*s1)"],
      "law": { "anisotropic_linear": { "stiffness": 0.001 } } } } ],
    "coupling": { "regularised_delta": {} },
    "time": { "step": 0.05, "end": 2, "control": { "fixed": { "minimum_step": 0.05 } } }
  })json");
  for (const unsigned int ranks : {1, 2})
    {
      const RunResult run =
        run_host("case.json --overwrite --output out", ranks, folder.path.string());
      EXPECT_EQ(run.exit_code, 1) << run.output;
      const std::string why = "nearer to a side of the box than the kernel of the coupling reaches";
      EXPECT_TRUE(holds(run.output, why)) << run.output;
      const auto summary = read_json(folder / "out/summary.json");
      EXPECT_EQ(summary["status"], "failed");
      EXPECT_TRUE(holds(summary["message"], why));
      EXPECT_GT(summary["steps"], 0);
    }
  // With the correction it goes on until it is out of the box.
  const RunResult run = run_host("case.json --overwrite --output out"
                                 " --set /coupling/regularised_delta/reproducing=true",
                                 1,
                                 folder.path.string());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(holds(run.output, "outside the box")) << run.output;
}

TEST(RunFailure, AFileThatCannotBeWrittenIsNamed)
{
  for (const std::string file : {"ledger.csv", "fluid.pvd", "summary.json"})
    {
      const TemporaryFolder folder;
      std::filesystem::create_directories(folder / ("out/" + file + "/in_the_way"));
      const RunResult run = run_host(shell_quoted(elliptic_membrane) + " --overwrite --output " +
                                     shell_quoted(folder / "out") +
                                     " --set /domain/cells=[8,8] --set /time/end=0.001 "
                                     "--set '/output=[{\"ledger_csv\": {}}, {\"vtu\": {}}]'");
      EXPECT_EQ(run.exit_code, 1) << run.output;
      EXPECT_TRUE(holds(run.output, file)) << run.output;
    }
}

TEST(RunFailure, ASolverThatDoesNotConvergeSaysHowFarItCame)
{
  const TemporaryFolder folder;
  const RunResult run =
    run_host(shell_quoted(FEIB_SOURCE "/cases/cavity_disc/case.json") + " --output " +
             shell_quoted(folder / "out") +
             " --set /domain/cells=[8,8] --set '/fluid/navier_stokes/convection=\"implicit\"' "
             "--set /fluid/navier_stokes/max_iterations=1 --set /time/end=0.02" +
             no_safeguards(.01));
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_TRUE(holds(run.output, "did not reach its tolerance in 1 iterations; relative residuals"))
    << run.output;
  EXPECT_EQ(read_json(folder / "out/summary.json")["steps"], 0);
}

// Who read what the program prints is gone before it begins.
TEST(RunFailure, NobodyNeedsToListen)
{
  const TemporaryFolder folder;
  run_command("mkfifo gone; { read x <gone; " + host_command() + " " +
                shell_quoted(elliptic_membrane) +
                " --output out --set /domain/cells=[8,8] --set /time/end=0.002 --set '/output=[]' "
                "2>&1; echo $? >code; } | { exec <&-; echo x >gone; };",
              folder.path.string());
  EXPECT_EQ(read_file(folder / "code"), "0\n");
  EXPECT_EQ(read_json(folder / "out/summary.json")["status"], "completed");
}
