// SPDX-License-Identifier: LGPL-2.1-or-later
// Forecast, monitor and control of time steps, as a user meets them.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <cmath>

namespace
{
  using namespace feib::testing;

  const std::string shell    = FEIB_SOURCE "/cases/elliptic_shell/case.json",
                    membrane = FEIB_SOURCE "/cases/elliptic_membrane/case.json",
                    disc     = FEIB_SOURCE "/cases/cavity_disc/case.json";

  CaseRun
  run(const std::string &file, const std::string &settings, const unsigned int ranks = 1)
  {
    return run_case(file, "--set '/output=[{\"ledger_csv\": {}}]' " + settings, ranks);
  }
} // namespace

TEST(StepControl, ForecastBeforeTheFirstStepAndTheSentenceInsteadOfNaN)
{
  const CaseRun result =
    run(membrane, "--set /domain/cells=[16,16] --set /time/step=0.05 --set /time/end=5");
  EXPECT_EQ(result.exit_code, 1);
  const std::string advice   = "dt = 0.05 exceeds the estimated limit ";
  const std::size_t forecast = result.output.find("warning: " + advice);
  ASSERT_NE(forecast, std::string::npos) << result.output;
  EXPECT_TRUE(holds(result.output.substr(forecast),
                    " of midpoint for structure \"membrane\"; use lagged_midpoint or dt <= "));
  const std::size_t stop = result.output.find("error: the energy ");
  ASSERT_NE(stop, std::string::npos) << result.output;
  EXPECT_LT(forecast, stop);
  EXPECT_TRUE(holds(result.output.substr(stop), " has grown by "));
  EXPECT_TRUE(holds(result.output.substr(stop), "use lagged_midpoint or dt <= "));
  for (const auto &[column, values] : result.ledger)
    for (const double value : values)
      EXPECT_TRUE(std::isfinite(value)) << column;

  // What it says it would take, it takes: the step of the advice runs.
  const std::string words = "use lagged_midpoint or dt <= ";
  const double step = std::stod(result.output.substr(result.output.find(words) + words.size()));
  EXPECT_GT(step, 1e-4);
  const CaseRun stable =
    run(membrane,
        "--set /domain/cells=[16,16] --set /time/end=0.3 --set /time/step=" + std::to_string(step));
  EXPECT_EQ(stable.exit_code, 0) << stable.output;
  EXPECT_FALSE(holds(stable.output, "exceeds"));
  EXPECT_LE(stable.summary["energy"]["largest_increase"].get<double>(), 0);
}

TEST(StepControl, LimitsFollowTheStructureInTheLedger)
{
  const CaseRun result = run(membrane, "--set /domain/cells=[16,16] --set /time/end=0.01");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const std::string column :
       {"h_x", "h_s_membrane", "longest_edge_membrane", "kappa_membrane", "dt_limit_membrane"})
    for (const double value : result.ledger.at(column))
      EXPECT_GT(value, 0) << column;
  EXPECT_DOUBLE_EQ(result.ledger.at("h_x").back(), 1. / 16);
  EXPECT_NEAR(result.ledger.at("kappa_membrane").back(), 1, 1e-12);
  EXPECT_GT(result.ledger.at("eta_membrane").back(), 0);
}

TEST(StepControl, AdaptiveRunFromAStepTenTimesTooLarge)
{
  const CaseRun result = run(shell,
                             "--set /domain/cells=[8,8] --set /time/step=0.02 --set /time/end=0.1 "
                             "--set '/time/control={\"adaptive\": {}}'");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NEAR(result.ledger.at("time").back(), .1, 1e-14);
  const auto &dt = result.ledger.at("dt"), &limit = result.ledger.at("dt_limit_shell"),
             &cfl = result.ledger.at("cfl");
  EXPECT_LT(dt[1], .01);
  double sum = 0;
  for (unsigned int i = 1; i < dt.size(); ++i)
    {
      sum += dt[i];
      EXPECT_LE(dt[i], .7 * limit[i - 1] * (1 + 1e-9));
      EXPECT_LE(cfl[i], .6); // 0.5 asked for, judged by the velocity before the step
      if (i > 1)
        {
          EXPECT_LE(dt[i], 1.5 * dt[i - 1] * (1 + 1e-9));
        }
    }
  EXPECT_NEAR(sum, .1, 1e-12);
  EXPECT_LE(result.summary["energy"]["largest_increase"].get<double>(), 0);
  EXPECT_EQ(result.summary["dt"]["largest"].get<double>(), *std::max_element(dt.begin(), dt.end()));
}

TEST(StepControl, ErrorEstimateOfTheSecondOrderSchemes)
{
  // A tighter tolerance takes smaller steps and comes closer.
  std::vector<double> steps, extents;
  for (const std::string tolerance : {"1e-4", "1e-5", "1e-6", "1e-8"})
    {
      const CaseRun result =
        run(membrane,
            "--set /domain/cells=[8,8] --set /time/step=0.01 --set /time/end=0.2 --set "
            "/fluid/navier_stokes/viscosity=0.1 "
            "--set '/time/integrator={\"lagged_midpoint\": {}}' "
            "--set '/time/control={\"adaptive\": {\"tolerance\": " +
              tolerance + ", \"cfl\": 10}}'");
      ASSERT_EQ(result.exit_code, 0) << result.output;
      const auto &errors = result.ledger.at("displacement_error");
      for (unsigned int i = 0; i < errors.size(); ++i)
        {
          EXPECT_LE(errors[i], std::stod(tolerance));
          if (i > 2) // known from the third step on, after rejected steps too
            {
              EXPECT_GT(errors[i], 0);
            }
        }
      steps.push_back(result.summary["steps"]);
      extents.push_back(result.summary["structures"][0]["extent"][0]);
    }
  for (unsigned int i = 0; i < 3; ++i)
    {
      std::cout << steps[i] << " steps, error of the width " << extents[i] - extents[3]
                << std::endl;
      EXPECT_LT(steps[i], steps[i + 1]);
    }
  EXPECT_LT(std::abs(extents[2] - extents[3]), .2 * std::abs(extents[0] - extents[3]));
}

TEST(StepControl, FailedStepsAreRetriedFromTheStateBefore)
{
  // Steps far too long for the explicit scheme invert elements of a law that forbids it.
  const std::string settings =
    "--set /domain/cells=[8,8] --set /domain/boundary={} --set /time/step=0.1 --set /time/end=0.2 "
    "--set /time/energy_growth=1e9 "
    "--set '/structures/0/hyperelastic/law={\"neo_hookean\": {\"shear_modulus\": 20, "
    "\"stress_free\": true}}' "
    "--set '/structures/0/hyperelastic/initial_position=[\"0.6+1.4*(s1-0.6)\", "
    "\"0.5+(s2-0.5)/1.4\"]' ";
  for (const unsigned int ranks : {1, 2})
    {
      const CaseRun result = run(disc, settings, ranks);
      ASSERT_EQ(result.exit_code, 0) << result.output;
      EXPECT_TRUE(holds(result.output, "warning: the step from time 0 with dt = 0.1 failed: "));
      EXPECT_TRUE(holds(result.output, "trying dt = 0.05"));
      EXPECT_GT(result.summary["retries"].get<int>(), 0);
      // Every multiple of the step is reached; the balance closes, so nothing of a failed step
      // stays.
      const auto &time = result.ledger.at("time");
      for (const double t : {.1, .2})
        EXPECT_NE(std::find(time.begin(), time.end(), t), time.end());
      const auto &energy = result.ledger.at("total_energy");
      const double scale = *std::max_element(energy.begin(), energy.end());
      EXPECT_LT(result.summary["energy"]["largest_closure"].get<double>(), 1e-6 * scale);
      for (unsigned int i = 1; i < time.size(); ++i)
        EXPECT_NEAR(time[i] - time[i - 1], result.ledger.at("dt")[i], 1e-14);
    }

  // Down to a minimum, and no further.
  const CaseRun stopped =
    run(disc, settings + "--set '/time/control={\"fixed\": {\"minimum_step\": 0.05}}'");
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_TRUE(holds(stopped.output, "trying dt = 0.05"));
  EXPECT_FALSE(holds(stopped.output, "trying dt = 0.025"));
  EXPECT_TRUE(holds(stopped.output, "the last good state is step"));
}

TEST(StepControl, SaysWhatIsWrong)
{
  const CaseRun large = run(membrane, "--set '/time/control={\"fixed\": {\"minimum_step\": 1}}'");
  EXPECT_EQ(large.exit_code, 2);
  EXPECT_TRUE(holds(large.output, "/time/control/fixed/minimum_step: is larger than the step"))
    << large.output;
  const CaseRun crossed =
    run(membrane,
        "--set '/time/control={\"adaptive\": {\"minimum_step\": 1e-4, \"maximum_step\": 1e-5}}'");
  EXPECT_EQ(crossed.exit_code, 2);
  EXPECT_TRUE(holds(crossed.output, "/time/control/adaptive/maximum_step: is smaller than the"))
    << crossed.output;
}
