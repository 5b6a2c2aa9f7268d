// SPDX-License-Identifier: LGPL-2.1-or-later
// What runs start from, and to what time pressures belong.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <cmath>

namespace
{
  using namespace feib::testing;

  const std::string membrane = "elliptic_membrane", green = "taylor_green";

  /// Runs a case with a ledger and a probe at (0.3, 0.4), on 8 x 8 cells.
  CaseRun
  run(const std::string &name, const std::string &settings)
  {
    const CaseRun result =
      run_case(FEIB_SOURCE "/cases/" + name + "/case.json",
               "--set /domain/cells=[8,8] --set '/output=[{\"ledger_csv\": {}}, {\"probe\": "
               "{\"name\": \"p\", \"at\": {\"points\": {\"places\": [[0.3, 0.4]]}}}}]' " +
                 settings);
    if (result.exit_code != 0)
      throw std::runtime_error(result.output);
    return result;
  }
} // namespace


TEST(Start, FluidAndExcessMassShareTheMomentumGiven)
{
  // In a periodic box nothing is lost of it, and what is heavy hardly moves: beside a million times
  // the fluid's mass next to no kinetic energy is left, at the start and after steps of any scheme.
  for (const std::string scheme : {"lagged_be", "lagged_midpoint"})
    {
      const auto ledger =
        run(membrane,
            "--set '/domain/periodic=[\"x\", \"y\"]' --set /domain/boundary={} "
            "--set '/fluid/navier_stokes/initial_velocity=[0.2, 0]' "
            "--set /structures/0/membrane/excess_density=1e6 --set /time/step=0.01 "
            "--set /time/end=0.04 --set '/time/integrator={\"" +
              scheme + "\": {}}'")
          .ledger;
      EXPECT_NEAR(ledger.at("momentum_x")[0], .2, 1e-7);
      EXPECT_GT(ledger.at("kinetic")[0], 0);
      EXPECT_LT(ledger.at("kinetic")[0], .02);
      for (const double momentum : ledger.at("momentum_x"))
        EXPECT_NEAR(momentum, .2, 1e-6);
    }
}

TEST(Start, ABodyAtRestIsNotSweptAlong)
{
  const auto scheme = [](const std::string &name) {
    return " --set '/time/integrator={\"" + name + "\": {}}' ";
  };
  const std::string inflow =
    "--set '/domain/periodic=[]' --set '/domain/boundary={\"x_min\": {\"velocity\": "
    "{\"value\": [0.2, 0]}}, \"x_max\": {\"outflow\": {}}, \"y_min\": {\"velocity\": "
    "{\"value\": [0.2, 0]}}, \"y_max\": {\"velocity\": {\"value\": [0.2, 0]}}}'";
  const std::string lid =
    "--set '/domain/periodic=[]' --set '/domain/boundary={\"y_max\": {\"velocity\": "
    "{\"value\": [1, 0]}}}'";
  const std::string in_space =
    "--set '/domain/periodic=[]' --set /domain/cells=[4,4,4] --set '/domain/boundary={\"z_min\": "
    "{\"velocity\": {\"value\": [0, 0, 0.2]}}, \"z_max\": {\"outflow\": {}}}' "
    "--set '/output=[{\"ledger_csv\": {}}]'";
  for (const auto &[name, settings] : std::vector<std::pair<std::string, std::string>>{
         {membrane, inflow + scheme("lagged_midpoint")},
         {membrane, inflow + scheme("lagged_be")},
         {"cavity_disc", lid + scheme("lagged_midpoint")},
         {"ellipsoid", in_space + scheme("lagged_midpoint")}})
    {
      SCOPED_TRACE(name + settings);
      const bool body = name == "cavity_disc";
      const auto ledger =
        run(name,
            settings + "--set /structures/0/" + (body ? "hyperelastic" : "membrane") +
              "/excess_density=1e6 --set /time/step=0.001 --set /time/end=0.004")
          .ledger;
      // Nor does it shake: a velocity of its own, other than the fluid's, would alternate for ever.
      for (const double kinetic : ledger.at("kinetic"))
        EXPECT_LT(kinetic, .1);
    }
}

TEST(Start, ThePressureOfTheInitialState)
{
  // That of four vortices, as good as later, and at the same place.
  const auto probe   = run(green, "--set /time/end=0.05 --set /domain/cells=[32,32]").probe;
  const double exact = (std::cos(4 * std::acos(-1) * .3) + std::cos(4 * std::acos(-1) * .4)) / 4;
  EXPECT_NEAR(probe.at("pressure")[0], exact, 5e-3);
}

TEST(Start, ThePressureOfAnAcceleratedBox)
{
  // Walls that set out together, and a body force: all fluid is accelerated by 1 along x.
  const auto pressure =
    run(green,
        "--set '/domain/periodic=[]' --set '/domain/boundary={\"x_min\": {\"velocity\": "
        "{\"value\": [\"t\", 0]}}, \"x_max\": {\"velocity\": {\"value\": [\"t\", 0]}}, "
        "\"y_min\": {\"velocity\": {\"value\": [\"t\", 0]}}, \"y_max\": {\"velocity\": "
        "{\"value\": [\"t\", 0]}}}' --set '/fluid/navier_stokes/initial_velocity=[0, 0]' "
        "--set '/fluid/navier_stokes/body_force=[3, 5]' --set /fluid/navier_stokes/density=2 "
        "--set /time/end=0.05")
      .probe.at("pressure");
  // rho du/dt = f - grad p
  for (const double p : pressure)
    EXPECT_NEAR(p, (3 - 2) * (.3 - .5) + 5 * (.4 - .5), 1e-5);
}

TEST(Pressure, OfTheEndOfAStepIsKeptOverChangesOfTheMesh)
{
  // The mesh changes after every second step; half a step changes the pressure by a fifth.
  const std::string settings =
    "--set /domain/cells=[16,16] --set /time/step=0.05 --set /constants/nu=0.05 "
    "--set /fluid/navier_stokes/viscosity=0.05 ";
  const auto fixed = run(green, settings).probe.at("pressure"),
             moving =
               run(green,
                   settings + "--set '/refinement={\"error_indicator\": {\"maximum_level\": 1, "
                              "\"interval\": 1}}'")
                 .probe.at("pressure");
  ASSERT_EQ(fixed.size(), moving.size());
  for (unsigned int n = 3; n < fixed.size(); ++n)
    EXPECT_NEAR(moving[n], fixed[n], .1 * std::abs(fixed[n]));
}

TEST(Pressure, OfAStepThatFailedLeavesNoTrace)
{
  // Far beyond the limit of the explicit scheme: with two first steps that fail, and without.
  const auto with_step = [](const std::string &step) {
    return run(membrane,
               "--set /structures/0/membrane/law/anisotropic_linear/stiffness=400 "
               "--set /time/end=0.005 --set /time/step=" +
                 step);
  };
  const auto failed = with_step("0.005"), good = with_step("0.00125");
  const auto &p = failed.probe.at("pressure"), &expected = good.probe.at("pressure");
  ASSERT_EQ(p.size(), expected.size());
  for (unsigned int n = 0; n < 4; ++n)
    {
      EXPECT_NEAR(failed.ledger.at("time")[n], good.ledger.at("time")[n], 1e-15);
      EXPECT_NEAR(p[n], expected[n], 1e-9 * std::abs(expected[n]));
    }
}

TEST(Pressure, DoesNotAlternateAfterAnImpulsiveStart)
{
  // A lid that starts at once leaves velocities that midpoint schemes do not damp; the pressures
  // solved for then alternate from step to step.
  const auto pressure =
    run("lid_driven_cavity",
        "--set /domain/boundary/y_max/velocity/value=[1,0] --set /fluid/navier_stokes/viscosity=1 "
        "--set /time/step=1 --set /time/end=12 --set '/time/integrator={\"midpoint\": {}}'")
      .probe.at("pressure");
  for (unsigned int n = 3; n + 2 < pressure.size(); ++n)
    EXPECT_LT(std::abs(pressure[n] - 2 * pressure[n + 1] + pressure[n + 2]) / 4,
              .005 * std::abs(pressure.back()));
}
