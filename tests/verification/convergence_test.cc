// SPDX-License-Identifier: LGPL-2.1-or-later
// Rates of the immersed method on exact equilibria.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace
{
  using namespace feib::testing;
  using Json = nlohmann::json;

  Json
  run_case(const std::string &name, const std::string &settings)
  {
    const TemporaryFolder temporary;
    const RunResult run =
      run_host(shell_quoted(FEIB_SOURCE "/cases/" + name + "/case.json") + " --output " +
               shell_quoted(temporary / "results") + " --set /output=[] " + settings);
    if (run.exit_code != 0)
      throw std::runtime_error(run.output);
    return read_json(temporary / "results/summary.json");
  }

  std::string
  set(const std::string &pointer, const Json &value)
  {
    return " --set " + shell_quoted(pointer + "=" + value.dump());
  }
} // namespace

TEST(FibreRing, ErrorsAndRatesOfHeltaiAndCostanzo)
{
  // CMAME 229 (2012) 110: Q2/P1 fluid, ring of Q2 elements. Ours has P1 elements a quarter of a
  // cell.
  const double published[4][3] = {{2.006e-5, 1.959e-3, 6.716e-3},
                                  {3.694e-6, 7.447e-4, 2.475e-3},
                                  {5.767e-7, 2.251e-4, 8.747e-4},
                                  {1.061e-7, 8.246e-5, 3.140e-4}};
  const char *const names[3]   = {"velocity_l2", "velocity_h1", "pressure_l2"};
  double errors[4][3];
  for (unsigned int k = 0; k < 4; ++k)
    {
      const int n = 16 << k;
      const Json summary =
        run_case("fibre_ring",
                 set("/domain/cells", {n, n}) +
                   set("/structures/0/hyperelastic/mesh/ring/cells", {7 * n, n / 4}));
      for (unsigned int i = 0; i < 3; ++i)
        errors[k][i] = summary["errors"][names[i]];
      std::printf("%4d^2 cells: |u| %.3e (%.3e)  |grad u| %.3e (%.3e)  |p| %.3e (%.3e)\n",
                  n,
                  errors[k][0],
                  published[k][0],
                  errors[k][1],
                  published[k][1],
                  errors[k][2],
                  published[k][2]);
      for (unsigned int i = 0; i < 3; ++i)
        EXPECT_LT(errors[k][i], 1.2 * published[k][i]) << names[i] << " at " << n;
    }
  const double rates[3] = {2.5, 1.5, 1.5};
  for (unsigned int i = 0; i < 3; ++i)
    {
      const double rate = std::log2(errors[0][i] / errors[3][i]) / 3;
      std::printf("rate of %s: %.2f\n", names[i], rate);
      EXPECT_NEAR(rate, rates[i], .25);
    }
}

TEST(Patch, InThreeDimensions)
{
  const TemporaryFolder folder;
  const std::string file = folder.write("case.json", R"j({ "dimension": 3,
      "domain": { "cells": [4, 4, 4] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 1, "linear_solver": "direct" } },
      "structures": [ { "hyperelastic": { "name": "body",
        "mesh": { "box": { "lower": [0.25, 0.25, 0.25], "upper": [0.75, 0.75, 0.75], "cells": [4, 4, 4] } },
        "law": { "neo_hookean": { "shear_modulus": 1 } },
        "face_quadrature": { "gauss": {} } } } ],
      "time": { "step": 0.01, "end": 0.02, "integrator": { "fe_be": {} } },
      "exact": { "pressure": "(abs(x-0.5) < 0.25 && abs(y-0.5) < 0.25 && abs(z-0.5) < 0.25 ? 1 : 0) - 0.125" },
      "output": [] })j");
  for (const std::string coupling : {"variational", "divergence_free"})
    {
      SCOPED_TRACE(coupling);
      const std::string output = folder / coupling;
      const RunResult run =
        run_host(shell_quoted(file) + " --output " + shell_quoted(output) +
                 set("/coupling", {{coupling, Json::object()}}) +
                 (coupling == "divergence_free" ? set("/structures/0/hyperelastic/face_quadrature",
                                                      {{"vertex", Json::object()}})
                                                : ""));
      ASSERT_EQ(run.exit_code, 0) << run.output;
      const Json summary = read_json(output + "/summary.json");
      EXPECT_LT(summary["errors"]["velocity_l2"].get<double>(), 1e-14);
      EXPECT_LT(summary["errors"]["pressure_l2"].get<double>(), 1e-13);
    }
}

TEST(Patch, WithoutBoundaryFacesTheTransmissionTermIsMissing)
{
  const Json with = run_case("patch", "");
  EXPECT_LT(with["errors"]["velocity_l2"].get<double>(), 1e-14);
  EXPECT_LT(with["errors"]["pressure_l2"].get<double>(), 1e-13);
  const Json without = run_case("patch", set("/structures/0/hyperelastic/boundary_faces", false));
  // All force of a uniform stress sits on the boundary faces: without them p = 0 and the whole
  // exact pressure, of norm sqrt(1/4 - 1/16), is the error.
  EXPECT_NEAR(without["errors"]["pressure_l2"].get<double>(), std::sqrt(3. / 16), 1e-12);
}

TEST(MembraneCircle, RefiningTwiceAroundTheCurveBeatsTheUniformMeshOfAsManyUnknowns)
{
  const std::string steps = set("/time/step", 0.005) + set("/time/end", 0.005) +
                            set("/structures/0/membrane/mesh/closed_curve/elements", 1024);
  const Json refined =
    run_case("membrane_circle",
             steps + set("/domain/cells", {16, 16}) +
               set("/refinement", {{"immersed_cells", {{"level", 2}, {"buffer", 1}}}}));
  const auto unknowns = [](const Json &summary) {
    return summary["unknowns"]["velocity"].get<int>() + summary["unknowns"]["pressure"].get<int>();
  };
  // 8 + 3 unknowns per cell of a uniform mesh.
  const int n        = std::ceil(std::sqrt(unknowns(refined) / 11.));
  const Json uniform = run_case("membrane_circle", steps + set("/domain/cells", {n, n}));
  ASSERT_GE(unknowns(uniform), unknowns(refined));
  for (const std::string name : {"velocity_l2", "pressure_l2"})
    {
      std::printf("%s: refined %.3e with %d unknowns, uniform %d^2 %.3e with %d\n",
                  name.c_str(),
                  refined["errors"][name].get<double>(),
                  unknowns(refined),
                  n,
                  uniform["errors"][name].get<double>(),
                  unknowns(uniform));
      EXPECT_LT(refined["errors"][name].get<double>(), .9 * uniform["errors"][name].get<double>());
    }
}

TEST(MembraneCircle, PressureJumpsFindTheCurveAndBeatTheUniformMeshOfMoreUnknowns)
{
  const std::string steps = set("/time/step", 0.005) + set("/time/end", 0.06) +
                            set("/structures/0/membrane/mesh/closed_curve/elements", 1024);
  const Json adapted =
    run_case("membrane_circle",
             steps + set("/domain/cells", {16, 16}) +
               set("/refinement", {{"error_indicator", {{"maximum_level", 2}, {"interval", 1}}}}));
  const Json uniform = run_case("membrane_circle", steps + set("/domain/cells", {32, 32}));
  ASSERT_GT(uniform["cells"].get<int>(), adapted["cells"].get<int>());
  const std::vector<std::pair<std::string, double>> bounds = {{"velocity_l2", .5},
                                                              {"pressure_l2", .8}};
  for (const auto &[name, bound] : bounds)
    {
      std::printf("%s: adapted %.3e with %d cells, uniform %.3e with %d\n",
                  name.c_str(),
                  adapted["errors"][name].get<double>(),
                  adapted["cells"].get<int>(),
                  uniform["errors"][name].get<double>(),
                  uniform["cells"].get<int>());
      EXPECT_LT(adapted["errors"][name].get<double>(),
                bound * uniform["errors"][name].get<double>());
    }
}
