// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/time_integrator_kit.h>

FEIB_TEST_TIME_INTEGRATOR("lagged_midpoint", 2);

namespace
{
  using namespace feib;
  using feib::testing::registry;
  using feib::testing::SchemeTrial;
} // namespace

TEST(LaggedMidpoint, BalancesExactlyAtTwentyTimesTheExplicitLimit)
{
  // Linear laws and no convection: nothing is lost but to viscosity.
  for (const std::string corrections : {"0", "1"})
    {
      SchemeTrial<2> trial(
        "lagged_midpoint",
        "{\"corrections\": " + corrections + "}",
        {{"/fluid/navier_stokes/convection", "none"},
         {"/fluid/navier_stokes/viscosity", "0.1"},
         {"/structures/0/membrane/law/anisotropic_linear/stiffness", "10"},
         {"/structures/1/hyperelastic/law",
          "{\"anisotropic_linear\": {\"stiffness\": 2, \"fibres\": [[1, 0]]}}"}});
      const auto explicit_scheme = registry().create<TimeIntegrator<2>>("midpoint");
      trial.dt                   = 20 * explicit_scheme->stability_limit(trial.system()).dt;
      double before              = trial.energy();
      const double initial       = before;
      for (unsigned int n = 0; n < 10; ++n)
        {
          const auto report  = trial.step();
          const double after = trial.energy();
          EXPECT_LT(after, before);
          EXPECT_NEAR(after - before + report.dissipated, 0, 1e-10 * initial);
          EXPECT_NEAR(report.numerical, 0, 1e-12 * initial);
          EXPECT_EQ(report.nonlinear_iterations, 1u + (corrections == "1"));
          EXPECT_EQ(report.geometry_iterations, corrections == "1" ? 1u : 0u);
          before = after;
        }
      EXPECT_LT(before, .8 * initial);
    }
}

TEST(LaggedMidpoint, TakesTheForceHalfWayOfTheStep)
{
  SchemeTrial<2> trial("lagged_midpoint",
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
          Positions<2> half              = old[s];
          for (unsigned int i = 0; i < half.size(); ++i)
            half[i] += .5 * (model.positions[i] - old[s][i]);
          NodalField<2> force;
          model.load(half, force);
          double power = 0, scale = 0;
          for (unsigned int i = 0; i < half.size(); ++i)
            {
              const dealii::Tensor<1, 2> U = (model.positions[i] - old[s][i]) / trial.dt;
              power += force[i] * U;
              scale += force[i].norm() * U.norm();
            }
          EXPECT_GT(scale, 1e-5);
          EXPECT_NEAR(report.exchanges[s].power, power, 1e-10 * scale);
        }
    }
}
