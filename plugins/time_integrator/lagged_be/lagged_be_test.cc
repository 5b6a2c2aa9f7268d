// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/time_integrator_kit.h>

FEIB_TEST_TIME_INTEGRATOR("lagged_be", 1);

namespace
{
  using namespace feib;
  using feib::testing::SchemeTrial;
} // namespace

TEST(LaggedBackwardEuler, TakesTheGeometryAtTheStartAndTheForceAtTheEndOfTheStep)
{
  SchemeTrial<2> trial("lagged_be",
                       "{}",
                       {{"/structures/0/membrane/excess_density", "0"},
                        {"/structures/1/hyperelastic/excess_density", "0"}});
  for (unsigned int n = 0; n < 3; ++n)
    {
      std::vector<Positions<2>> old;
      for (const auto &structure : trial.structures)
        old.push_back(structure.model->positions);
      const auto report = trial.step();
      for (unsigned int s = 0; s < old.size(); ++s)
        {
          const StructureModel<2> &model = *trial.structures[s].model;
          trial.structures[s].set_geometry(trial.space, old[s]);
          NodalField<2> U, force;
          trial.structures[s].motion->interpolate(trial.space, trial.space.velocity, U);
          model.load(model.positions, force);
          double power = 0, scale = 0, moved = 0;
          for (unsigned int i = 0; i < U.size(); ++i)
            {
              EXPECT_LT((model.positions[i] - old[s][i] - trial.dt * U[i]).norm(), 1e-14);
              moved = std::max(moved, trial.dt * U[i].norm());
              power += force[i] * U[i];
              scale += force[i].norm() * U[i].norm();
            }
          EXPECT_GT(moved, 1e-5);
          EXPECT_NEAR(report.exchanges[s].power, power, 1e-10 * scale);
        }
      EXPECT_EQ(report.geometry_iterations, 0u);
    }
}

TEST(LaggedBackwardEuler, EnergyFallsInEveryStepHoweverStiff)
{
  feib::testing::check_energy_falls("lagged_be");
}
