// SPDX-License-Identifier: LGPL-2.1-or-later
// Rates in space and time for decaying Taylor-Green vortices in a periodic box, without structures.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
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
    std::string integrator;
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
    set("/constants/nu", run.viscosity);
    set("/fluid/navier_stokes/viscosity", run.viscosity);
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
    std::printf("%s%s, %u^2 cells, dt = %g: |u| %.3e  |grad u| %.3e  |p| %.3e, "
                "rates %.2f %.2f %.2f\n",
                fine.integrator.c_str(),
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
      const Errors found = rates({n, .005, "midpoint", .01}, {2 * n, .005, "midpoint", .01});
      EXPECT_NEAR(found[0], 3, .1);
      EXPECT_NEAR(found[1], 2, .1);
      EXPECT_NEAR(found[2], 2, .1);
    }
}

// In a stream convection, too, has an error in time; on its own that of the vortices is a gradient.
// The pressure of the stream comes down from above.

TEST(TaylorGreen, SecondOrderInTime)
{
  for (const bool stream : {false, true})
    {
      const Errors found =
        rates({32, .025, "midpoint", .05, stream}, {32, .0125, "midpoint", .05, stream});
      EXPECT_NEAR(found[0], 2, .1);
      EXPECT_NEAR(found[2], 2, stream ? .25 : .1);
    }
}

TEST(TaylorGreen, BackwardEulerIsOfFirstOrder)
{
  {
    const double dt = .005;
    // Alone, velocity and pressure; in a stream from below, as the error is not small.
    const Errors alone = rates({16, .025, "fe_be"}, {16, .0125, "fe_be"});
    EXPECT_NEAR(alone[0], 1, .1);
    EXPECT_NEAR(alone[2], 1, .15);
    EXPECT_NEAR(rates({16, dt, "fe_be", .05, true}, {16, dt / 2, "fe_be", .05, true})[0], 1, .15);
  }
}

TEST(TaylorGreen, WithoutStructuresTheSchemesOfEachOrderAreOne)
{
  {
    const Errors euler = errors({8, .05, "fe_be"}), midpoint = errors({8, .05, "midpoint"});
    for (const std::string scheme : {"lagged_be", "be_be"})
      EXPECT_EQ(errors({8, .05, scheme}), euler) << scheme;
    EXPECT_EQ(errors({8, .05, "lagged_midpoint"}), midpoint);
  }
}

TEST(TaylorGreen, AMeshTooCoarseForTheFlowIsSaid)
{
  // A stream with vortices of two cells and a cell Reynolds number of 1e4: the energy falls as it
  // should while the momentum of a periodic box is lost.
  for (const std::string viscosity : {"0.01", "1e-5"})
    {
      const TemporaryFolder folder;
      const RunResult result = run_host(
        shell_quoted(FEIB_SOURCE "/cases/taylor_green/case.json") + " --output " +
        shell_quoted(folder / "results") +
        " --set /output=[] --set /domain/cells=[8,8] --set /constants/U=1 --set /constants/V=0.5"
        " --set /constants/nu=" +
        viscosity + " --set /fluid/navier_stokes/viscosity=" + viscosity +
        " --set /time/step=0.025 --set /time/end=3");
      ASSERT_EQ(result.exit_code, 0) << result.output;
      const Json summary = read_json(folder / "results/summary.json");
      if (viscosity == "0.01")
        EXPECT_EQ(summary["status"], "completed") << result.output;
      else
        {
          EXPECT_EQ(summary["status"], "completed_with_warnings") << result.output;
          std::map<std::string, double> worst;
          for (const auto &warning : summary["warnings"])
            worst[warning["kind"]] = warning["worst"];
          EXPECT_EQ(worst.size(), 2u);
          EXPECT_GT(worst["momentum"], .1);
          EXPECT_GT(worst["resolution"], .4);
        }
    }
}
