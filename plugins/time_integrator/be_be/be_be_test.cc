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
  for (const std::string stiffness : {"1", "100"})
    for (const std::string excess : {"0", "1"})
      {
        SCOPED_TRACE("stiffness " + stiffness + ", excess density " + excess);
        SchemeTrial<2> trial("be_be",
                             "{}",
                             {{"/fluid/navier_stokes/viscosity", "1"},
                              {"/structures/0/membrane/excess_density", excess},
                              {"/structures/0/membrane/law/anisotropic_linear/stiffness",
                               stiffness}});
        trial.dt      = .02;
        double before = trial.energy();
        for (unsigned int n = 0; n < 4; ++n)
          {
            const auto report  = trial.step();
            const double after = trial.energy();
            EXPECT_LE(after, before * (1 + 1e-10));
            EXPECT_GE(report.numerical, -1e-10 * before);
            before = after;
          }
      }
}
