// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces on structures: energies and momenta close under every scheme, bodies are held, moved,
// bent and pulled as theory says.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace feib::testing;

namespace
{
  const std::vector<std::string> schemes = {"fe_be",
                                            "be_be",
                                            "lagged_be",
                                            "midpoint",
                                            "lagged_midpoint"};

  /// A heavy disc in a box.
  std::string
  disc(const std::string &forces, const std::string &more = "")
  {
    return R"j({ "dimension": 2, "domain": { "cells": [8, 8], "periodic": ["x", "y"] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1 } },
      "structures": [ { "hyperelastic": { "name": "body",
        "mesh": { "disc": { "centre": [0.5, 0.5], "radius": 0.2, "rings": 6 } },
        "law": { "neo_hookean": { "shear_modulus": 2, "stress_free": true } },
        "forces": )j" +
           forces + more + R"j( } } ],
      "time": { "step": 0.005, "end": 0.1 },
      "output": [ { "ledger_csv": {} } ] })j";
  }

  const std::string heavy = R"(, "excess_density": 1)";
} // namespace


/// Of springs that move, dampers, weight, dead and follower loads.
TEST(Forces, EnergiesCloseUnderEveryScheme)
{
  struct Example
  {
    std::string forces, more;
  };
  for (
    const Example &example :
    {Example{R"j([{"tether": {"stiffness": 200, "damping": 1, "on": {"where": "s1 < 0.5"},
                     "target": ["s1 + 0.1*sin(20*t)", "s2 - 0.05*t"],
                     "target_velocity": ["2*cos(20*t)", -0.05]}}])j",
             heavy},
     Example{R"j([{"gravity": {"acceleration": ["sin(30*t)", -3]}}])j", heavy},
     Example{R"j([{"traction": {"force": ["5*t", 1], "on": {"boundary": true}}}])j", ""},
     Example{
       R"j([{"traction": {"pressure": "2 + 10*t", "on": {"boundary": true, "where": "s1 > 0.5"}}},
                     {"tether": {"stiffness": 50}}])j",
       ""},
     Example{R"j([{"gravity": {"acceleration": [0, -3]}}])j",
             heavy + R"(, "face_quadrature": {"gauss": {}})"}})
    for (const std::string &scheme : schemes)
      {
        SCOPED_TRACE(scheme + ", " + example.forces);
        const CaseRun result = run_text(disc(example.forces, example.more), scheme_setting(scheme));
        double scale         = 0;
        for (const char *column : {"kinetic", "dissipated", "inelastic", "potential"})
          scale = std::max(scale, std::abs(result.ledger.at(column).back()));
        EXPECT_GT(scale, 1e-6);
        for (const double closure : result.ledger.at("closure"))
          EXPECT_LT(std::abs(closure), 1e-7 * scale);
        EXPECT_LT(std::abs(result.ledger.at("unexplained").back()), 1e-3 * scale);
        EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
      }
}


/// With no walls, what forces give is the momentum: the weight times t.
TEST(Forces, WeightIsTheMomentumOfAPeriodicBox)
{
  const std::string gravity = R"j([{"gravity": {"acceleration": [0.5, -3]}}])j";
  for (const auto &[density, sign] :
       std::map<std::string, double>{{"1", 1.}, {"0", 0.}, {"-0.5", -1.}})
    {
      SCOPED_TRACE(density);
      const CaseRun result = run_text(disc(gravity, ", \"excess_density\": " + density));
      const double t       = result.ledger.at("time").back();
      const double measure = result.ledger.at("measure_body")[0];
      const double mass    = std::stod(density) * measure;
      EXPECT_NEAR(result.ledger.at("momentum_x").back(),
                  .5 * mass * t,
                  1e-6 * std::abs(mass) + 1e-20);
      EXPECT_NEAR(result.ledger.at("momentum_y").back(),
                  -3 * mass * t,
                  1e-6 * std::abs(mass) + 1e-20);
      const double fallen =
        result.ledger.at("centroid_y_body")[0] - result.ledger.at("centroid_y_body").back();
      if (sign == 0)
        {
          EXPECT_LT(result.ledger.at("largest_velocity").back(), 1e-12);
        }
      else
        EXPECT_GT(sign * fallen, 1e-4);
      EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
    }
}


/// A disc in a stream, on springs so stiff that an explicit scheme would need steps a hundred times
/// smaller: the force does not depend on them, and the disc stays where it is.
TEST(Forces, StiffSpringsHoldABodyInAStream)
{
  const std::string stream = R"j({ "dimension": 2, "constants": {"dt": 0.02},
      "domain": { "cells": [32, 32], "boundary": { "x_min": {"velocity": {"value": ["min(1,2*t)", 0]}},
        "x_max": {"outflow": {}}, "y_min": {"free_slip": {}}, "y_max": {"free_slip": {}} } },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1 } },
      "structures": [ { "hyperelastic": { "name": "body",
        "mesh": { "disc": { "centre": [0.4, 0.5], "radius": 0.1, "rings": 3 } },
        "law": { "neo_hookean": { "shear_modulus": 10, "stress_free": true } },
        "forces": [ { "tether": { "stiffness": 1, "damping": 1 } } ] } } ],
      "time": { "step": 0.02, "end": 1.6 },
      "output": [ { "ledger_csv": {} } ] })j";
  for (const std::string scheme : {"lagged_be", "lagged_midpoint"})
    {
      SCOPED_TRACE(scheme);
      std::vector<double> drag, displacement;
      for (const double stiffness : {1e4, 4e4, 1.6e5, 2e6})
        {
          const std::string tether = "/structures/0/hyperelastic/forces/0/tether/";
          const CaseRun result     = run_text(stream,
                                          scheme_setting(scheme) + " --set " + tether +
                                            "stiffness=" + std::to_string(stiffness) + " --set " +
                                            tether + "damping=" + std::to_string(.01 * stiffness));
          EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
          drag.push_back(-result.ledger.at("force_x_body_tether").back());
          displacement.push_back(result.ledger.at("centroid_x_body").back() - .4);
          // Nothing else than the springs acts on the fluid.
          EXPECT_NEAR(result.ledger.at("force_x_body").back(), -drag.back(), 1e-6 * drag.back());
        }
      EXPECT_NEAR(drag.back(), 1.54, .02);
      for (unsigned int i = 0; i + 1 < drag.size(); ++i)
        EXPECT_LT(std::abs(displacement[i + 1]), .5 * std::abs(displacement[i]));
      EXPECT_LT(std::abs(drag[2] - drag[3]), .5 * std::abs(drag[0] - drag[3]));
      EXPECT_LT(std::abs(drag[2] - drag[3]), 2e-3 * drag[3]);
      EXPECT_LT(std::abs(displacement[3]), 1e-4);
    }
}


/// A part of the step that the host forecasts is stable for springs on a body, be its nodes many or
/// few, and in nodes of the fluid.
TEST(Forces, ForecastOfTheStepKnowsSprings)
{
  struct Example
  {
    std::string mesh, domain, velocity;
  };
  const std::string plane = R"({"cells": [8, 8], "periodic": ["x", "y"]})",
                    space = R"({"cells": [4, 4, 4], "periodic": ["x", "y", "z"]})",
                    wave  = R"j(["0.1*sin(2*pi*y)", 0])j",
                    waves = R"j(["0.1*sin(2*pi*y)", 0, "0.1*cos(4*pi*x)"])j";
  for (const Example &example :
       {Example{R"({"disc": {"centre": [0.5, 0.5], "radius": 0.2, "rings": 2}})", plane, wave},
        Example{R"({"disc": {"centre": [0.5, 0.5], "radius": 0.2, "rings": 8}})", plane, wave},
        Example{R"({"rectangle": {"lower": [0.25, 0.25], "upper": [0.75, 0.75], "cells": [4, 4]}})",
                plane,
                wave},
        Example{R"({"box": {"lower": [0.25, 0.25, 0.25], "upper": [0.75, 0.75, 0.75],
                            "cells": [2, 2, 2]}})",
                space,
                waves},
        Example{R"({"box": {"lower": [0.25, 0.25, 0.25], "upper": [0.75, 0.75, 0.75],
                            "cells": [4, 4, 4]}})",
                space,
                waves}})
    {
      SCOPED_TRACE(example.mesh);
      const std::string springs =
        R"({ "dimension": )" + std::string(example.domain == space ? "3" : "2") +
        R"(, "domain": )" + example.domain +
        R"(, "fluid": { "navier_stokes": { "density": 1, "viscosity": 1e-4,
             "initial_velocity": )" +
        example.velocity + R"( } },
        "structures": [ { "hyperelastic": { "name": "body", "mesh": )" +
        example.mesh + R"(, "law": { "neo_hookean": { "shear_modulus": 1e-6 } },
          "forces": [ { "tether": { "stiffness": 1e4 } } ] } } ],
        "time": { "step": 1e-4, "end": 1e-4, "energy_growth": 100,
          "integrator": { "midpoint": {} } },
        "output": [ { "ledger_csv": {} } ] })";
      const double limit = run_text(springs).summary["stability_limit"];
      EXPECT_LT(limit, .02);
      const auto largest_energy = [&](const double part) {
        const std::vector<double> energy =
          run_text(springs,
                   "--set /time/step=" + std::to_string(part * limit) +
                     " --set /time/end=" + std::to_string(part * limit * 80))
            .ledger.at("total_energy");
        return *std::max_element(energy.begin() + 40, energy.end()) / energy[0];
      };
      EXPECT_LT(largest_energy(.7), 2);
    }
}


/// Prescribed motion: nodes are where their targets are, to the tolerance of the springs.
TEST(Forces, TargetsMoveABody)
{
  const CaseRun result =
    run_text(disc(R"j([{"tether": {"stiffness": 1e6, "target": ["s1 + 0.1*t", "s2"]}}])j"),
             "--set " + shell_quoted(R"(/time/integrator={"lagged_be": {}})"));
  EXPECT_NEAR(result.ledger.at("centroid_x_body").back(), .51, 2e-5);
  EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
}


/// A ring on stiff springs whose targets stop at once swings on in a scheme that damps nothing,
/// faster than its steps follow, and the run says so; not in one that damps.
TEST(Forces, SwingsThatStepsDoNotFollowAreSaid)
{
  const std::string stopped = R"j({ "dimension": 2, "domain": { "cells": [16, 16] },
    "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.01 } },
    "structures": [ { "membrane": { "name": "ring",
      "mesh": { "closed_curve": { "length": 0.62831853, "elements": 10 } },
      "initial_position": ["0.4 + 0.1*cos(10*s1)", "0.5 + 0.1*sin(10*s1)"],
      "law": { "anisotropic_linear": { "stiffness": 1e-3 } },
      "forces": [ { "tether": { "stiffness": 1e4,
        "target": ["0.4 + 0.1*cos(10*s1) + 0.3*min(t, 0.203)", "0.5 + 0.1*sin(10*s1)"] } } ] } } ],
    "time": { "step": 0.01, "end": 0.6 },
    "output": [ { "ledger_csv": {} } ] })j";
  for (const std::string scheme : {"lagged_midpoint", "lagged_be"})
    {
      SCOPED_TRACE(scheme);
      const CaseRun result = run_text(stopped, scheme_setting(scheme));
      const auto &forces   = result.ledger.at("force_x_ring");
      double largest       = 0; // long after the targets have stopped
      for (unsigned int n = forces.size() * 3 / 4; n < forces.size(); ++n)
        largest = std::max(largest, std::abs(forces[n]));
      if (scheme == "lagged_be")
        {
          EXPECT_LT(largest, .05);
          EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
        }
      else
        {
          EXPECT_GT(largest, .5);
          EXPECT_TRUE(result.warned("unresolved_swing")) << result.summary["warnings"];
          EXPECT_TRUE(holds(result.log, "the force of \"ring")) << result.log;
        }
    }
}


/// A beam in a resting fluid, clamped at its left end, under a load at its right end: the
/// deflection F L^3/(3 B).
TEST(Forces, CantileverOfACurve)
{
  const auto deflection = [](const unsigned int n_elements) {
    const std::string n    = std::to_string(n_elements);
    const std::string text = R"j({ "dimension": 2, "domain": { "cells": [16, 16] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 1, "convection": "none",
                                    "tolerance": 1e-5 } },
      "structures": [ { "membrane": { "name": "beam",
        "mesh": { "open_curve": { "length": 0.6, "elements": )j" +
                             n + R"j( } },
        "initial_position": ["0.2 + s1", "0.5"],
        "law": { "saint_venant_kirchhoff": { "mu": 20 } },
        "forces": [
          { "bending": { "rigidity": 0.02 } },
          { "tether": { "stiffness": 1e7, "on": { "where": "s1 < 0.6*1.5/)j" +
                             n + R"j(" } } },
          { "traction": { "force": [0, -0.002], "on": { "boundary": true, "where": "s1 > 0.3" } } } ] } } ],
      "coupling": { "variational": {} },
      "time": { "step": 20, "end": 600, "integrator": {"lagged_be": {}} },
      "output": [ { "ledger_csv": {} } ] })j";
    const CaseRun result = run_text(text);
    // Held at two nodes, it is clamped half way between them: the angle at the second is free.
    const double length = .6 * (1 - .5 / n_elements);
    return (.5 - result.ledger.at("lower_y_beam").back()) /
           (.002 * std::pow(length, 3) / (3 * .02));
  };
  EXPECT_NEAR(deflection(12), 1, .005);
  EXPECT_NEAR(deflection(24), 1, .002);
}


/// A thick beam, clamped at an end, in a resting fluid hangs under its weight as a plane
/// incompressible body does, by quadratic elements of another program: 4.904 q/mu at its tip, q the
/// weight per area. Triangles are too stiff, to better than first order.
TEST(Forces, ThickCantilever)
{
  std::vector<double> errors;
  for (const unsigned int n : {4, 8})
    {
      const CaseRun result = run_text(R"j({ "dimension": 2,
      "domain": { "cells": [)j" + std::to_string(4 * n) +
                                      ", " + std::to_string(4 * n) + R"j(], "periodic": ["y"] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1, "convection": "none",
                                    "linear_solver": "direct" } },
      "structures": [ { "hyperelastic": { "name": "beam",
        "mesh": { "rectangle": { "lower": [0.15, 0.45], "upper": [0.85, 0.55], "cells": [)j" +
                                      std::to_string(7 * n) + ", " + std::to_string(n) + R"j(] } },
        "law": { "neo_hookean": { "shear_modulus": 10 } },
        "deviatoric": true, "volumetric_modulus": 10, "excess_density": 0.1,
        "forces": [
          { "tether": { "stiffness": 1e7, "on": { "where": "s1 < 0.2501" } } },
          { "gravity": { "acceleration": [0, -0.1224] } } ] } } ],
      "time": { "step": 10, "end": 150, "integrator": {"lagged_be": {}} },
      "output": [ { "ledger_csv": {} } ] })j");
      EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
      const double theory = 4.904 * .1 * .1224 / 10;
      errors.push_back((.45 - result.ledger.at("lower_y_beam").back()) / theory - 1);
    }
  EXPECT_NEAR(errors[0], -.15, .01);
  EXPECT_NEAR(errors[1], -.051, .005);
}


/// A ring whose rest length is that of the circle of its area relaxes from an ellipse to this
/// circle, with the energy pi B/R, to second order in the length of its segments.
TEST(Forces, RingWithBendingBecomesTheCircle)
{
  const double R = std::sqrt(.06), B = .1, pi = std::acos(-1.);
  std::vector<double> errors;
  for (const unsigned int n : {16, 32})
    {
      const CaseRun result =
        run_text(R"j({ "dimension": 2, "constants": { "R": )j" + std::to_string(R) +
                 R"j( }, "domain": { "cells": [16, 16] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1, "convection": "none" } },
      "structures": [ { "membrane": { "name": "ring",
        "mesh": { "closed_curve": { "length": )j" +
                 std::to_string(2 * pi * std::stod(std::to_string(R))) + R"j(, "elements": )j" +
                 std::to_string(n) + R"j( } },
        "initial_position": ["0.5 + 0.3*cos(s1/R)", "0.5 + 0.2*sin(s1/R)"],
        "law": { "saint_venant_kirchhoff": { "mu": 1 } },
        "forces": [ { "bending": { "rigidity": 0.1 } } ] } } ],
      "time": { "step": 0.02, "end": 1, "integrator": {"lagged_be": {}} },
      "output": [ { "ledger_csv": {} } ] })j");
      EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
      EXPECT_LT(result.summary["energy"]["largest_increase"], 0);
      const double longest = result.ledger.at("axis_1_ring").back();
      EXPECT_GT(result.ledger.at("axis_1_ring")[0], 1.4 * result.ledger.at("axis_2_ring")[0]);
      EXPECT_NEAR(result.ledger.at("axis_2_ring").back(), longest, 1e-4 * longest);
      errors.push_back(result.ledger.at("energy_ring_bending").back() / (pi * B / R) - 1);
      // The sum over n angles of 2 pi/n.
      const double exact = std::pow(n / pi * std::tan(pi / n), 2) - 1;
      EXPECT_NEAR(errors.back(), exact, 1e-4 * exact + 1e-6);
    }
  EXPECT_GT(errors[0] / errors[1], 3.9);
}


/// Bending does not know where a curve or a sheet across a periodic box begins.
TEST(Forces, BendingGoesAcrossAPeriodicBox)
{
  const auto wave = [](const unsigned int dim, const std::string &begin) {
    const std::string shift = "(s1 + " + begin + ")";
    const std::string y     = "0.5 + 0.05*sin(2*pi*" + shift + ")";
    return R"({ "dimension": )" + std::to_string(dim) + R"(, "domain": { "cells": )" +
           (dim == 2 ? R"([8, 8], "periodic": ["x"])" : R"([4, 4, 4], "periodic": ["x", "z"])") +
           R"( }, "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1 } },
      "structures": [ { "membrane": { "name": "sheet", "mesh": )" +
           (dim == 2 ? R"({ "open_curve": { "length": 1, "elements": 16 } })"
                     : R"({ "rectangle": { "upper": [1, 0, 1], "cells": [8, 4] } })") +
           R"(, "initial_position": ["s1", ")" + y + (dim == 2 ? R"("])" : R"(", "s3"])") +
           R"(, "law": { "neo_hookean": { "shear_modulus": 1e-6 } },
        "forces": [ { "bending": { "rigidity": 0.01 } } ] } } ],
      "time": { "step": 0.01, "end": 0.1, "integrator": { "lagged_midpoint": {} } },
      "output": [ { "ledger_csv": {} } ] })";
  };
  for (const unsigned int dim : {2, 3})
    {
      SCOPED_TRACE(dim);
      const CaseRun one = run_text(wave(dim, "0")), other = run_text(wave(dim, "0.25")),
                    two   = run_text(wave(dim, "0.25"), "", 2);
      const double energy = one.ledger.at("energy_sheet_bending")[0];
      EXPECT_GT(energy, 1e-3);
      EXPECT_NEAR(other.ledger.at("energy_sheet_bending")[0], energy, 1e-12 * energy);
      for (const char *const column : {"energy_sheet_bending", "kinetic"})
        for (const CaseRun *const run : {&other, &two})
          EXPECT_NEAR(run->ledger.at(column).back(), one.ledger.at(column).back(), 1e-8 * energy)
            << column;
      EXPECT_LT(one.ledger.at("energy_sheet_bending").back(), .99 * energy);
    }
}


/// Columns of the ledger are named by structure and force: another structure of that name would
/// have the same.
TEST(Forces, NamesOfTheLedgerAreUnique)
{
  const std::string text = R"j({ "dimension": 2, "domain": { "cells": [4, 4] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1 } },
      "structures": [
        { "hyperelastic": { "name": "body", "mesh": { "rectangle": { "lower": [0.2, 0.2], "upper": [0.4, 0.4], "cells": [2, 2] } },
            "law": { "neo_hookean": { "shear_modulus": 2 } }, "forces": [ { "tether": { "stiffness": 1 } } ] } },
        { "hyperelastic": { "name": "body_tether", "mesh": { "rectangle": { "lower": [0.6, 0.6], "upper": [0.8, 0.8], "cells": [2, 2] } },
            "law": { "neo_hookean": { "shear_modulus": 2 } } } } ],
      "time": { "step": 0.01, "end": 0.1 } })j";
  const TemporaryFolder folder;
  const RunResult result = run_host("--validate " + shell_quoted(folder.write("case.json", text)));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.output.find("found \"body_tether\" a second time"), std::string::npos)
    << result.output;
}


/// A heavy body that falls on another one and presses it to the bottom passes through neither, by
/// an explicit scheme within its limit and by an implicit one in steps twenty times as long; and
/// the balance of the energy closes.
TEST(Forces, ContactKeepsBodiesApart)
{
  const std::string discs =
    R"j({ "dimension": 2, "domain": { "upper": [0.8, 0.8], "cells": [8, 8] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.02, "convection": "none" } },
      "structures": [ { "hyperelastic": { "name": "discs",
        "mesh": { "parts": { "meshes": [
          { "name": "heavy", "mesh": { "disc": { "centre": [0.39, 0.55], "radius": 0.12, "rings": 3 } } },
          { "name": "neutral", "mesh": { "disc": { "centre": [0.41, 0.25], "radius": 0.12, "rings": 3 } } } ] } },
        "law": { "neo_hookean": { "shear_modulus": 3, "stress_free": true } },
        "excess_density": "s2 > 0.4 ? 1 : 0",
        "forces": [ { "gravity": { "acceleration": [0, -20] } },
                    { "contact": { "range": 0.08, "strength": 5 } } ] } } ],
      "time": { "step": 0.01, "end": 0.6 },
      "output": [ { "ledger_csv": {} } ] })j";
  const double dt =
    run_text(discs, "--set /time/step=1e-4 --set /time/end=1e-4 " + scheme_setting("fe_be"))
      .summary["stability_limit"];
  for (const auto &[scheme, step] :
       std::map<std::string, double>{{"fe_be", dt}, {"lagged_midpoint", 20 * dt}})
    {
      SCOPED_TRACE(scheme + ", " + std::to_string(step));
      const CaseRun result =
        run_text(discs, "--set /time/step=" + std::to_string(step) + " " + scheme_setting(scheme));
      // The limit of the start knows a gap of half of the range; the weight presses it closer.
      for (const auto &warning : result.summary["warnings"])
        EXPECT_TRUE(warning["kind"] == "step_limit" || warning["kind"] == "near_wall") << warning;
      EXPECT_EQ(result.summary["retries"], 0);
      double pressed = 0, scale = 0;
      for (const double energy : result.ledger.at("energy_discs_contact"))
        pressed = std::max(pressed, energy);
      EXPECT_GT(pressed, 1e-5);
      for (const char *column : {"kinetic", "dissipated", "potential"})
        scale = std::max(scale, std::abs(result.ledger.at(column).back()));
      for (const double closure : result.ledger.at("closure"))
        EXPECT_LT(std::abs(closure), 1e-7 * scale);
      // Between the bodies it is none in sum, until the lower one has come down to the wall.
      bool wall = false;
      for (unsigned int i = 0; i < result.ledger.at("time").size(); ++i)
        if (result.ledger.at("lower_y_discs")[i] < .09)
          wall = true;
        else
          {
            EXPECT_LT(std::abs(result.ledger.at("force_y_discs_contact")[i]), 1e-12);
          }
      EXPECT_TRUE(wall);
      EXPECT_GT(result.ledger.at("lower_y_discs").back(), 0);
    }
}
