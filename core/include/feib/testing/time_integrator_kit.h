// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_time_integrator_kit_h
#define feib_testing_time_integrator_kit_h

#include <feib/testing/examples.h>
#include <feib/testing/memory_checkpoint.h>
#include <feib/testing/numbers.h>
#include <feib/testing/scheme_accounts.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <limits>

namespace feib::testing
{
  /// Halving the step divides what positions change by at least 2^order.
  inline void
  check_order(const std::string &scheme, const std::string &block, const double order)
  {
    std::vector<std::vector<dealii::Point<2>>> X;
    for (const unsigned int n : {4, 8, 16, 32})
      {
        SchemeTrial<2> trial(scheme, block, {{"/fluid/navier_stokes/viscosity", "0.2"}});
        trial.dt = .06 / n;
        for (unsigned int i = 0; i < n; ++i)
          trial.step();
        X.emplace_back();
        for (const auto &structure : trial.structures)
          X.back().insert(X.back().end(),
                          structure.model->positions.begin(),
                          structure.model->positions.end());
      }
    std::vector<double> difference;
    for (unsigned int k = 0; k < 3; ++k)
      {
        double sum = 0;
        for (unsigned int i = 0; i < X[k].size(); ++i)
          sum += X[k][i].distance_square(X[k + 1][i]);
        difference.push_back(std::sqrt(sum));
      }
    // Each alone is scattered by nodes that cross faces of cells, where the velocity has kinks.
    const double rate = std::log2(difference[0] / difference[2]) / 2;
    EXPECT_GT(rate, order - .2) << "positions change by " << difference[0] << ", " << difference[1]
                                << ", " << difference[2] << " when the step is halved";
    std::cout << scheme << ' ' << block << ": order " << rate << std::endl;
  }


  /// A step that failed, at its first or last solution, is read from an archive in memory as if it
  /// had never been, and made again with the same result; so is one that had succeeded.
  template <int dim>
  void
  check_undo_of(const std::string &scheme, const std::string &block, const Case::Settings &settings)
  {
    SCOPED_TRACE("dimension " + std::to_string(dim));
    SchemeTrial<dim> trial(scheme, block, settings);
    trial.fluid = std::make_unique<FailingFluid<dim>>(std::move(trial.fluid));
    auto &fluid = static_cast<FailingFluid<dim> &>(*trial.fluid);
    MemoryArchive before;
    for (unsigned int n = 0; n < (dim == 2 ? 4 : 2); ++n)
      {
        before.start_writing();
        trial.archive(before);
        before.start_reading();
        drop_caches<dim>(fluid);
        const unsigned int n_before = fluid.n_calls;
        const auto expected         = step_in_numbers(trial);
        const unsigned int n_calls  = fluid.n_calls - n_before;
        ASSERT_GT(n_calls, 0u) << "a step asks the fluid solver";
        for (const unsigned int call : {1u, n_calls})
          {
            trial.archive(before);
            fluid.failing_call = fluid.n_calls + call;
            EXPECT_THROW(trial.step(), RunFailure) << "the fluid's failure is the step's";
            fluid.failing_call = 0;
            trial.archive(before);
            drop_caches<dim>(fluid);
            expect_same(step_in_numbers(trial), expected);
          }
      }
  }


  /// A run that is taken up from a checkpoint by new objects goes on to the bit.
  template <int dim>
  void
  check_checkpoint_of(const std::string &scheme,
                      const std::string &block,
                      const Case::Settings &settings)
  {
    SCOPED_TRACE("dimension " + std::to_string(dim));
    SchemeTrial<dim> trial(scheme, block, settings);
    const unsigned int n_steps = dim == 2 ? 3 : 2;
    for (unsigned int n = 0; n < n_steps; ++n)
      trial.step();
    MemoryCheckpoint<dim> checkpoint;
    trial.archive(checkpoint);

    SchemeTrial<dim> resumed(scheme, block, settings);
    checkpoint.start_reading(resumed.space);
    resumed.archive(checkpoint);
    for (unsigned int n = 0; n < n_steps; ++n)
      expect_same(step_in_numbers(resumed), step_in_numbers(trial));
  }


  template <int dim>
  void
  check_undo(const std::string &scheme, const std::string &block)
  {
    check_undo_of<dim>(scheme, block, {});
  }

  template <int dim>
  void
  check_checkpoint(const std::string &scheme, const std::string &block)
  {
    check_checkpoint_of<dim>(scheme, block, {});
  }


  /// Viscosity, state and time of a law each change where the body goes.
  inline void
  check_inelastic_acts(const std::string &scheme, const std::string &block)
  {
    const std::string rubber = R"({"neo_hookean": {"shear_modulus": 2, "stress_free": true}})";
    const auto positions     = [&](const std::string &law) {
      SchemeTrial<2> trial(scheme, block, {{"/structures/1/hyperelastic/law", law}});
      for (unsigned int n = 0; n < 4; ++n)
        trial.step();
      return trial.structures[1].model->positions;
    };
    const Positions<2> elastic = positions(rubber);
    for (const std::string law :
         {R"({"kelvin_voigt": {"viscosity": 0.5, "law": )",
          R"({"mullins_damage": {"r": 1, "m": 0.001, "law": )",
          R"({"active_fibre": {"tension": "50*t", "fibres": [[1, 0]], "law": )"})
      {
        const Positions<2> X = positions(law + rubber + "}}");
        EXPECT_GT(X.largest([&](const unsigned int i) { return X[i].distance(elastic[i]); }), 1e-7)
          << "the body moves as if its law were elastic: " << law
          << "...}}; a scheme calls viscous_load, update_state and set_moment of structures";
      }
  }


  /// All of these, with a body whose law depends on the rate, on its state and on time.
  inline void
  check_inelastic(const std::string &scheme, const std::string &block)
  {
    check_inelastic_acts(scheme, block);
    check_energy_of<2>(scheme, block, inelastic_body());
    check_undo_of<2>(scheme, block, inelastic_body());
    check_checkpoint_of<2>(scheme, block, inelastic_body());
  }


  /// Where the estimate of the largest stable step is finite, half of it is stable, and it names
  /// the structure and a scheme without a limit; where it is infinite, a step of many times the
  /// time in which elastic waves cross a cell is stable.
  inline void
  check_stability_limit(const std::string &scheme, const std::string &block)
  {
    const auto make = [&](const std::string &stiffness) {
      return std::make_unique<SchemeTrial<2>>(
        scheme,
        block,
        Case::Settings{{"/fluid/navier_stokes/convection", "none"},
                       {"/fluid/navier_stokes/viscosity", "0.1"},
                       {"/structures/0/membrane/law/anisotropic_linear/stiffness", stiffness},
                       {"/structures/1/hyperelastic/law",
                        "{\"anisotropic_linear\": {\"stiffness\": 2, \"fibres\": [[1, 0]]}}"}});
    };
    const auto trial = make("20");
    const auto limit = trial->scheme->stability_limit(trial->system());
    ASSERT_GT(limit.dt, 0); // nor NaN
    if (std::isfinite(limit.dt))
      {
        EXPECT_EQ(limit.structure, "membrane") << "the stiffer one";
        const auto softer = make("2");
        EXPECT_GT(softer->scheme->stability_limit(softer->system()).dt, limit.dt);
        const auto alternative = registry().create<TimeIntegrator<2>>(limit.alternative);
        EXPECT_EQ(alternative->stability_limit(trial->system()).dt,
                  std::numeric_limits<double>::infinity());
      }
    trial->dt            = std::isfinite(limit.dt) ? limit.dt / 2 : .02;
    const double initial = trial->energy();
    for (unsigned int n = 0; n < 10; ++n)
      {
        trial->step();
        ASSERT_LT(trial->energy(), 1.001 * initial) << "step " << n << " of " << trial->dt;
      }
  }


  /// Columns of the ledger have the same names at every call, and finite values; an estimate of the
  /// error, where the scheme has one, is known after a few steps.
  inline void
  check_diagnostics(const std::string &scheme, const std::string &block)
  {
    SchemeTrial<2> trial(scheme, block);
    std::vector<std::string> names;
    for (unsigned int n = 0; n < 4; ++n)
      {
        const auto columns = trial.scheme->diagnostics(trial.system(), trial.dt);
        if (n == 0)
          for (const auto &column : columns)
            names.push_back(column.first);
        ASSERT_EQ(columns.size(), names.size());
        for (unsigned int i = 0; i < columns.size(); ++i)
          {
            EXPECT_EQ(columns[i].first, names[i]);
            EXPECT_TRUE(std::isfinite(columns[i].second)) << names[i];
          }
        const double error = trial.step().displacement_error;
        EXPECT_TRUE(n < 3 || error < 0 || (error > 0 && std::isfinite(error))) << error;
      }
  }


  /// Whether all ranks have the same positions, to the bit; the answer is the same on all. Where
  /// they have not, a failure of the test says so.
  inline bool
  ranks_agree(const SchemeTrial<2> &trial)
  {
    for (unsigned int s = 0; s < trial.structures.size(); ++s)
      for (unsigned int i = 0; i < trial.structures[s].nodes.size(); ++i)
        for (unsigned int a = 0; a < 2; ++a)
          {
            const double x   = trial.structures[s].model->positions[i][a];
            const double max = dealii::Utilities::MPI::max(x, MPI_COMM_WORLD);
            const double min = dealii::Utilities::MPI::min(x, MPI_COMM_WORLD);
            if (max != min)
              {
                ADD_FAILURE() << "node " << i << " of structure " << s
                              << " is not at one place on all ranks: " << max - min
                              << " between them";
                return false;
              }
          }
    return true;
  }

  /// All ranks have the same positions, to the bit, and it does not matter which of them holds
  /// which part of the fluid: ranks in reverse order give the same to the tolerance of the solver.
  /// That a sum over ranks has each part once shows in the energy, on several ranks.
  inline void
  check_ranks(const std::string &scheme, const std::string &block)
  {
    MPI_Comm reverse;
    MPI_Comm_split(MPI_COMM_WORLD,
                   0,
                   -int(dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD)),
                   &reverse);
    {
      SchemeTrial<2> trial(scheme, block), reversed(scheme, block, {}, reverse);
      // Ranks that do not agree must not go on: one would wait for the other.
      for (unsigned int n = 0; n < 3; ++n)
        {
          trial.step();
          reversed.step();
          if (!ranks_agree(trial) || !ranks_agree(reversed))
            break;
        }
      for (unsigned int s = 0; s < trial.structures.size(); ++s)
        for (unsigned int i = 0; i < trial.structures[s].nodes.size(); ++i)
          EXPECT_LT(trial.structures[s].model->positions[i].distance(
                      reversed.structures[s].model->positions[i]),
                    1e-9)
            << "node " << i << " of structure " << s;
    }
    MPI_Comm_free(&reverse);
  }


  struct SchemeUnderTest
  {
    std::string name;
    double order;
  };

  inline void
  PrintTo(const SchemeUnderTest &scheme, std::ostream *out)
  {
    *out << scheme.name;
  }

  /// What every time integrator must keep, tried for each example of its schema. Include it in one
  /// source of a test program; with navier_stokes, variational, membrane, hyperelastic,
  /// anisotropic_linear, neo_hookean, kelvin_voigt, active_fibre and mullins_damage among the
  /// plugins.
  class TimeIntegratorKit : public ::testing::TestWithParam<SchemeUnderTest>
  {
  protected:
    void
    check(const std::function<void(const std::string &, const std::string &)> &requirement) const
    {
      for_each_example<TimeIntegrator<2>>(GetParam().name, [&](const std::string &block) {
        requirement(GetParam().name, block);
      });
    }
  };

  TEST_P(TimeIntegratorKit, AccountsForTheEnergy)
  {
    check(check_energy<2>);
    check(check_energy<3>);
  }

  TEST_P(TimeIntegratorKit, AccountsForTheMomentum)
  {
    check(check_momentum);
  }

  TEST_P(TimeIntegratorKit, HasItsOrder)
  {
    check([&](const auto &name, const auto &block) { check_order(name, block, GetParam().order); });
  }

  TEST_P(TimeIntegratorKit, StepsCanBeUndone)
  {
    check(check_undo<2>);
    check(check_undo<3>);
  }

  TEST_P(TimeIntegratorKit, GoesOnFromACheckpoint)
  {
    check(check_checkpoint<2>);
    check(check_checkpoint<3>);
  }

  TEST_P(TimeIntegratorKit, TakesViscosityStateAndTimeAlong)
  {
    check(check_inelastic);
  }

  TEST_P(TimeIntegratorKit, IsStableAsItSays)
  {
    check(check_stability_limit);
  }

  TEST_P(TimeIntegratorKit, SpeaksOfItselfInOneWay)
  {
    check(check_diagnostics);
  }

  TEST_P(TimeIntegratorKit, DoesNotDependOnTheNumberOfRanks)
  {
    check(check_ranks);
  }
} // namespace feib::testing

/// Runs the conformance kit for the time integrator of that name, which converges with that order.
#define FEIB_TEST_TIME_INTEGRATOR(scheme, order_) \
  FEIB_TEST_TIME_INTEGRATOR_(scheme, order_, __LINE__)
#define FEIB_TEST_TIME_INTEGRATOR_(scheme, order_, line) \
  FEIB_TEST_TIME_INTEGRATOR__(scheme, order_, line)
#define FEIB_TEST_TIME_INTEGRATOR__(scheme, order_, line)                        \
  namespace feib::testing                                                        \
  {                                                                              \
    INSTANTIATE_TEST_SUITE_P(Line##line,                                         \
                             TimeIntegratorKit,                                  \
                             ::testing::Values(SchemeUnderTest{scheme, order_}), \
                             [](const auto &info) { return info.param.name; });  \
  }                                                                              \
  static_assert(true, "")

#endif
