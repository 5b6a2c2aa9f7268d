// SPDX-License-Identifier: LGPL-2.1-or-later
// Small cases that would look right and be wrong, of which the run or the check must say so; and
// some that are right, of which neither may say anything.
#include "support/run_case.h"

#include <gtest/gtest.h>

namespace
{
  using namespace feib::testing;

  /// A fluid of density 1 in a box, and what else stands in the case; one output.
  std::string
  text(const std::string &domain,
       const std::string &fluid,
       const std::string &rest,
       const std::string &output = R"j({ "ledger_csv": {} })j")
  {
    return R"j({ "dimension": 2, "domain": { )j" + domain +
           R"j( }, "fluid": { "navier_stokes": { "density": 1, )j" + fluid + " } }, " + rest +
           R"j(, "output": [ )j" + output + " ] }";
  }

  /// A structure of a kind and a name.
  std::string
  structure(const std::string &kind, const std::string &rest)
  {
    return R"j("structures": [ { ")j" + kind + R"j(": { "name": "s", )j" + rest + " } } ]";
  }

  const std::string still = R"j("viscosity": 0.1)j",
                    five  = R"j("time": { "step": 0.01, "end": 0.05 })j",
                    curve = R"j("mesh": { "closed_curve": { "length": 1, "elements": 40 } }, )j";

  /// Refused by the check and by the run, with these words.
  void
  expect_refused(const std::string &description, const std::string &words)
  {
    const TemporaryFolder folder;
    const std::string file = folder.write("case.json", description);
    for (const std::string mode : {"--validate ", "--output out "})
      {
        const RunResult result = run_host(mode + shell_quoted(file), 1, folder.path);
        EXPECT_EQ(result.exit_code, 2) << result.output;
        EXPECT_TRUE(holds(result.output, words)) << result.output;
        EXPECT_FALSE(std::filesystem::exists(folder / "out"));
      }
  }
} // namespace

TEST(Doubt, NodesOfALightBodyThatTakeMoreMassThanThereIs)
{
  const auto run = [](const std::string &rings) {
    return run_text(text(
      R"j("cells": [16, 16], "periodic": ["x"])j",
      still,
      structure("hyperelastic",
                R"j("mesh": { "disc": { "centre": [0.5, 0.5], "radius": 0.15, "rings": )j" + rings +
                  R"j( } }, "excess_density": -0.3,
             "law": { "neo_hookean": { "shear_modulus": 1, "stress_free": true } },
             "forces": [ { "gravity": { "acceleration": [0, -1] } } ])j") +
        R"j(, "time": { "step": 0.005, "end": 0.2, "integrator": { "lagged_midpoint": {} } })j"));
  };
  const CaseRun coarse = run("4"), fine = run("8");
  EXPECT_TRUE(coarse.warned("light_structure")) << coarse.log;
  EXPECT_EQ(fine.summary["status"], "completed") << fine.log;
  EXPECT_LT(fine.ledger.at("largest_velocity").back(), .02);
}

TEST(Doubt, APartOfAFaceIsTightBesideItsEdge)
{
  // The edges are at nodes, of which one is beyond them by round-off.
  const auto run = [](const std::string &where) {
    return run_text(text(
      R"j("upper": [2, 1], "cells": [20, 10], "boundary": { "x_min": { "parts": { "list": [ { "name": "hole",
             "where": ")j" +
        where +
        R"j(", "condition": { "flux": { "value": -1 } } } ] } }, "x_max": { "outflow": {} } })j",
      R"j("viscosity": 1, "convection": "none")j",
      R"j("time": { "step": 0.1, "end": 0.2, "integrator": { "lagged_be": {} } })j"));
  };
  for (const char *const where : {"abs(y - 0.5) < 0.2", "y > 0.3", "y <= 0.7"})
    {
      const CaseRun tight = run(where);
      EXPECT_NEAR(tight.ledger.at("flux_hole").back(), -1, 1e-6) << where;
      EXPECT_NEAR(tight.ledger.at("flux_x_max").back(), 1, 1e-6) << where;
      EXPECT_EQ(tight.summary["status"], "completed") << where << tight.log;
    }
  EXPECT_TRUE(run("y < 0.34").warned("parts"));
}

TEST(Doubt, APartIsTightAcrossASeamAndBesideAnInlet)
{
  const auto run =
    [](const std::string &more, const std::string &where, const std::string &condition) {
      return run_text(
        text(R"j("upper": [2, 1], "cells": [20, 10], )j" + more +
               R"j("boundary": { "x_min": { "parts": { "list": [ { "name": "hole", "where": ")j" +
               where + R"j(", "condition": )j" + condition +
               R"j( } ] } }, "x_max": { "outflow": {} } })j",
             R"j("viscosity": 1, "convection": "none")j",
             R"j("time": { "step": 0.1, "end": 0.2, "integrator": { "lagged_be": {} } })j"));
    };
  const std::string flux     = R"j({ "flux": { "value": -1 } })j",
                    velocity = R"j({ "velocity": { "value": [1, 0] } })j";
  const CaseRun seam         = run(R"j("periodic": ["y"], )j", "y < 0.3", flux);
  EXPECT_NEAR(seam.ledger.at("flux_x_max").back(), 1, 1e-6);
  EXPECT_EQ(seam.summary["status"], "completed") << seam.log;
  for (const char *const where : {"abs(y - 0.5) < 0.2", "y <= 0.7"})
    {
      const CaseRun inlet = run("", where, velocity);
      EXPECT_NEAR(inlet.ledger.at("flux_x_max").back(), -inlet.ledger.at("flux_hole").back(), 1e-9);
      EXPECT_EQ(inlet.summary["status"], "completed") << inlet.log;
    }
  EXPECT_TRUE(run("", "y < 0.34", velocity).warned("parts"));
}

TEST(Doubt, AUniformStreamIsNotRough)
{
  const CaseRun run =
    run_text(text(R"j("upper": [2, 1], "cells": [8, 4], "boundary": { "all": { "free_slip": {} },
           "x_min": { "velocity": { "value": ["1+0.1*sin(t)", 0] } }, "x_max": { "outflow": {} } })j",
                  R"j("viscosity": 0.001, "initial_velocity": [1, 0])j",
                  R"j("time": { "step": 0.1, "end": 1 })j"));
  EXPECT_EQ(run.summary["status"], "completed") << run.log;
}

TEST(Doubt, ACurveThatIsSqueezedSoftensWhenItIsStretched)
{
  const TemporaryFolder folder;
  for (const char *const law :
       {R"j({ "saint_venant_kirchhoff": { "mu": 1 } })j",
        R"j({ "neo_hookean": { "shear_modulus": 1, "stress_free": true } })j"})
    {
      const std::string file =
        folder.write("case.json",
                     text(R"j("cells": [16, 16])j",
                          still,
                          structure("membrane",
                                    curve + R"j("initial_position": [ "0.5+0.03*cos(2*pi*s1)",
                                      "0.5+0.03*sin(2*pi*s1)" ], "law": )j" +
                                      law) +
                            ", " + five));
      const RunResult result = run_host("--validate " + shell_quoted(file));
      EXPECT_EQ(result.exit_code, 0) << result.output;
    }
}

TEST(Doubt, AMembraneInOnePointIsRefused)
{
  expect_refused(text(R"j("cells": [8, 8])j",
                      still,
                      structure("membrane", curve + R"j("initial_position": ["0.5", "0.5"],
                                  "law": { "anisotropic_linear": { "stiffness": 1 } })j") +
                        ", " + five),
                 "/structures/0/membrane/initial_position: makes a point of element 0");
}

TEST(Doubt, NamesThatNoFileCanHaveAreRefused)
{
  expect_refused(text(R"j("cells": [8, 8])j",
                      still,
                      R"j("structures": [ { "membrane": { "name": ")j" + std::string(101, 'a') +
                        "\", " + curve +
                        R"j("initial_position": [ "0.5+0.2*cos(2*pi*s1)", "0.5+0.2*sin(2*pi*s1)" ],
                          "law": { "anisotropic_linear": { "stiffness": 1 } } } } ], )j" +
                        five),
                 "/structures/0/membrane/name: has 101 characters, at most 100 are allowed");
}

TEST(Doubt, APlaceThatTwoPartsHaveIsRefused)
{
  expect_refused(
    text(
      R"j("cells": [8, 8])j",
      still,
      structure("hyperelastic",
                R"j("mesh": { "parts": { "meshes": [
           { "name": "a", "mesh": { "disc": { "radius": 0.1, "rings": 2 } }, "initial_position": ["s1+0.3", "s2+0.3"] },
           { "name": "b", "mesh": { "disc": { "radius": 0.1, "rings": 2 } }, "initial_position": ["s1+0.7", "s2+0.7"] } ] } },
           "law": { "neo_hookean": { "shear_modulus": 1 } })j") +
        ", " + five,
      R"j({ "probe": { "name": "p", "at": { "structure": { "name": "s", "places": [[0, 0]] } } } })j"),
    "is (0 0), where several parts of the structure \"s\" have a reference place");
}

TEST(Doubt, AWindowBetweenTwoStepsHasNoStatistics)
{
  const CaseRun run = run_text(text(
    R"j("cells": [4, 4])j", still, five + R"j(, "statistics": { "from": 0.0301, "to": 0.0399 })j"));
  EXPECT_TRUE(run.warned("statistics"));
}

TEST(Doubt, APoleInTimeEndsTheRun)
{
  // Steps of 0.01 have their middle there; shorter ones would jump over it.
  const std::string
    ring = curve + R"j("initial_position": [ "0.5+0.2*cos(2*pi*s1)", "0.5+0.2*sin(2*pi*s1)" ], )j",
    law = R"j("law": { "anisotropic_linear": { "stiffness": 1 } })j", pole = "1/(t-0.025)";
  const TemporaryFolder folder;
  for (const std::string &description :
       {text(R"j("cells": [4, 4], "boundary": { "x_min": { "pressure": { "value": ")j" + pole +
               "\" } } }",
             still,
             five),
        text(R"j("cells": [4, 4])j", still + R"j(, "body_force": [0, ")j" + pole + "\"]", five),
        text(R"j("cells": [4, 4])j",
             still,
             structure("membrane",
                       ring + law + R"j(, "forces": [ { "traction": { "pressure": ")j" + pole +
                         "\" } } ]") +
               ", " + five),
        text(R"j("cells": [4, 4])j",
             still,
             structure("membrane",
                       ring + R"j("law": { "active_fibre": { "tension": "abs()j" + pole +
                         R"j()", )j" + law + " } }") +
               ", " + five)})
    {
      const CaseRun run = run_case(folder.write("case.json", description), "");
      EXPECT_EQ(run.exit_code, 1) << description << run.output;
      EXPECT_EQ(run.summary["status"], "failed");
      EXPECT_EQ(run.summary["retries"], 0);
      EXPECT_TRUE(holds(run.output, "time 0.025")) << run.output;
    }
}

TEST(Doubt, FactorsLargerThanExpectedGetMoreRoom)
{
  // Wide kernels couple so much that MUMPS, asked for the usual room, has too little.
  const CaseRun run =
    run_text(text(R"j("cells": [16, 16], "periodic": ["x", "y"])j",
                  R"j("viscosity": 0.1, "convection": "none", "linear_solver": "direct")j",
                  structure("membrane",
                            R"j("mesh": { "closed_curve": { "length": 1, "elements": 48 } },
           "initial_position": [ "0.5+0.3*cos(2*pi*s1)", "0.5+0.24*sin(2*pi*s1)" ],
           "law": { "anisotropic_linear": { "stiffness": 0.3 } }, "excess_density": 0.5)j") +
                    R"j(, "coupling": { "regularised_delta": { "kernel": "bspline_6" } },
           "time": { "step": 0.005, "end": 0.02, "integrator": { "lagged_be": {} } })j"));
  EXPECT_EQ(run.summary["retries"], 0) << run.log;
}
