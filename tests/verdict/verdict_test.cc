// SPDX-License-Identifier: LGPL-2.1-or-later
// What a run says of itself: nothing doubtful ends as "completed" alone, nothing hangs, and every
// failure leaves a summary, a line in the log, and its cause.
#include "support/run_host.h"

#include <gtest/gtest.h>

namespace
{
  using namespace feib::testing;

  const std::string membrane = FEIB_SOURCE "/cases/elliptic_membrane/case.json",
                    disc     = FEIB_SOURCE "/cases/cavity_disc/case.json";

  bool
  holds(const std::string &text, const std::string &part)
  {
    return text.find(part) != std::string::npos;
  }

  struct Result
  {
    int exit_code;
    std::string output, log;
    nlohmann::json summary;

    bool
    warned(const std::string &kind) const
    {
      for (const auto &warning : summary["warnings"])
        if (warning["kind"] == kind)
          return true;
      return false;
    }
  };

  Result
  run(const std::string &file, const std::string &settings, const unsigned int ranks = 1)
  {
    const TemporaryFolder folder;
    const RunResult host =
      run_host(shell_quoted(file) + " --plugin-path " + shell_quoted(FEIB_FAULTY) + " --output " +
                 shell_quoted(folder / "out") + " --set '/output=[]' " + settings,
               ranks);
    Result result{host.exit_code, host.output, "", {}};
    if (std::filesystem::exists(folder / "out/summary.json"))
      {
        result.summary = read_json(folder / "out/summary.json");
        result.log     = read_file(folder / "out/log.txt");
      }
    return result;
  }

  /// Refused, failed or doubtful: anything but plain "completed".
  void
  expect_doubt(const Result &result)
  {
    if (result.exit_code == 2) // refused before the first step
      return;
    ASSERT_TRUE(result.summary.is_object()) << result.output;
    const std::string status = result.summary["status"];
    EXPECT_NE(status, "completed") << result.output;
    EXPECT_EQ(result.exit_code, status == "failed" ? 1 : 0) << result.output;
    EXPECT_TRUE(status == "failed" || !result.summary["warnings"].empty());
    EXPECT_TRUE(holds(result.output, "\n" + status)) << result.output;
  }

  /// A small disc of the law in a resting box.
  std::string
  disc_with(const std::string &law)
  {
    return "--set /domain/cells=[8,8] --set /domain/boundary={} --set "
           "'/coupling={\"divergence_free\": {}}' --set "
           "'/structures/0/hyperelastic/mesh={\"disc\": {\"centre\": [0.5, 0.5], \"radius\": 0.25, "
           "\"rings\": 4}}' --set '/structures/0/hyperelastic/initial_position=[\"0.5+1.2*(s1-0.5)"
           "\", \"0.5+(s2-0.5)/1.2\"]' --set /time/step=0.02 --set /time/end=0.4 --set "
           "'/structures/0/hyperelastic/law={\"faulty\": " +
           law + "}' ";
  }
} // namespace

TEST(Verdict, AGoodRunIsCompleted)
{
  const Result result = run(disc, disc_with("{}"));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.summary["status"], "completed") << result.output;
  EXPECT_TRUE(result.summary["warnings"].empty());
  EXPECT_TRUE(holds(result.output, "\ncompleted, results in ")) << result.output;
  EXPECT_LT(std::abs(result.summary["energy"]["unexplained"].get<double>()), 1e-12);
}

TEST(Verdict, UnstableRunsAreNotCompleted)
{
  const std::string small = "--set /domain/cells=[8,8] ";
  // Explicit schemes above their limits, alone and under a lid.
  for (const std::string scheme : {"fe_be", "midpoint"})
    {
      const std::string choice = "--set '/time/integrator={\"" + scheme + "\": {}}' ";
      expect_doubt(run(membrane, small + choice + "--set /time/step=0.03 --set /time/end=0.6"));
      expect_doubt(run(disc,
                       small + choice +
                         "--set /time/step=0.1 --set /time/end=2 --set "
                         "/structures/0/hyperelastic/law/neo_hookean/shear_modulus=20"));
    }
  // The work of a lid hides nothing.
  expect_doubt(run(membrane,
                   small +
                     "--set '/domain/boundary={\"y_max\": {\"velocity\": {\"value\": [1, 0]}}}' "
                     "--set /time/step=0.03 --set /time/end=0.6"));
  // Nor what steps shortened by failures rescue.
  expect_doubt(run(disc,
                   small + "--set /time/step=0.2 --set /time/end=1 --set "
                           "/structures/0/hyperelastic/law/neo_hookean/shear_modulus=100"));
  // A surface in space.
  expect_doubt(run(FEIB_SOURCE "/cases/ellipsoid/case.json",
                   "--set /domain/cells=[4,4,4] --set /time/step=0.1 --set /time/end=0.4"));
  // The area is lost to the scheme.
  const Result relaxing =
    run(membrane,
        small + "--set '/time/integrator={\"lagged_be\": {}}' --set /time/step=1 --set /time/end=5 "
                "--set /structures/0/membrane/law/anisotropic_linear/stiffness=10");
  expect_doubt(relaxing);
}

TEST(Verdict, ABoxWithAnOutflowIsJudgedToo)
{
  const std::string open = "--set /domain/cells=[8,8] --set "
                           "'/domain/boundary={\"x_max\": {\"outflow\": {}}}' ";
  expect_doubt(run(membrane,
                   open + "--set '/time/integrator={\"fe_be\": {}}' --set /time/step=0.03 "
                          "--set /time/end=0.6"));
}

TEST(Verdict, ALawWhoseStressIsNotTheDerivativeOfItsEnergy)
{
  // Also when it becomes wrong while the run is under way.
  for (const std::string start : {"0", "30"})
    {
      const Result result =
        run(disc, disc_with("{\"fault\": \"doubled\", \"start\": " + start + "}"));
      expect_doubt(result);
      if (start == "30")
        {
          EXPECT_EQ(result.exit_code, 1);
          EXPECT_TRUE(holds(result.output, "the stress of its law is not the derivative of its"))
            << result.output;
          EXPECT_FALSE(holds(result.output, "trying dt")) << "no shorter step helps";
        }
    }
}

TEST(Verdict, ALawWithNegativeEnergy)
{
  expect_doubt(run(disc, disc_with("{\"fault\": \"negative\"}") + "--set /time/end=4"));
}

TEST(Verdict, WhatALawThrowsEndsTheRunOnAllRanks)
{
  for (const std::string fault : {"throws_int", "throws_std", "throws_failure", "not_finite"})
    for (const unsigned int ranks : {1, 2})
      {
        const Result result =
          run(disc,
              disc_with("{\"fault\": \"" + fault +
                        "\", \"start\": 40, \"rank\": " + std::to_string(ranks - 1) + "}"),
              ranks);
        EXPECT_EQ(result.exit_code, 1) << result.output;
        ASSERT_TRUE(result.summary.is_object()) << result.output;
        EXPECT_EQ(result.summary["status"], "failed");
        for (const std::string &text : {result.summary["message"].get<std::string>(), result.log})
          {
            EXPECT_TRUE(holds(text, "the law \"faulty\" of structure \"disc\" fails in its stress"))
              << text;
            EXPECT_TRUE(holds(text, "the last good state is step ")) << text;
          }
      }
}

TEST(Verdict, WhatAWriterThrowsOnOneRankEndsTheRunOnAll)
{
  for (const std::string fault : {"throws_int", "throws_std"})
    {
      const Result result =
        run(disc,
            disc_with("{}") + "--set '/output=[{\"faulty_writer\": {\"fault\": \"" + fault +
              "\", \"rank\": 1}}]'",
            2);
      EXPECT_EQ(result.exit_code, 1) << result.output;
      ASSERT_TRUE(result.summary.is_object()) << result.output;
      EXPECT_EQ(result.summary["status"], "failed");
      EXPECT_EQ(result.summary["steps"], 2);
    }
}

TEST(Verdict, AFailureBeforeTheFirstStateLeavesASummary)
{
  // From the first evaluation on.
  for (const std::string fault : {"throws_std", "throws_incurable"})
    {
      const Result result = run(disc, disc_with("{\"fault\": \"" + fault + "\"}"));
      EXPECT_NE(result.exit_code, 0);
      if (result.exit_code == 2)
        continue;
      ASSERT_TRUE(result.summary.is_object()) << result.output;
      EXPECT_EQ(result.summary["status"], "failed");
      EXPECT_EQ(result.summary["steps"], 0);
    }
  // What enters cannot leave.
  const Result flux =
    run(disc, "--set '/domain/boundary={\"x_min\": {\"velocity\": {\"value\": [1, 0]}}}'");
  EXPECT_TRUE(flux.exit_code == 1 || flux.exit_code == 2) << flux.output;
  if (flux.exit_code == 1)
    {
      EXPECT_EQ(flux.summary["status"], "failed");
      EXPECT_FALSE(holds(flux.output, "trying dt")) << "no shorter step helps";
    }
}

TEST(Verdict, RetriesEnd)
{
  const Result result =
    run(disc,
        disc_with("{\"fault\": \"throws_std\", \"start\": 10}") + "--set /time/step=5e-324 "
                                                                  "--set /time/end=1e-322");
  EXPECT_NE(result.exit_code, 0) << result.output;
}

// One step so long that the middle of a disc is turned over: dt times the rate of strain is 1.6
// there.
TEST(Verdict, ABodyThatFoldsIsSaid)
{
  const TemporaryFolder folder;
  const std::string file = folder.write("case.json", R"j({
  "dimension": 2,
  "domain": { "cells": [16, 16], "periodic": ["x", "y"] },
  "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.001, "linear_solver": "direct",
    "initial_velocity": ["2.5*sin(2*pi*x)*cos(2*pi*y)", "-2.5*cos(2*pi*x)*sin(2*pi*y)"] } },
  "structures": [ { "hyperelastic": { "name": "body",
    "mesh": { "disc": { "centre": [0.5, 0.5], "radius": 0.2, "rings": 5 } },
    "law": { "neo_hookean": { "shear_modulus": 1e-6 } } } } ],
  "time": { "step": 0.1, "end": 0.1, "integrator": { "fe_be": {} } }
})j");
  const Result result    = run(file, "");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(result.warned("folded")) << result.output;
}

TEST(Verdict, DoubtfulGeometryIsSaid)
{
  const std::string rest = disc_with("{}") + "--set /time/end=0.02 ";
  const auto centred     = [&](const std::string &x) {
    return rest + "--set '/structures/0/hyperelastic/initial_position=[\"s1+" + x + "\", \"s2\"]' ";
  };
  EXPECT_TRUE(run(disc, centred("0.23")).warned("near_wall"));
  EXPECT_FALSE(run(disc, centred("0")).warned("near_wall"));
  EXPECT_TRUE(run(disc, rest + "--set /domain/cells=[32,32]").warned("long_elements"));
  const Result folded =
    run(disc,
        rest + "--set '/structures/0/hyperelastic/initial_position=[\"0.4+abs(s1-0.5)\", \"s2\"]'");
  EXPECT_EQ(folded.exit_code, 2);
  EXPECT_NE(folded.output.find("/initial_position: fl"), std::string::npos) << folded.output;
  const Result flat =
    run(disc,
        rest +
          "--set '/structures/0/hyperelastic/initial_position=[\"s1\", \"0.5+0.02*(s2-0.5)\"]'");
  EXPECT_TRUE(flat.warned("element_shape"));
  const Result two = run(
    disc,
    rest +
      "--set '/structures=[{\"hyperelastic\": {\"name\": \"a\", \"mesh\": {\"disc\": {\"centre\":"
      " [0.4, 0.5], \"radius\": 0.2, \"rings\": 4}}, \"law\": {\"faulty\": {}}}}, "
      "{\"hyperelastic\": {\"name\": \"b\", \"mesh\": {\"disc\": {\"centre\": [0.6, 0.5], "
      "\"radius\": 0.2, \"rings\": 4}}, \"law\": {\"faulty\": {}}}}]'");
  EXPECT_TRUE(two.warned("overlap")) << two.output;
}
