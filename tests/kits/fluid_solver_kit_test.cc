// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kit_test.h"

#include <feib/testing/fluid_solver_kit.h>

// Without a fault the kit finds none.
FEIB_TEST_FLUID_SOLVER("wrong_fluid");

namespace
{
  using namespace feib::testing;

  const ExpectNamed expect_named{"wrong_fluid",
                                 R"({"navier_stokes": {"density": 1.3, "viscosity": 0.05}})"};
} // namespace

TEST(FluidSolverKitItself, NamesWrongSteps)
{
  expect_named(check_step<2>, "expands", "values on walls");
  expect_named(check_step<3>, "slips", "values on walls");
  expect_named(check_step<2>, "leaks", "relative_divergence");
  expect_named(check_step<2>, "moves what is old", "must leave space.old_velocity");
  expect_named(check_beyond<2>, "knows no beyond", "values on walls after");
  expect_named(check_rest<2>, "gives way", "a gradient moves fluid");
  expect_named(check_rest<2>, "other pressure", "the pressure of find_pressure()");
}

TEST(FluidSolverKitItself, NamesWrongAccounts)
{
  expect_named(check_powers<2>, "dissipates more", "the powers of the step");
  expect_named(check_powers<3>, "ignores implicit loads", "the powers of the step");
  expect_named(check_powers<2>, "larger increment", "kinetic energy and that of the increment");
  expect_named(check_powers<2>, "heavier", "kinetic energy and that of the increment");
  expect_named(check_balance<2>, "heavier", "kinetic_energy");
  expect_named(check_balance<3>, "turned", "angular_momentum");
}

TEST(FluidSolverKitItself, NamesWrongProjections)
{
  expect_named(check_projection<2>, "projects too far", "the change is not the least one");
  expect_named(check_projection<2>, "projects too far", "a second projection changes");
}

TEST(FluidSolverKitItself, NamesStateThatIsForgotten)
{
  expect_named(check_commit<2>, "counts steps", "number");
  expect_named(check_commit<2>, "counts commits", "number");
  expect_named(check_commit<2>, "ignores implicit loads", "RunFailure");
  expect_named(check_fluid_checkpoint<2>, "forgets its past", "number");
  expect_named(check_fluid_checkpoint<2>, "counts steps", "number");
}

TEST(FluidSolverKitItself, NamesWhatDependsOnTheNumberOfRanks)
{
  if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) > 1)
    expect_named(check_fluid_ranks<2>, "moves by rank", "kinetic_energy");
}
