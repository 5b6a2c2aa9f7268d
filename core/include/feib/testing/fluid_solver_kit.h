// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_fluid_solver_kit_h
#define feib_testing_fluid_solver_kit_h

#include <feib/testing/examples.h>
#include <feib/testing/fluid_accounts.h>
#include <feib/testing/memory_checkpoint.h>
#include <feib/testing/numbers.h>

#include <functional>

namespace feib::testing
{
  /// Steps are free of divergence, take the values on walls at their end exactly, and leave u^n.
  template <int dim>
  void
  check_step(const std::string &solver, const std::string &block)
  {
    FluidTrial<dim> trial(solver, block);
    EXPECT_GT(trial.fluid->density(), 0);
    EXPECT_GT(trial.fluid->viscosity(), 0);
    for (unsigned int n = 0; n < 3; ++n)
      {
        const VelocityVector before = trial.space->velocity;
        trial.advance(trial.stirring());
        VelocityVector change = before;
        change -= trial.space->old_velocity;
        EXPECT_EQ(change.linfty_norm(), 0) << "advance() must leave space.old_velocity";
        trial.accept();
        EXPECT_GT(trial.space->velocity.linfty_norm(), 1e-4);
        EXPECT_LT(trial.relative_divergence(), fluid_tolerance);
        EXPECT_EQ(trial.distance_from_constraints(), 0) << "values on walls, and of hanging nodes";
      }
  }


  /// A scheme that goes on from half a step in the same direction meets the values on walls.
  template <int dim>
  void
  check_beyond(const std::string &solver, const std::string &block)
  {
    FluidTrial<dim> trial(solver, block);
    for (unsigned int n = 0; n < 3; ++n)
      {
        const double half = trial.dt / 2;
        trial.advance(trial.stirring(), nullptr, half);
        trial.space->velocity.zero_out_ghost_values();
        trial.space->velocity.sadd(2., -1., trial.space->old_velocity);
        trial.space->velocity.update_ghost_values();
        trial.accept();
        EXPECT_GT(trial.space->velocity.linfty_norm(), 1e-4);
        EXPECT_LT(trial.distance_from_constraints(), 1e-14) << "values on walls after " << n + 1;
        EXPECT_LT(trial.relative_divergence(), fluid_tolerance);
      }
  }


  /// A load that is a gradient moves no fluid: the pressure takes it, in a step and in
  /// find_pressure().
  template <int dim>
  void
  check_rest(const std::string &solver, const std::string &block)
  {
    FluidTrial<dim> trial(solver, block, false);
    dealii::Tensor<1, dim> weight;
    weight[1]                 = -3;
    weight[0]                 = 1;
    const VelocityVector load = load_of(*trial.space, [&](const auto &) { return weight; });
    // The largest distance of the pressure from weight * (x - centre).
    const auto error = [&] {
      dealii::Point<dim> centre;
      for (unsigned int a = 0; a < dim; ++a)
        centre[a] = .5;
      PressureVector exact = trial.space->make_pressure();
      set_pressure(*trial.space, exact, [&](const dealii::Point<dim> &x) {
        return weight * (x - centre);
      });
      exact.zero_out_ghost_values();
      PressureVector found = trial.space->pressure;
      found.zero_out_ghost_values();
      exact -= found;
      return exact.linfty_norm();
    };
    trial.space->pressure = 7.;
    trial.fluid->find_pressure(*trial.space, {0., trial.dt, load});
    PressureVector change = trial.space->pressure;
    change.zero_out_ghost_values();
    change.add(-7.);
    const bool implemented = change.linfty_norm() > 0;
    EXPECT_TRUE(!implemented || error() < fluid_tolerance * weight.norm())
      << "the pressure of find_pressure()";
    EXPECT_EQ(trial.space->velocity.linfty_norm(), 0);

    trial.space->pressure = 0.;
    for (unsigned int n = 0; n < 2; ++n)
      {
        trial.advance(load);
        trial.accept();
        EXPECT_LT(trial.space->velocity.linfty_norm(), fluid_tolerance * trial.dt * weight.norm())
          << "a gradient moves fluid";
        EXPECT_LT(error(), fluid_tolerance * weight.norm()) << "the pressure of advance()";
      }
  }


  /// Projections are free of divergence, change what is so no more, and do no work.
  template <int dim>
  void
  check_projection(const std::string &solver, const std::string &block)
  {
    FluidTrial<dim> trial(solver, block, false);
    EulerianSpace<dim> &space = *trial.space;
    set_velocity(space, space.velocity, exact_velocity<dim>);
    const auto energy  = [&] { return trial.fluid->balance(space).kinetic_energy; };
    const double given = energy();
    space.old_velocity = space.velocity;
    space.old_velocity.update_ghost_values();
    trial.fluid->project(space);
    space.velocity.update_ghost_values();
    EXPECT_LT(trial.relative_divergence(), fluid_tolerance);
    EXPECT_EQ(trial.distance_from_constraints(), 0);
    EXPECT_LT(energy(), given);
    EXPECT_NEAR(trial.inertial_power() * trial.dt, 0, fluid_tolerance * given)
      << "the change is not the least one";
    const VelocityVector once = space.velocity;
    trial.fluid->project(space);
    VelocityVector change = space.velocity;
    change -= once;
    EXPECT_LT(change.linfty_norm(), fluid_tolerance * once.linfty_norm())
      << "a second projection changes what the first has left";
  }


  /// A step is the past only when it is accepted, once: until then further ones replace it. One
  /// that fails is read from an archive in memory as if it had never been.
  template <int dim>
  void
  check_commit(const std::string &solver, const std::string &block)
  {
    FluidTrial<dim> trial(solver, block), twice(solver, block), tried(solver, block);
    for (unsigned int n = 0; n < 3; ++n)
      {
        for (FluidTrial<dim> *const one : {&trial, &twice, &tried})
          drop_caches<dim>(*one->fluid);
        const auto expected = trial.step_in_numbers();
        expect_same(twice.step_in_numbers(), expected);
        twice.fluid->commit(); // says nothing new

        MemoryArchive before;
        before.start_writing();
        tried.archive(before);
        before.start_reading();
        Drag<dim> undefined(*tried.space, 1., false);
        EXPECT_THROW(tried.advance(tried.stirring(), &undefined), RunFailure);
        tried.archive(before);
        drop_caches<dim>(*tried.fluid);
        expect_same(tried.step_in_numbers(), expected);
        tried.archive(before);
        drop_caches<dim>(*tried.fluid);
        expect_same(tried.step_in_numbers(), expected);
      }
    // Another load for the same step, and then the right one.
    trial.advance(trial.stirring(2));
    trial.step_in_numbers();
    twice.step_in_numbers();
    VelocityVector difference = trial.space->velocity;
    difference -= twice.space->velocity;
    EXPECT_LT(difference.linfty_norm(), fluid_tolerance * twice.space->velocity.linfty_norm())
      << "a step depends on what was tried for it before";
  }


  /// A run that is taken up from a checkpoint by new objects goes on to the bit.
  template <int dim>
  void
  check_fluid_checkpoint(const std::string &solver, const std::string &block)
  {
    FluidTrial<dim> trial(solver, block);
    for (unsigned int n = 0; n < 3; ++n)
      trial.step_in_numbers();
    MemoryCheckpoint<dim> checkpoint;
    trial.archive(checkpoint);
    FluidTrial<dim> resumed(solver, block);
    checkpoint.start_reading(*resumed.space);
    resumed.archive(checkpoint);
    for (unsigned int n = 0; n < 3; ++n)
      expect_same(resumed.step_in_numbers(), trial.step_in_numbers());
  }


  /// On several ranks the same comes out as on one.
  template <int dim>
  void
  check_fluid_ranks(const std::string &solver, const std::string &block)
  {
    FluidTrial<dim> together(solver, block), alone(solver, block, true, MPI_COMM_SELF);
    for (unsigned int n = 0; n < 2; ++n)
      {
        together.step_in_numbers();
        alone.step_in_numbers();
        const auto a = together.fluid->balance(*together.space),
                   b = alone.fluid->balance(*alone.space);
        EXPECT_NEAR(a.kinetic_energy, b.kinetic_energy, fluid_tolerance * b.kinetic_energy);
        EXPECT_NEAR(a.largest_velocity, b.largest_velocity, fluid_tolerance * b.largest_velocity);
        EXPECT_LT((a.angular_momentum - b.angular_momentum).norm(),
                  fluid_tolerance * b.angular_momentum.norm());
      }
  }


  /// What every fluid solver must keep, tried for each example of its schema in 2 and 3 dimensions.
  /// Include it in one source of a test program.
  class FluidSolverKit : public ::testing::TestWithParam<std::string>
  {
  protected:
    using Requirement = std::function<void(const std::string &, const std::string &)>;

    void
    check(const Requirement &in_2d, const Requirement &in_3d) const
    {
      for_each_example<FluidSolver<2>>(GetParam(), [&](const std::string &block) {
        {
          SCOPED_TRACE("dimension 2");
          in_2d(GetParam(), block);
        }
        SCOPED_TRACE("dimension 3");
        in_3d(GetParam(), block);
      });
    }
  };

  TEST_P(FluidSolverKit, StepsKeepTheConstraints)
  {
    check(check_step<2>, check_step<3>);
  }

  TEST_P(FluidSolverKit, HalfStepsLeadToTheValuesOnWalls)
  {
    check(check_beyond<2>, check_beyond<3>);
  }

  TEST_P(FluidSolverKit, AccountsForThePowers)
  {
    check(check_powers<2>, check_powers<3>);
  }

  TEST_P(FluidSolverKit, IntegratesOverTheFluid)
  {
    check(check_balance<2>, check_balance<3>);
  }

  TEST_P(FluidSolverKit, StaysAtRestUnderAGradient)
  {
    check(check_rest<2>, check_rest<3>);
  }

  TEST_P(FluidSolverKit, Projects)
  {
    check(check_projection<2>, check_projection<3>);
  }

  TEST_P(FluidSolverKit, StepsAreAcceptedOrUndone)
  {
    check(check_commit<2>, check_commit<3>);
  }

  TEST_P(FluidSolverKit, GoesOnFromACheckpoint)
  {
    check(check_fluid_checkpoint<2>, check_fluid_checkpoint<3>);
  }

  TEST_P(FluidSolverKit, DoesNotDependOnTheNumberOfRanks)
  {
    check(check_fluid_ranks<2>, check_fluid_ranks<3>);
  }
} // namespace feib::testing

/// Runs the conformance kit for the fluid solver of that name.
#define FEIB_TEST_FLUID_SOLVER(name) FEIB_TEST_FLUID_SOLVER_(name, __LINE__)
#define FEIB_TEST_FLUID_SOLVER_(name, line) FEIB_TEST_FLUID_SOLVER__(name, line)
#define FEIB_TEST_FLUID_SOLVER__(name, line)                               \
  namespace feib::testing                                                  \
  {                                                                        \
    INSTANTIATE_TEST_SUITE_P(Line##line,                                   \
                             FluidSolverKit,                               \
                             ::testing::Values(std::string(name)),         \
                             [](const auto &info) { return info.param; }); \
  }                                                                        \
  static_assert(true, "")

#endif
