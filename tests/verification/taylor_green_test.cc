// SPDX-License-Identifier: LGPL-2.1-or-later
// Rates in space and time for decaying Taylor-Green vortices in a periodic box, without structures.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

namespace
{
  using namespace feib::testing;
  using Json = nlohmann::json;

  /// Velocity in L2 and H1, pressure in L2.
  using Errors = std::array<double, 3>;

  struct Run
  {
    unsigned int cells;
    double step;
    std::string integrator, convection = "linearised";
    double viscosity = .05;
    bool stream      = false;
  };

  Errors
  errors(const Run &run)
  {
    const TemporaryFolder folder;
    std::string arguments = shell_quoted(FEIB_SOURCE "/cases/taylor_green/case.json") +
                            " --output " + shell_quoted(folder / "results") + " --set /output=[]";
    const auto set = [&](const std::string &pointer, const Json &value) {
      arguments += " --set " + shell_quoted(pointer + "=" + value.dump());
    };
    set("/domain/cells", {run.cells, run.cells});
    set("/time/step", run.step);
    set("/time/integrator", {{run.integrator, Json::object()}});
    set("/constants/lag", run.integrator == "midpoint" ? run.step / 2 : 0.);
    set("/constants/nu", run.viscosity);
    set("/fluid/navier_stokes/viscosity", run.viscosity);
    set("/fluid/navier_stokes/convection", run.convection);
    set("/constants/U", run.stream ? 1. : 0.);
    set("/constants/V", run.stream ? .5 : 0.);
    const RunResult result = run_host(arguments);
    if (result.exit_code != 0)
      throw std::runtime_error(result.output);
    const Json found = read_json(folder / "results/summary.json")["errors"];
    return {found["velocity_l2"], found["velocity_h1"], found["pressure_l2"]};
  }

  /// Rates between two runs of which the second halves the cells or the step.
  Errors
  rates(const Run &coarse, const Run &fine)
  {
    const Errors first = errors(coarse), second = errors(fine);
    Errors result;
    for (unsigned int i = 0; i < 3; ++i)
      result[i] = std::log2(first[i] / second[i]);
    std::printf("%s, %s%s, %u^2 cells, dt = %g: |u| %.3e  |grad u| %.3e  |p| %.3e, "
                "rates %.2f %.2f %.2f\n",
                fine.integrator.c_str(),
                fine.convection.c_str(),
                fine.stream ? ", stream" : "",
                fine.cells,
                fine.step,
                second[0],
                second[1],
                second[2],
                result[0],
                result[1],
                result[2]);
    return result;
  }
} // namespace

TEST(TaylorGreen, RatesInSpace)
{
  for (const unsigned int n : {8, 16, 32})
    {
      const Errors found =
        rates({n, .005, "midpoint", "linearised", .01}, {2 * n, .005, "midpoint", "linearised", .01});
      EXPECT_NEAR(found[0], 3, .1);
      EXPECT_NEAR(found[1], 2, .1);
      EXPECT_NEAR(found[2], 2, .1);
    }
}

// In a stream convection, too, has an error in time; on its own that of the vortices is a gradient.

TEST(TaylorGreen, SecondOrderInTimeWithLinearisedConvection)
{
  for (const bool stream : {false, true})
    {
      const double dt = stream ? .01 : .05;
      EXPECT_NEAR(rates({32, dt, "midpoint", "linearised", .05, stream},
                        {32, dt / 2, "midpoint", "linearised", .05, stream})[0],
                  2,
                  .1);
    }
}

TEST(TaylorGreen, SecondOrderInTimeWithImplicitConvection)
{
  EXPECT_NEAR(rates({16, .1, "midpoint", "implicit", .05, true},
                    {16, .05, "midpoint", "implicit", .05, true})[0],
              2,
              .15);
}

TEST(TaylorGreen, BackwardEulerIsOfFirstOrder)
{
  for (const std::string convection : {"linearised", "implicit"})
    {
      const double dt = convection == "linearised" ? .005 : .0125;
      // Alone, velocity and pressure; in a stream from below, as the error is not small.
      const Errors alone = rates({16, .025, "fe_be", convection}, {16, .0125, "fe_be", convection});
      EXPECT_NEAR(alone[0], 1, .1);
      EXPECT_NEAR(alone[2], 1, .15);
      EXPECT_NEAR(rates({16, dt, "fe_be", convection, .05, true},
                        {16, dt / 2, "fe_be", convection, .05, true})[0],
                  1,
                  .15);
    }
}

TEST(TaylorGreen, WithoutStructuresTheSchemesOfEachOrderAreOne)
{
  for (const std::string convection : {"linearised", "implicit"})
    {
      const Errors euler    = errors({8, .05, "fe_be", convection}),
                   midpoint = errors({8, .05, "midpoint", convection});
      for (const std::string scheme : {"lagged_be", "be_be"})
        EXPECT_EQ(errors({8, .05, scheme, convection}), euler) << scheme;
      // Only the velocity: the exact pressure is not asked for at the half step.
      EXPECT_EQ(errors({8, .05, "lagged_midpoint", convection})[0], midpoint[0]);
    }
}
