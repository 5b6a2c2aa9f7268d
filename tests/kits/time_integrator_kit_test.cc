// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kit_test.h"

#include <feib/testing/time_integrator_kit.h>

// Without a fault the kit finds none.
FEIB_TEST_TIME_INTEGRATOR("wrong_scheme", 2);

namespace
{
  using namespace feib::testing;

  const ExpectNamed expect_named{"wrong_scheme", "{\"midpoint\": {}}"};
} // namespace

TEST(TimeIntegratorKitItself, NamesWrongAccounts)
{
  expect_named(check_energy<2>, "dissipates more", "the balance of the step");
  expect_named(check_energy<2>, "dissipates more", "what the fluid gains");
  expect_named(check_energy<2>, "more power", "what structure 0 loses");
  expect_named(check_energy<3>, "more power", "what the fluid gains");
  expect_named(check_momentum, "no force", "trial.dt * force");
}

TEST(TimeIntegratorKitItself, NamesAnOrderThatIsNotReached)
{
  const auto of_order_two = [](const auto &name, const auto &block) {
    check_order(name, block, 2);
  };
  expect_named(of_order_two, "drifts", "when the step is halved");
}

TEST(TimeIntegratorKitItself, NamesStateThatIsForgotten)
{
  expect_named(check_inelastic, "forgets what is inelastic", "the balance of the step");
  expect_named(check_inelastic, "another time", "what structure 1 loses");
  expect_named(check_undo<2>, "forgets its past", "number");
  expect_named(check_undo<2>, "counts steps that failed", "number");
  expect_named(check_undo<3>, "swallows failures", "the fluid's failure is the step's");
  expect_named(check_checkpoint<2>, "forgets its past", "number");
  expect_named(check_checkpoint<2>, "counts steps that failed", "number");
}

TEST(TimeIntegratorKitItself, NamesWrongLimits)
{
  expect_named(check_stability_limit, "no limit", "initial");
  expect_named(check_stability_limit, "negative limit", "limit.dt");
  expect_named(check_stability_limit, "limit of another", "alternative");
}

TEST(TimeIntegratorKitItself, NamesColumnsThatChange)
{
  expect_named(check_diagnostics, "other columns", "names");
}

TEST(TimeIntegratorKitItself, NamesWhatDependsOnTheNumberOfRanks)
{
  if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) > 1)
    expect_named(check_ranks, "moves by rank", "node 0 of structure 0");
}
