// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/time_integrator_kit.h>

FEIB_TEST_TIME_INTEGRATOR("be_be", 1);

namespace
{
  using namespace feib;
  using feib::testing::SchemeTrial;
} // namespace

TEST(BackwardEulerBackwardEuler, TakesItsGeometryAtTheEndOfTheStep)
{
  SchemeTrial<2> trial("be_be", "{\"geometry_tolerance\": 1e-8}");
  for (unsigned int n = 0; n < 3; ++n)
    {
      std::vector<Positions<2>> old;
      for (const auto &structure : trial.structures)
        old.push_back(structure.model->positions);
      EXPECT_GT(trial.step().geometry_iterations, 0u);
      for (unsigned int s = 0; s < old.size(); ++s)
        {
          const Positions<2> &X = trial.structures[s].model->positions;
          trial.structures[s].set_geometry(trial.space, X);
          NodalField<2> U;
          trial.structures[s].motion->interpolate(trial.space, trial.space.velocity, U);
          double moved = 0;
          for (unsigned int i = 0; i < U.size(); ++i)
            {
              EXPECT_LT((X[i] - old[s][i] - trial.dt * U[i]).norm(), 1e-8 / 8);
              moved = std::max(moved, trial.dt * U[i].norm());
            }
          EXPECT_GT(moved, 1e-5);
        }
    }
}

TEST(BackwardEulerBackwardEuler, EnergyFallsInEveryStepHoweverStiff)
{
  feib::testing::check_energy_falls("be_be");
}
