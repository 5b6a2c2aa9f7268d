// SPDX-License-Identifier: LGPL-2.1-or-later
// What a run says of itself: nothing doubtful ends as "completed" alone, nothing hangs, and every
// failure leaves a summary, a line in the log, and its cause.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

namespace
{
  using namespace feib::testing;

  const std::string membrane = FEIB_SOURCE "/cases/elliptic_membrane/case.json",
                    disc     = FEIB_SOURCE "/cases/cavity_disc/case.json";

  /// With the faulty plugins, and without output unless the settings ask for some.
  CaseRun
  run(const std::string &file, const std::string &settings, const unsigned int ranks = 1)
  {
    return run_case(file,
                    "--plugin-path " + shell_quoted(FEIB_FAULTY) + " --set '/output=[]' " +
                      settings,
                    ranks);
  }

  /// Refused, failed or doubtful: anything but plain "completed".
  void
  expect_doubt(const CaseRun &result)
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
  const CaseRun result = run(disc, disc_with("{}"));
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
  const CaseRun relaxing =
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

// What long steps lose of an area or a volume is said, whatever the scheme and the structure.
TEST(Verdict, WhatTheTimeSchemeLosesIsSaid)
{
  const auto scheme = [](const std::string &name) {
    return "--set '/time/integrator={\"" + name +
           "\": {}}' --set /time/step=1 --set /time/end=2 --set ";
  };
  const std::string stiff = "/structures/0/membrane/law/anisotropic_linear/stiffness=10";
  for (const auto &[file, settings] : std::vector<std::pair<std::string, std::string>>{
         {membrane, scheme("lagged_be") + stiff + " --set /domain/cells=[8,8]"},
         {membrane, scheme("be_be") + stiff + " --set /domain/cells=[8,8]"},
         {membrane, scheme("lagged_midpoint") + stiff + " --set /domain/cells=[8,8]"},
         {FEIB_SOURCE "/cases/ellipsoid/case.json", scheme("lagged_be") + "/domain/cells=[4,4,4]"}})
    {
      const CaseRun result = run(file, settings);
      EXPECT_TRUE(result.exit_code == 1 || result.warned("measure")) << result.output;
      expect_doubt(result);
    }
}

namespace
{
  /// The largest of a column.
  double
  largest(const CaseRun &result, const std::string &column)
  {
    const auto &values = result.ledger.at(column);
    return *std::max_element(values.begin(), values.end());
  }

  const std::string with_ledger = " --set '/output=[{\"ledger_csv\": {}}]'";
} // namespace

// Vortices in and through outflows, rough for their mesh: the energy grows by no more than what
// comes in.
TEST(Verdict, VorticesAtOutflowsStayBounded)
{
  const TemporaryFolder folder;
  // Cells, velocities of a stream and of the vortex, and its place.
  const auto file = [&](const std::string &boundary,
                        const std::string &stream,
                        const double vortex,
                        const double x) {
    const std::string v = std::to_string(vortex), place = std::to_string(x),
                      bell = "*exp(-((x-" + place + ")^2+(y-0.5)^2)/0.04)";
    return folder.write("case.json",
                        R"j({ "dimension": 2, "domain": { "upper": [2, 1], "cells": [16, 8],
      "boundary": {)j" + boundary +
                          R"j(} }, "fluid": { "navier_stokes": { "density": 1, "viscosity": 1e-4,
      "initial_velocity": [")j" +
                          stream + "-" + v + "*(y-0.5)" + bell + "\", \"" + v + "*(x-" + place +
                          ")" + bell + R"j("] } },
      "time": { "step": 0.02, "end": 0.4, "integrator": { "lagged_be": {} } } })j");
  };
  const std::string open      = R"("x_max": {"outflow": {}})",
                    also_open = R"("x_min": {"outflow": {}}, )",
                    channel   = R"j("x_min": {"velocity": {"value": ["2*y*(1-y)", 0]
}
},
                      "y_min": {"free_slip": {}}, "y_max": {"free_slip": {}}, )j";
  const auto bounded          = [&](const std::string &name, const std::string &settings = "") {
    const CaseRun result = run(name, settings + with_ledger);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_LE(largest(result, "kinetic"),
              1.05 * result.ledger.at("kinetic")[0] + largest(result, "boundary_work"));
  };
  bounded(file(open, "0", 60, .5));                    // a vortex in the box
  bounded(file(channel + open, "2*y*(1-y)", 15, 1.5)); // one that leaves with a stream
  bounded(file(also_open + open, "0", 60, 1.9));       // one in an open face, and another
  bounded(file(open, "0", 60, 1.9),
          "--set '/fluid/navier_stokes/convective_form=\"skew_symmetric\"'");
  bounded(file(open, "0", 60, 1.9), "--set '/time/integrator={\"midpoint\": {}}'");
}

// A lid that starts at once, all else default: nothing is faster than the lid.
TEST(Verdict, ACavityOfDefaultsIsNotFasterThanItsLid)
{
  const TemporaryFolder folder;
  const auto check = [&](const std::string &dimension,
                         const std::string &cells,
                         const std::string &lid,
                         const std::string &viscosity,
                         const std::string &end) {
    const CaseRun result =
      run(folder.write("case.json",
                       "{\"dimension\": " + dimension + ", \"domain\": {\"cells\": " + cells +
                         ", \"boundary\": {\"y_max\": {\"velocity\": {\"value\": " + lid +
                         "}}}}, \"fluid\": {\"navier_stokes\": {\"density\": 1, \"viscosity\": " +
                         viscosity + "}}, \"time\": {\"step\": 0.05, \"end\": " + end +
                         ", \"control\": {\"adaptive\": {}}}}"),
          with_ledger);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_LE(largest(result, "largest_velocity"), 1.05) << cells << ", " << viscosity;
  };
  check("2", "[16, 16]", "[1, 0]", "1e-3", "3");
  check("2", "[16, 16]", "[-1, 0]", "5e-4", "3");
  check("2", "[8, 12]", "[1, 0]", "1e-3", "3");
  check("3", "[4, 4, 4]", "[1, 0, 0]", "1e-3", "0.5");
}

TEST(Verdict, ALawWhoseStressIsNotTheDerivativeOfItsEnergy)
{
  // Also when it becomes wrong while the run is under way.
  for (const std::string start : {"0", "30"})
    {
      const CaseRun result =
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

// Each step gains less than the part of the energy that ends a run.
TEST(Verdict, GrowthOfAStructureAddsUp)
{
  const auto grown = [](const std::string &step) {
    return run(disc,
               "--set '/domain/cells=[8,8]' --set '/time/integrator={\"fe_be\": {}}' --set "
               "'/structures/0/hyperelastic/law={\"neo_hookean\": {\"shear_modulus\": 20}}' --set "
               "'/structures/0/hyperelastic/mesh={\"disc\": {\"centre\": [0.6, 0.5], \"radius\": "
               "0.2, \"rings\": 3}}' --set /output=[] --set /time/end=0.2 --set "
               "/time/energy_growth=10 --set /time/step=" +
                 step);
  };
  const std::string gauss =
    " --set '/structures/0/hyperelastic/face_quadrature={\"gauss\": {\"points\": 2}}'";
  EXPECT_TRUE(grown("0.0088").warned("structure_growth"));
  EXPECT_FALSE(grown("0.0001").warned("structure_growth"));
  EXPECT_TRUE(grown("0.0088" + gauss).warned("structure_growth"));
}

// The load at Gauss points works on another velocity than the nodes move with.
TEST(Verdict, EnergyFromAQuadratureIsNotTheSchemes)
{
  const auto ended = [](const std::string &coupling, const std::string &more) {
    return run(disc,
               disc_with("{}") +
                 "--set '/structures/0/hyperelastic/law={\"kelvin_voigt\": {\"viscosity\": 1, "
                 "\"law\": {\"neo_hookean\": {\"shear_modulus\": 1}}}}' --set "
                 "'/structures/0/hyperelastic/face_quadrature={\"gauss\": {\"points\": 2}}' --set "
                 "/time/step=0.002 --set /time/end=0.02 --set '/coupling={\"" +
                 coupling + "\": {}}'" + more);
  };
  const CaseRun driven = ended("divergence_free", "");
  EXPECT_TRUE(driven.warned("driven_structure")) << driven.output;
  EXPECT_FALSE(driven.warned("structure_growth")) << driven.output;
  EXPECT_FALSE(driven.warned("unexplained_energy")) << driven.output;
  const CaseRun good = ended("variational", "");
  EXPECT_FALSE(good.warned("driven_structure")) << good.output;
  EXPECT_FALSE(good.warned("structure_growth")) << good.output;
}

TEST(Verdict, WhatALawThrowsEndsTheRunOnAllRanks)
{
  for (const std::string fault : {"throws_int", "throws_std", "throws_failure", "not_finite"})
    for (const unsigned int ranks : {1, 2})
      {
        const CaseRun result =
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
      const CaseRun result =
        run(disc,
            disc_with("{}") + "--set '/output=[{\"faulty_writer\": {\"fault\": \"" + fault +
              "\", \"start\": 2, \"rank\": 1}}]'",
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
      const CaseRun result = run(disc, disc_with("{\"fault\": \"" + fault + "\"}"));
      EXPECT_NE(result.exit_code, 0);
      if (result.exit_code == 2)
        continue;
      ASSERT_TRUE(result.summary.is_object()) << result.output;
      EXPECT_EQ(result.summary["status"], "failed");
      EXPECT_EQ(result.summary["steps"], 0);
    }
  // What enters cannot leave.
  const CaseRun flux =
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
  const CaseRun result =
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
  const CaseRun result   = run(file, "");
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
  // How long is too long is a matter of the coupling.
  const std::string finer = rest + "--set /domain/cells=[16,16] ";
  EXPECT_FALSE(run(disc, finer).warned("long_elements"));
  const CaseRun variational = run(disc, finer + "--set '/coupling={\"variational\": {}}'");
  EXPECT_TRUE(variational.warned("long_elements"));
  EXPECT_TRUE(
    holds(variational.output,
          "long, the smallest cells of the fluid are 0.0625: with this coupling an element "
          "may be at most 1 times as long; use a finer mesh of the structure"))
    << variational.output;
  const CaseRun folded =
    run(disc,
        rest + "--set '/structures/0/hyperelastic/initial_position=[\"0.4+abs(s1-0.5)\", \"s2\"]'");
  EXPECT_EQ(folded.exit_code, 2);
  EXPECT_NE(folded.output.find("/initial_position: fl"), std::string::npos) << folded.output;
  const CaseRun flat =
    run(disc,
        rest +
          "--set '/structures/0/hyperelastic/initial_position=[\"s1\", \"0.5+0.02*(s2-0.5)\"]'");
  EXPECT_TRUE(flat.warned("element_shape"));
  const CaseRun two = run(
    disc,
    rest +
      "--set '/structures=[{\"hyperelastic\": {\"name\": \"a\", \"mesh\": {\"disc\": {\"centre\":"
      " [0.4, 0.5], \"radius\": 0.2, \"rings\": 4}}, \"law\": {\"faulty\": {}}}}, "
      "{\"hyperelastic\": {\"name\": \"b\", \"mesh\": {\"disc\": {\"centre\": [0.6, 0.5], "
      "\"radius\": 0.2, \"rings\": 4}}, \"law\": {\"faulty\": {}}}}]'");
  EXPECT_TRUE(two.warned("overlap")) << two.output;
}

// The signal comes in the initial output, in the middle of the first step or of a later one, to one
// rank or to all.
TEST(Verdict, ASignalAtAnyMomentStopsTheRunInOrder)
{
  const auto law = [](const int start, const int rank, const int number) {
    return disc_with("{\"fault\": \"signals " + std::to_string(number) + "\", \"start\": " +
                     std::to_string(start) + ", \"rank\": " + std::to_string(rank) + "}");
  };
  const std::string at_start = disc_with("{}") + "--set '/output=[{\"faulty_writer\": {\"fault\": "
                                                 "\"signals 1\", \"rank\": 0}}]'";
  for (const auto &[settings, ranks] : std::vector<std::pair<std::string, unsigned int>>{
         {at_start, 1}, {law(40, -1, SIGUSR2), 1}, {law(45, 1, SIGXCPU), 2}})
    {
      const CaseRun result = run(disc, settings, ranks);
      EXPECT_EQ(result.exit_code, 1) << result.output;
      EXPECT_EQ(result.summary["status"], "stopped") << result.output;
      EXPECT_LT(result.summary["steps"], 20);
      EXPECT_TRUE(holds(result.log, "error: stopped by")) << result.log;
    }
}

// Who asks twice does not want to wait for the end of a step; XCPU comes every second by itself.
TEST(Verdict, ASecondSignalEndsTheRunAtOnce)
{
  const auto twice = [](const std::string &numbers) {
    const TemporaryFolder folder;
    return run_host(shell_quoted(disc) + " --plugin-path " + shell_quoted(FEIB_FAULTY) +
                    " --output " + shell_quoted(folder / "out") + " " +
                    disc_with("{\"fault\": \"signals " + numbers + "\", \"start\": 40}"));
  };
  const std::string usr2 = std::to_string(SIGUSR2), xcpu = std::to_string(SIGXCPU);
  for (const int second : {SIGUSR2, SIGTERM})
    {
      const RunResult result = twice(usr2 + " " + std::to_string(second));
      EXPECT_EQ(result.exit_code, 128 + second);
      EXPECT_TRUE(holds(result.output, "at once, the second one\n")) << result.output;
    }
  EXPECT_EQ(twice(xcpu + " " + xcpu).exit_code, 1);
}

// The system ends a program that writes beyond the limit of sizes, unless it minds the error
// itself.
TEST(Verdict, AFileBeyondTheLimitOfSizesIsNamed)
{
  for (const auto &[writer, file] :
       {std::pair{"vtu", "/fluid_0000"}, std::pair{"ledger_csv", "/checkpoints/"}})
    {
      const CaseRun result =
        run(disc,
            disc_with("{}") +
              "--set '/output=[{\"faulty_writer\": {\"fault\": \"limits_files\"}}, "
              "{\"" +
              writer + "\": {}}]'");
      EXPECT_EQ(result.exit_code, 1) << result.output;
      EXPECT_EQ(result.summary["status"], "failed");
      for (const std::string &words : {std::string(file), std::string("File too large")})
        EXPECT_TRUE(holds(result.summary["message"], words)) << result.summary["message"];
      const std::string message = result.summary["message"];
      EXPECT_EQ(message.find(file), message.rfind(file)) << "it is said once";
    }
}
