// SPDX-License-Identifier: LGPL-2.1-or-later
// Conditions on the faces of the box against exact solutions, and what the ledger says of faces.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace feib::testing;

namespace
{
  std::string
  set(const std::string &pointer, const std::string &value)
  {
    return " --set " + shell_quoted("/" + pointer + "=" + value);
  }

  double
  last(const CaseRun &run, const std::string &column)
  {
    return run.ledger.at(column).back();
  }

  /// A channel of length 2 and height 1, with these conditions at its ends.
  std::string
  channel(const std::string &in, const std::string &out, const std::string &more = "")
  {
    return R"j({ "dimension": 2, "domain": { "upper": [2, 1], "cells": [4, 4],
        "boundary": { "x_min": )j" +
           in + R"j(, "x_max": )j" + out + R"j( } },
      "fluid": { "navier_stokes": { "density": 2, "viscosity": 0.1, "tolerance": 1e-11 } },
      "time": { "step": 20, "end": 200, "integrator": { "fe_be": {} } },
      "output": [ { "ledger_csv": {} } ])j" +
           more + "}";
  }

  const std::string viscous_form = "fluid/navier_stokes/viscous_form";
} // namespace


/// Driven by a pressure, a flux or a traction, in both viscous forms.
TEST(Boundary, PoiseuilleFlowIsExact)
{
  const std::string exact = R"j(, "exact": { "velocity": ["5*y*(1-y)", 0], "pressure": "2-x" })j";
  const std::string out   = R"j({ "pressure": { "value": 0 } })j";
  struct Example
  {
    std::string in, out, form;
  };
  for (const Example &example :
       {Example{R"j({ "pressure": { "value": 2, "inflow": "static" } })j", out, "symmetric"},
        Example{R"j({ "pressure": { "value": 2, "inflow": "static" } })j", out, "laplacian"},
        Example{R"j({ "flux": { "value": "-5/6", "inflow": "static" } })j", out, "symmetric"},
        Example{R"j({ "pressure": { "value": 2, "direction": "free", "inflow": "static" } })j",
                R"j({ "outflow": {} })j",
                "laplacian"},
        Example{R"j({ "traction": { "value": [2, "-0.1*5*(1-2*y)"], "inflow": "static" } })j",
                R"j({ "traction": { "value": [0, "0.1*5*(1-2*y)"] } })j",
                "symmetric"}})
    for (const unsigned int ranks : {1, 2})
      {
        SCOPED_TRACE(example.in + " " + example.form);
        const CaseRun result = run_text(channel(example.in, example.out, exact),
                                        set(viscous_form, '"' + example.form + '"'),
                                        ranks);
        EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
        EXPECT_LT(result.summary["errors"]["velocity_l2"], 1e-9);
        EXPECT_LT(result.summary["errors"]["pressure_l2"], 1e-9);
        EXPECT_NEAR(last(result, "flux_x_max"), 5. / 6, 1e-9);
        EXPECT_NEAR(last(result, "flux_x_min"), -5. / 6, 1e-9);
        EXPECT_NEAR(last(result, "pressure_x_min"), 2, 1e-8);
        // Of walls and ends: the fluid gets force, torque and power from each.
        EXPECT_NEAR(last(result, "force_x_x_min"), 2, 1e-8);
        for (const char *wall : {"y_min", "y_max"})
          EXPECT_NEAR(last(result, std::string("force_x_") + wall), -1, 1e-8);
        EXPECT_NEAR(last(result, "force_y_y_min"), 2, 1e-8);
        EXPECT_NEAR(last(result, "force_y_y_max"), -2, 1e-8);
        // -int x p + y |force_x|. In the symmetric form the ends keep their fluid straight by a
        // shear, whose share of the corner counts for the wall.
        if (example.form == "laplacian")
          {
            EXPECT_NEAR(last(result, "torque_z_y_max"), -4. / 3 + 1, 1e-8);
          }
        EXPECT_NEAR(last(result, "power_x_min") + last(result, "power_x_max"), 5. / 3, 1e-8);
      }
}


/// The total pressure is that of the fluid at rest outside: in the channel it is lower.
TEST(Boundary, TotalPressureAtAnInflowIsThatOfFluidAtRest)
{
  const CaseRun result =
    run_text(channel(R"j({ "pressure": { "value": 2 } })j", R"j({ "pressure": { "value": 0 } })j"));
  const double flux = last(result, "flux_x_max");
  EXPECT_LT(last(result, "pressure_x_min"), 2 - 2. / 2 * flux * flux);
  EXPECT_GT(last(result, "pressure_x_min"), 2 - 3 * 2. / 2 * flux * flux);
  EXPECT_LT(flux, 5. / 6);
  // What comes in as kinetic energy is part of the work of the pressure.
  EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
  EXPECT_LT(result.summary["energy"]["largest_closure"], 1e-8 * last(result, "dissipated"));
}


/// A pulsating pressure (Womersley 1955, between planes): second order in time, 1e-4.
TEST(Boundary, PulsatingFlowIsWomersleys)
{
  // u = A/w [(1 - R) sin wt - I cos wt], R + i I = cosh(l (y - 1/2))/cosh(l/2), l^2 = i w/nu.
  const double w = 2 * M_PI, nu = .05, A = 1, a = std::sqrt(w / (2 * nu));
  const double C = std::cosh(a / 2) * std::cos(a / 2), S = std::sinh(a / 2) * std::sin(a / 2);
  std::ostringstream constants;
  constants << std::setprecision(17) << "{ \"w\": " << w << ", \"a\": " << a << ", \"A\": " << A
            << ", \"C\": " << C << ", \"S\": " << S << ", \"D\": " << C * C + S * S << " }";
  const std::string c = "cosh(a*(y-0.5))*cos(a*(y-0.5))", s = "sinh(a*(y-0.5))*sin(a*(y-0.5))";
  const std::string u =
    "A/w*((1-(" + c + "*C+" + s + "*S)/D)*sin(w*t)-(" + s + "*C-" + c + "*S)/D*cos(w*t))";
  const auto error = [&](const double dt) {
    const CaseRun result =
      run_text(R"j({ "dimension": 2, "constants": )j" + constants.str() +
                 R"j(, "domain": { "upper": [2, 1], "cells": [2, 48], "boundary": {
              "x_min": { "pressure": { "value": "2*A*cos(w*t)", "inflow": "static" } },
              "x_max": { "pressure": { "value": 0, "inflow": "static" } } } },
            "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.05, "tolerance": 1e-9,
              "initial_velocity": [")j" +
                 u + R"j(", 0] } },
            "time": { "step": 1, "end": 1.25 }, "output": [ { "ledger_csv": {} } ],
            "exact": { "velocity": [")j" +
                 u + R"j(", 0], "pressure": "(2-x)*A*cos(w*t)" } })j",
               set("time/step", std::to_string(dt)));
    EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
    return double(result.summary["errors"]["velocity_l2"]);
  };
  const double coarse = error(.025), fine = error(.0125), finest = error(.00625);
  EXPECT_GT(coarse / fine, 3.8);
  EXPECT_GT(fine / finest, 3.6);
  EXPECT_LT(finest, 1e-4 * .2); // the flow is about .16 in L2
}


/// A windkessel behind a channel with a given flux: the pressure of the circuit, to second order.
TEST(Boundary, WindkesselFollowsItsClosedForm)
{
  const auto error = [](const double dt) {
    const CaseRun result =
      run_text(channel(R"j({ "flux": { "value": "-(1+0.5*sin(t))" } })j",
                       R"j({ "windkessel": { "resistance": 0.5, "distal_resistance": 2,
                                        "capacitance": 1, "distal_pressure": 0.25 } })j"),
               set("time/integrator", R"({"midpoint":{}})") + set("time/step", std::to_string(dt)) +
                 set("time/end", "4"));
    EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
    double largest = 0;
    for (unsigned int i = 1; i < result.ledger.at("time").size(); ++i)
      {
        // Force and flux are averages over the step, those at its half. The pressure outside is
        // what the force says; inside the one of the spaces is not quite that.
        const double t = result.ledger.at("time")[i] - dt / 2, decay = std::exp(-t / 2);
        const double p = .25 + 2 * (1 - decay) + .4 * (.5 * std::sin(t) - std::cos(t) + decay);
        EXPECT_NEAR(result.ledger.at("flux_x_max")[i], 1 + .5 * std::sin(t), .1 * dt * dt);
        largest = std::max(largest,
                           std::abs(-result.ledger.at("force_x_x_max")[i] - p -
                                    .5 * (1 + .5 * std::sin(t))));
        EXPECT_NEAR(result.ledger.at("pressure_x_max")[i],
                    -result.ledger.at("force_x_x_max")[i],
                    .01);
      }
    return largest;
  };
  const double coarse = error(.2), fine = error(.1);
  EXPECT_LT(fine, 1.5e-3); // half of it is that of the flux at half steps
  EXPECT_GT(coarse / fine, 3.6);
}


/// Solutions made up, with the traction given on a face: the rates of the spaces, and of time.
class ManufacturedTraction : public ::testing::Test
{
public:
  static std::string
  example(const unsigned int dim, const unsigned int n, const std::string &time, const double step)
  {
    // u = (sin y, sin x) or (sin y, sin z, sin x) times T(t), p = sin(x + y + z) T.
    const std::string T   = time == "steady" ? "1" : "cos(6*t)";
    const std::string dT  = time == "steady" ? "0" : "(-6*sin(6*t))";
    const std::string sum = dim == 2 ? "(x+y)" : "(x+y+z)";
    const std::vector<std::string> next =
      dim == 2 ? std::vector<std::string>{"y", "x"} : std::vector<std::string>{"y", "z", "x"};
    std::string u, force, traction;
    for (unsigned int a = 0; a < dim; ++a)
      {
        const std::string x     = next[a];          // u_a = sin(x)
        const std::string &y    = next[x[0] - 'x']; // the component along x is sin(y)
        const std::string comma = a > 0 ? ", " : "";
        u += comma + "\"sin(" + x + ")*" + T + "\"";
        force += comma + "\"sin(" + x + ")*" + dT + "+cos(" + x + ")*sin(" + y + ")*(" + T +
                 ")^2+0.1*sin(" + x + ")*" + T + "+cos" + sum + "*" + T + "\"";
        // On x_max: mu (d_x u_a + d_a u_x) - p in the first.
        std::string shear = a == 0 ? "-sin" + sum : "0";
        if (x == "x")
          shear += "+0.1*cos(x)";
        if (std::string("xyz").substr(a, 1) == next[0])
          shear += "+0.1*cos(" + next[0] + ")";
        traction += comma + "\"(" + shear + ")*" + T + "\"";
      }
    const std::string cells = std::to_string(n) + ", " + std::to_string(n);
    return R"j({ "dimension": )j" + std::to_string(dim) + R"j(, "domain": { "cells": [)j" + cells +
           (dim == 3 ? ", " + std::to_string(n) : "") +
           R"j(], "boundary": { "all": { "velocity": { "value": [)j" + u +
           R"j(] } }, "x_max": { "traction": { "inflow": "static", "value": [)j" + traction +
           R"j(] } } } },
        "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1, "tolerance": 1e-9,
          "body_force": [)j" +
           force + R"j(], "initial_velocity": [)j" + u + R"j(] } },
        "time": { "step": )j" +
           std::to_string(step) + R"j(, "end": )j" + (time == "steady" ? "200" : "0.4") +
           R"j(, "integrator": { ")j" + (time == "steady" ? "fe_be" : "midpoint") +
           R"j(": {} } }, "output": [ { "ledger_csv": {} } ],
        "exact": { "velocity": [)j" +
           u + R"j(], "pressure": "sin)j" + sum + "*" + T + R"j(" } })j";
  }
};

TEST_F(ManufacturedTraction, RatesInSpace)
{
  for (const unsigned int dim : {2, 3})
    {
      SCOPED_TRACE(dim);
      std::array<nlohmann::json, 2> errors;
      for (unsigned int k = 0; k < 2; ++k)
        {
          const CaseRun result = run_text(example(dim, (dim == 2 ? 8 : 4) << k, "steady", 20.));
          EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
          errors[k] = result.summary["errors"];
        }
      for (const auto &[norm, rate] : std::map<std::string, double>{{"velocity_l2", 3},
                                                                    {"velocity_h1", 2},
                                                                    {"pressure_l2", 2}})
        EXPECT_GT(std::log2(double(errors[0][norm]) / double(errors[1][norm])), rate - .15) << norm;
    }
}

TEST_F(ManufacturedTraction, SecondOrderInTime)
{
  std::array<double, 3> errors;
  for (unsigned int k = 0; k < 3; ++k)
    errors[k] = run_text(example(2, 16, "moving", .1 / (1 << k))).summary["errors"]["velocity_l2"];
  EXPECT_GT(errors[0] / errors[1], 3.5);
  EXPECT_GT(errors[1] / errors[2], 3.5);
}


/// Walls, inflow and outflow on one face each, on a mesh that is refined there, in 2D and 3D: all
/// forces and the momentum that crosses are the change of the momentum.
TEST(Boundary, PartsOfFacesAndTheBalanceOfMomentum)
{
  const std::string box = R"j({ "dimension": 2, "domain": { "cells": [8, 8],
      "boundary": {
        "x_min": { "parts": { "list": [
          { "name": "inlet", "where": "abs(y - 0.25) < 0.125",
            "condition": { "velocity": { "value": ["1024*max(0,(y-0.125)*(0.375-y))/16", 0] } } },
          { "where": "abs(y - 0.75) < 0.125", "condition": { "pressure": { "value": 0 } } } ] } },
        "y_max": { "free_slip": {} } } },
    "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1, "convection": "none", "tolerance": 1e-11 } },
    "time": { "step": 0.05, "end": 0.2, "integrator": { "fe_be": {} } },
    "structures": [ { "membrane": { "name": "ring", "law": { "neo_hookean": { "shear_modulus": 0.01 } },
      "mesh": { "closed_curve": { "length": 1, "elements": 40 } },
      "initial_position": ["0.3 + 0.15*cos(2*pi*s1)", "0.4 + 0.15*sin(2*pi*s1)"] } } ],
    "refinement": { "immersed_cells": { "level": 1, "minimum_level": 0 } },
    "output": [ { "ledger_csv": {} } ] })j";
  for (const unsigned int ranks : {1, 2})
    {
      const CaseRun result = run_text(box, "", ranks);
      EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
      EXPECT_GT(last(result, "flux_x_min_1"), .1);
      EXPECT_NEAR(last(result, "flux_x_min_1"), -last(result, "flux_inlet"), 1e-8);
      for (unsigned int i = 1; i < result.ledger.at("time").size(); ++i)
        for (const char *axis : {"x", "y"})
          {
            double force = 0;
            for (const char *part :
                 {"inlet", "x_min_1", "x_min", "x_max", "y_min", "y_max", "ring"})
              force += result.ledger.at(std::string("force_") + axis + "_" + part)[i];
            const auto &momentum = result.ledger.at(std::string("momentum_") + axis);
            EXPECT_NEAR(force, (momentum[i] - momentum[i - 1]) / .05, 1e-7);
          }
      double power = 0;
      for (const char *part : {"inlet", "x_min_1", "x_min", "x_max", "y_min", "y_max"})
        power += last(result, std::string("power_") + part);
      const auto &work = result.ledger.at("boundary_work");
      EXPECT_NEAR(power, (work[4] - work[3]) / .05, 1e-9);
    }
}


/// A membrane that closes a channel, held by springs, under a pressure that pulsates: what passes
/// in a period is what its place has changed by, and nothing leaks. Other couplings leak.
TEST(Boundary, AClosedValveIsTight)
{
  const auto leak = [](const std::string &coupling) {
    const CaseRun result = run_text(
      R"j({ "dimension": 2, "domain": { "upper": [2, 1], "cells": [32, 16], "boundary": {
            "x_min": { "pressure": { "value": "50*(1+sin(4*pi*t))*ramp(t/0.3)" } },
            "x_max": { "pressure": { "value": 0 } } } },
          "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.02, "tolerance": 1e-9 } },
          "structures": [ { "membrane": { "name": "valve", "law": { "neo_hookean": { "shear_modulus": 100 } },
            "mesh": { "open_curve": { "length": 1, "elements": 32 } }, "initial_position": ["1.03", "s1"],
            "forces": [ { "tether": { "stiffness": 2000, "damping": 50 } } ] } } ],
          "time": { "step": 0.01, "end": 1, "integrator": { "lagged_midpoint": {} } },
          "output": [ { "ledger_csv": {} } ] })j",
      set("coupling", "{\"" + coupling + "\":{}}"));
    double passed = 0;
    for (unsigned int i = 51; i <= 100; ++i)
      passed += .01 * result.ledger.at("flux_x_max")[i];
    const auto &place = result.ledger.at("centroid_x_valve");
    return std::abs(passed - (place[100] - place[50]));
  };
  EXPECT_LT(leak("divergence_free"), 1e-7);
  EXPECT_GT(leak("variational"), 1e-3);
}


/// A static pressure lets kinetic energy in: through a narrow inlet without bound. That is said.
TEST(Boundary, AnInflowThatGrowsWithoutBoundIsNamed)
{
  const TemporaryFolder folder;
  const auto inlet = [](const std::string &inflow) {
    return R"j({ "dimension": 2, "domain": { "upper": [2, 1], "cells": [16, 8], "boundary": {
        "x_min": { "parts": { "list": [ { "where": "abs(y-0.5) < 0.19",
          "condition": { "pressure": { "value": "ramp(t/0.5)", "inflow": ")j" +
           inflow + R"j(" } } } ] } }, "x_max": { "pressure": { "value": 0 } } } },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.005 } },
      "time": { "step": 0.02, "end": 4, "control": { "adaptive": {} } },
      "output": [ { "ledger_csv": {} } ] })j";
  };
  const CaseRun grows = run_case(folder.write("static.json", inlet("static")), "");
  EXPECT_EQ(grows.exit_code, 1);
  EXPECT_NE(std::string(grows.summary["message"]).find("nothing bounds such an inflow"),
            std::string::npos)
    << grows.summary["message"];
  const CaseRun bounded = run_text(inlet("total"));
  // Bernoulli at the inlet and Borda-Carnot behind it, 3/8 of the height: u^2/2 - u^2 a (1 - a)
  // = 1.
  const double a = 3. / 8, u = 1 / std::sqrt(.5 - a * (1 - a));
  EXPECT_NEAR(last(bounded, "largest_velocity"), u, .1 * u);
}


TEST(Boundary, WhatLeavesThePressureUnknownIsRefused)
{
  const auto refused = [](const std::string &in, const std::string &out, const std::string &says) {
    const TemporaryFolder folder;
    const std::string file = folder.write("case.json", channel(in, out));
    for (const std::string mode : {" --validate", ""})
      {
        const RunResult result =
          run_host(shell_quoted(file) + mode + " --output " + shell_quoted(folder / "out"));
        EXPECT_EQ(result.exit_code, 2);
        EXPECT_NE(result.output.find(says), std::string::npos) << result.output;
        EXPECT_FALSE(std::filesystem::exists(folder / "out"));
      }
  };
  const std::string out = R"j({ "outflow": {} })j";
  refused(R"j({ "flux": { "value": -1 } })j",
          R"j({ "flux": { "value": 1 } })j",
          "/domain/boundary/x_max/flux: prescribes a flux, but no other face lets the pressure be "
          "known");
  refused(R"j({ "parts": { "list": [ { "where": "y > 2", "condition": { "outflow": {} } } ] } })j",
          out,
          "/domain/boundary/x_min/parts/list/0/condition/outflow: holds nowhere");
  refused(R"j({ "parts": { "list": [ { "where": "t > 2", "condition": { "outflow": {} } } ] } })j",
          out,
          "depends on the time");
  refused(
    R"j({ "parts": { "list": [ { "where": "y > .5", "name": "y_min", "condition": { "outflow": {} } } ] } })j",
    out,
    "two conditions called \"y_min\"");
  refused(R"j({ "pressure": { "value": "1/t" } })j",
          out,
          "/x_min/pressure/value: \"1/t\" is inf at");
  refused(R"j({ "flux": { "value": "-x" } })j", out, "/x_min/flux/value: the expression \"-x\"");
  refused(R"j({ "flux": { "value": "sqrt(-1-t)" } })j", out, "is nan at time 0");
  refused(R"j({ "windkessel": { "distal_resistance": 0, "capacitance": 1 } })j",
          out,
          "/x_min/windkessel/distal_resistance");
}
