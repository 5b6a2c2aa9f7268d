// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_scheme_accounts_h
#define feib_testing_scheme_accounts_h

#include <feib/testing/scheme_trial.h>

#include <cmath>

// What the kit of time integrators asks of reports.
namespace feib::testing
{
  /// The energy that leaves one place arrives at another: the sum of Report, and beside it the
  /// fluid's and each structure's own, to the tolerance of the fluid's solver. With walls that move
  /// and a body force, at large and small displacements.
  template <int dim>
  void
  check_energy_of(const std::string &scheme, const std::string &block, Case::Settings settings)
  {
    SCOPED_TRACE("dimension " + std::to_string(dim));
    const std::string wall  = dim == 2 ? "[0.3, 0]" : "[0.3, 0, 0]",
                      force = dim == 2 ? "[\"y\", -0.5]" : "[\"y\", -0.5, 0]";
    settings.emplace_back("/domain/boundary",
                          "{\"y_max\": {\"velocity\": {\"value\": " + wall + "}}}");
    settings.emplace_back("/fluid/navier_stokes/body_force", force);
    SchemeTrial<dim> trial(scheme, block, settings);
    const double scale = trial.energy();
    for (unsigned int n = 0; n < (dim == 2 ? 4 : 2); ++n)
      {
        const double fluid_before = trial.fluid->balance(trial.space).kinetic_energy;
        std::vector<double> before;
        for (const auto &structure : trial.structures)
          before.push_back(trial.energy_of(*structure.model));
        const double all_before = trial.energy();

        const auto report = trial.step();
        double inelastic  = 0;
        for (const auto &exchange : report.exchanges)
          inelastic += exchange.inelastic;
        EXPECT_NEAR(trial.energy() - all_before + report.dissipated + report.convected +
                      report.numerical + report.unexplained + inelastic,
                    report.boundary_work + report.body_work,
                    1e-10 * scale)
          << "the balance of the step, see TimeIntegrator::Report";
        EXPECT_GT(report.dissipated, 0);
        EXPECT_NEAR(report.convected, 0, 1e-10 * scale) << "through a closed box";

        ASSERT_EQ(report.exchanges.size(), trial.structures.size());
        double power = 0, numerical = report.numerical;
        for (unsigned int s = 0; s < before.size(); ++s)
          {
            const auto &exchange = report.exchanges[s];
            EXPECT_NEAR(trial.energy_of(*trial.structures[s].model) - before[s] +
                          exchange.numerical + exchange.unexplained + exchange.inelastic,
                        -trial.dt * exchange.power,
                        1e-10 * scale)
              << "what structure " << s << " loses is the work of its forces on the fluid";
            EXPECT_LT(std::abs(exchange.unexplained), 1e-4 * exchange.elastic_work)
              << "a law whose stress is the derivative of its energy explains all of it";
            power += exchange.power;
            numerical -= exchange.numerical;
          }
        EXPECT_NEAR(trial.fluid->balance(trial.space).kinetic_energy - fluid_before +
                      report.dissipated + report.convected + numerical,
                    report.boundary_work + report.body_work + trial.dt * power,
                    1e-10 * scale)
          << "what the fluid gains is the work of the structures' forces on it";
      }
  }


  template <int dim>
  void
  check_energy(const std::string &scheme, const std::string &block)
  {
    check_energy_of<dim>(scheme, block, {});
  }


  /// Of a scheme that is stable whatever the step: energy falls in every step however stiff a
  /// structure is, with excess mass or not, and the scheme gains none.
  inline void
  check_energy_falls(const std::string &scheme)
  {
    for (const std::string stiffness : {"1", "100"})
      for (const std::string excess : {"0", "1"})
        {
          SCOPED_TRACE("stiffness " + stiffness + ", excess density " + excess);
          SchemeTrial<2> trial(scheme,
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


  /// The momentum the fluid gains in a periodic box is that of the forces told, and all there is
  /// keeps its momentum.
  inline void
  check_momentum(const std::string &scheme, const std::string &block)
  {
    SchemeTrial<2> trial(scheme,
                         block,
                         {{"/domain/periodic", "[\"x\", \"y\"]"},
                          {"/fluid/navier_stokes/convection", "none"},
                          {"/fluid/navier_stokes/initial_velocity",
                           "[\"0.3 + 0.5 * sin(2*pi*y + 1)\", 0.1]"}});
    for (unsigned int n = 0; n < 3; ++n)
      {
        const auto before       = trial.momentum(),
                   fluid_before = trial.fluid->balance(trial.space).momentum;
        const auto report       = trial.step();
        EXPECT_LT((trial.momentum() - before).norm(), 1e-10 * before.norm());
        dealii::Tensor<1, 2> force;
        for (const auto &exchange : report.exchanges)
          force += exchange.force;
        EXPECT_GT(force.norm(), 1e-4) << "of the excess mass";
        EXPECT_LT(
          (trial.fluid->balance(trial.space).momentum - fluid_before - trial.dt * force).norm(),
          1e-10 * before.norm());
      }
  }
} // namespace feib::testing

#endif
