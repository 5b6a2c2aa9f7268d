// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/time_integrator_kit.h>

FEIB_TEST_TIME_INTEGRATOR("midpoint", 2);

namespace
{
  using namespace feib;
  using feib::testing::SchemeTrial;
} // namespace

TEST(Midpoint, TakesGeometryAndForceAtThePredictedHalfStep)
{
  SchemeTrial<2> trial("midpoint",
                       "{}",
                       {{"/structures/0/membrane/excess_density", "0"},
                        {"/structures/1/hyperelastic/excess_density", "0"}});
  for (unsigned int n = 0; n < 3; ++n)
    {
      // X^n + dt/2 u^n(X^n)
      std::vector<Positions<2>> old, half;
      for (const auto &structure : trial.structures)
        {
          old.push_back(structure.model->positions);
          half.push_back(old.back());
          structure.set_geometry(trial.space, old.back());
          NodalField<2> U;
          structure.motion->interpolate(trial.space, trial.space.velocity, U);
          for (unsigned int i = 0; i < U.size(); ++i)
            half.back()[i] += trial.dt / 2 * U[i];
        }
      const auto report = trial.step();
      VelocityVector u  = trial.space.velocity;
      u.zero_out_ghost_values();
      u.sadd(.5, .5, trial.space.old_velocity);
      u.update_ghost_values();
      for (unsigned int s = 0; s < old.size(); ++s)
        {
          const StructureModel<2> &model = *trial.structures[s].model;
          trial.structures[s].set_geometry(trial.space, half[s]);
          NodalField<2> U, force;
          trial.structures[s].motion->interpolate(trial.space, u, U);
          model.load(half[s], force);
          double power = 0, scale = 0;
          for (unsigned int i = 0; i < U.size(); ++i)
            {
              EXPECT_LT((model.positions[i] - old[s][i] - trial.dt * U[i]).norm(), 1e-14);
              power += force[i] * U[i];
              scale += force[i].norm() * U[i].norm();
            }
          EXPECT_GT(scale, 1e-5);
          EXPECT_NEAR(report.exchanges[s].power, power, 1e-12 * scale);
        }
    }
}

TEST(Midpoint, AFluidAloneLosesEnergyToViscosityOnly)
{
  SchemeTrial<2> trial("midpoint",
                       "{}",
                       {{"/structures", "[]"},
                        {"/domain/periodic", "[\"x\", \"y\"]"},
                        {"/fluid/navier_stokes/initial_velocity",
                         "[\"sin(2*pi*y) + 0.5\", \"sin(2*pi*x)\"]"}});
  for (unsigned int n = 0; n < 5; ++n)
    {
      const double before = trial.energy();
      const auto report   = trial.step();
      EXPECT_EQ(report.numerical, 0);
      EXPECT_GT(report.dissipated, 0);
      EXPECT_NEAR(trial.energy() - before + report.dissipated, 0, 1e-11 * before);
    }
}
