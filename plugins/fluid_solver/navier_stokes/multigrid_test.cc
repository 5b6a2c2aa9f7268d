// SPDX-License-Identifier: LGPL-2.1-or-later
#include "operators/fluid_operators.h"
#include "multigrid/multigrid_level.h"
#include "multigrid/spectrum.h"

#include <feib/error.h>
#include <feib/testing/spaces.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace
{
  using namespace feib;

  template <int dim>
  std::unique_ptr<FluidSolver<dim>>
  make_solver(const std::string &options)
  {
    return feib::testing::registry().create<FluidSolver<dim>>("navier_stokes", "{" + options + "}");
  }

  /// "cells": n in all directions.
  template <int dim>
  std::string
  box(const unsigned int n, const std::string &more = "")
  {
    const std::string one = std::to_string(n);
    return "{\"cells\": [" + one + "," + one + (dim == 3 ? "," + one : "") + "]" + more + "}";
  }

  /// Refines around a circle or sphere, @p times times.
  template <int dim>
  void
  refine_around(EulerianSpace<dim> &space, const unsigned int times)
  {
    for (unsigned int i = 0; i < times; ++i)
      feib::testing::refine_where(space, [&](const auto &x) {
        dealii::Point<dim> centre;
        for (unsigned int a = 0; a < dim; ++a)
          centre[a] = .5;
        return std::abs(x.distance(centre) - .3) < 1.2 * space.smallest_edge();
      });
  }

  /// The same values for the same places, on any rank.
  template <int dim>
  void
  fill(const EulerianSpace<dim> &space, VelocityVector &v)
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int a = 0; a < dim; ++a)
          {
            double phase        = 1.7 * a;
            unsigned int stride = 1;
            for (unsigned int b = 0; b < dim; ++b, stride *= 3)
              phase += (12.3 + 5 * b) * (space.cells()[c].lower[b] +
                                         .5 * (i / stride % 3) * space.cells()[c].size[b]);
            if (space.velocity_dofs(c)[a * n + i] < v.locally_owned_size())
              v.local_element(space.velocity_dofs(c)[a * n + i]) = std::sin(phase);
          }
  }


  template <int dim>
  void
  check_batch_kernels()
  {
    SCOPED_TRACE("dim " + std::to_string(dim));
    constexpr unsigned int n = CellOperators<dim>::n, n_u = CellOperators<dim>::n_u,
                           n_p = CellOperators<dim>::n_p, lanes = Batch<double>::lanes;
    using Values = Batch<double>::Values;
    dealii::Tensor<1, dim> size;
    for (unsigned int a = 0; a < dim; ++a)
      size[a] = .3 + .2 * a;
    double volume = 1;
    for (unsigned int a = 0; a < dim; ++a)
      volume *= size[a];
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Values u[n_u] = {}, p[n_p] = {}, out[n_u], force[n], divergence[n_p] = {};
    for (Values &value : u)
      for (unsigned int l = 0; l < lanes; ++l)
        value[l] = uniform(random);
    for (Values &value : p)
      for (unsigned int l = 0; l < lanes; ++l)
        value[l] = uniform(random);
    // The matrices are tested against FEValues in navier_stokes_test.cc.
    const CellOperators<dim> operators;
    const auto matrix = operators.divergence_matrix(size);
    for (const bool symmetric : {false, true})
      for (const double gamma : {0., 5.})
        for (const double eta : {0., 7.})
          {
            const auto velocity_matrix = operators.velocity_matrix(size, 2., 3., symmetric, gamma);
            apply_velocity_form<dim, double>({2., 3., symmetric ? 3. : 0., gamma, eta},
                                             size,
                                             u,
                                             out);
            for (unsigned int l = 0; l < lanes; ++l)
              {
                double divergences[n_p] = {}; // times the mass of the pressures
                for (unsigned int k = 0; k < n_p; ++k)
                  for (unsigned int j = 0; j < n_u; ++j)
                    divergences[k] += matrix[k * n_u + j] * u[j][l];
                for (unsigned int i = 0; i < n_u; ++i)
                  {
                    double expected = 0;
                    for (unsigned int j = 0; j < n_u; ++j)
                      expected += velocity_matrix[i * n_u + j] * u[j][l];
                    for (unsigned int k = 0; k < n_p; ++k)
                      expected += eta * matrix[k * n_u + i] * divergences[k] / volume;
                    EXPECT_NEAR(out[i][l], expected, 1e-12);
                  }
              }
          }
    const auto direction = [&](const auto a) {
      const double scale = volume / size[a.value];
      apply_gradient<dim, a.value>(scale, p, force);
      add_divergence<dim, a.value>(scale, u + a.value * n, divergence);
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int l = 0; l < lanes; ++l)
          {
            double expected = 0;
            for (unsigned int k = 0; k < n_p; ++k)
              expected += matrix[k * n_u + a.value * n + i] * p[k][l];
            EXPECT_NEAR(force[i][l], expected, 1e-12);
          }
    };
    direction(std::integral_constant<unsigned int, 0>());
    direction(std::integral_constant<unsigned int, 1>());
    if constexpr (dim == 3)
      direction(std::integral_constant<unsigned int, 2>());
    for (unsigned int k = 0; k < n_p; ++k)
      for (unsigned int l = 0; l < lanes; ++l)
        {
          double expected = 0;
          for (unsigned int j = 0; j < n_u; ++j)
            expected += matrix[k * n_u + j] * u[j][l];
          EXPECT_NEAR(divergence[k][l], expected, 1e-12);
        }
  }


  /// The forms of the finest level against those of the space.
  template <int dim>
  void
  check_level(const std::string &domain, const unsigned int refinements)
  {
    SCOPED_TRACE("dim " + std::to_string(dim) + ", " + domain + ", refined " +
                 std::to_string(refinements));
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes, lanes = MultigridLevel<dim>::lanes;
    const auto space = feib::testing::make_space<dim>(domain);
    refine_around(*space, refinements);
    VelocityVector u = space->make_velocity(), expected = space->make_velocity();
    fill(*space, u);
    space->distribute(u, true);

    const LatticeCells<dim> mesh(*space);
    const MultigridLevel<dim> level(
      mesh, space->domain(), space->communicator(), false, nullptr, nullptr);
    LevelVector<double> level_u, result;
    level.reinit_velocity(level_u);
    level.reinit_velocity(result);
    const auto for_unknowns = [&](const auto &action) {
      for (unsigned int c = 0; c < space->cells().size(); ++c)
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int a = 0; a < dim; ++a)
            {
              const unsigned int slot = level.slots()[c];
              action(space->velocity_dofs(c)[a * n + i],
                     level.nodes(slot / lanes)[i * lanes + slot % lanes] + a);
            }
    };
    for_unknowns([&](const unsigned int dof, const unsigned int unknown) {
      if (unknown < level_u.locally_owned_size() && !level.inactive(unknown))
        level_u.local_element(unknown) = u.local_element(dof);
    });
    level.expand(level_u);
    for (const bool symmetric : {false, true})
      {
        FluidOperators<dim> operators({2., 3., 0., symmetric, ConvectiveForm::rotational});
        operators.reinit(*space);
        expected = 0.;
        operators.add_velocity_form(5., 1., u, expected);
        expected.compress(dealii::VectorOperation::add);
        space->condense(expected);
        space->distribute(expected, true);

        level.apply_velocity_form({10., 3., symmetric ? 3. : 0.}, level_u, result);
        level.expand(result);
        double error = 0, scale = 0;
        for_unknowns([&](const unsigned int dof, const unsigned int unknown) {
          error = std::max(error, std::abs(level_u.local_element(unknown) - u.local_element(dof)));
          error =
            std::max(error, std::abs(result.local_element(unknown) - expected.local_element(dof)));
          scale = std::max(scale, std::abs(expected.local_element(dof)));
        });
        EXPECT_GT(scale, .1);
        EXPECT_LT(error, 1e-12 * std::max(1., scale));
      }
  }


  /// A few steps of changing length with convection and two loads; returns the velocity.
  template <int dim>
  VelocityVector
  some_steps(EulerianSpace<dim> &space,
             const std::string &options,
             const std::string &viscosity,
             unsigned int &iterations,
             PressureVector &pressure)
  {
    const auto solver =
      make_solver<dim>("\"density\": 1.5, \"viscosity\": " + viscosity +
                       ", \"tolerance\": 1e-10, "
                       "\"body_force\": [\"sin(5*y)+t\", "
                       "\"x*x\"" +
                       std::string(dim == 3 ? ", \"x*y\"" : "") + "], " + options);
    solver->initialize(space);
    space.old_velocity = space.older_velocity = space.velocity;
    space.old_dt                              = 0;
    const VelocityVector load                 = space.make_velocity();
    double time                               = 0;
    iterations                                = 0;
    for (const double dt : {.01, .01, .004, .05})
      {
        time += dt;
        iterations += solver->advance(space, {time, dt, load}).linear_iterations;
        solver->commit();
        space.older_velocity = space.old_velocity;
        space.old_velocity   = space.velocity;
        space.old_dt         = dt;
      }
    pressure = space.pressure;
    return space.velocity;
  }

  template <int dim>
  void
  compare(const std::string &domain,
          const unsigned int refinements,
          const std::string &options,
          const std::string &viscosity = "0.02")
  {
    SCOPED_TRACE("dim " + std::to_string(dim) + ", " + domain + ", refined " +
                 std::to_string(refinements) + ", " + options + ", viscosity " + viscosity);
    const auto space = feib::testing::make_space<dim>(domain);
    refine_around(*space, refinements);
    unsigned int iterations[2];
    PressureVector p[2];
    VelocityVector u[2];
    for (const unsigned int k : {0, 1})
      u[k] = some_steps<dim>(*space,
                             options + ", \"linear_solver\": \"" +
                               (k == 0 ? "direct" : "multigrid") + "\"",
                             viscosity,
                             iterations[k],
                             p[k]);
    EXPECT_GE(iterations[1], 16u); // so that it was not the direct solver
    const double u_scale = u[0].l2_norm(), p_scale = p[0].l2_norm();
    EXPECT_GT(u_scale, 1e-3);
    u[1] -= u[0];
    p[1] -= p[0];
    EXPECT_LT(u[1].l2_norm(), 2e-8 * u_scale);
    EXPECT_LT(p[1].l2_norm(), 2e-8 * p_scale);
  }


  /// Iterations of a first step from rest, and of the last of some more.
  template <int dim>
  std::pair<unsigned int, unsigned int>
  iterations(const std::string &domain,
             const unsigned int refinements,
             const double dt,
             const double mu,
             const std::string &convection = "none")
  {
    const auto space = feib::testing::make_space<dim>(domain);
    refine_around(*space, refinements);
    std::ostringstream viscosity;
    viscosity << mu;
    const auto solver = make_solver<dim>(
      "\"density\": 1, \"viscosity\": " + viscosity.str() +
      ", \"tolerance\": 3e-6, \"linear_solver\": \"multigrid\", \"convection\": \"" + convection +
      "\", \"body_force\": "
      "[\"sin(7*y)\", \"10*x*x*y\"" +
      std::string(dim == 3 ? ", \"x*z\"" : "") + "]");
    solver->initialize(*space);
    space->old_velocity = space->older_velocity = space->velocity;
    const VelocityVector load                   = space->make_velocity();
    unsigned int cold = 0, warm = 0;
    for (unsigned int step = 1; step <= 6; ++step)
      {
        warm = solver->advance(*space, {step * dt, dt, load}).linear_iterations;
        solver->commit();
        if (step == 1)
          cold = warm;
        space->older_velocity = space->old_velocity;
        space->old_velocity   = space->velocity;
        space->old_dt         = dt;
      }
    return {cold, warm};
  }
} // namespace


TEST(Multigrid, BatchKernelsAgreeWithMatrices)
{
  check_batch_kernels<2>();
  check_batch_kernels<3>();
}

TEST(Multigrid, FinestLevelIsTheSpace)
{
  const std::string periodic = ", \"periodic\": [\"x\", \"y\"]";
  const std::string mixed = ", \"upper\": [1, 1.5], \"boundary\": {\"x_min\": {\"outflow\": {}}, "
                            "\"y_max\": {\"free_slip\": {}}}";
  for (const unsigned int refinements : {0, 1, 3})
    for (const std::string &more : {std::string(), periodic, mixed})
      check_level<2>(box<2>(8, more), refinements);
  const std::string mixed_3d =
    ", \"periodic\": [\"z\"], \"boundary\": {\"x_min\": {\"outflow\": {}}, "
    "\"y_max\": {\"free_slip\": {}}}";
  for (const unsigned int refinements : {0, 2})
    for (const std::string &more : {std::string(), mixed_3d})
      check_level<3>(box<3>(4, more), refinements);
}

TEST(Multigrid, GivesTheStepOfTheDirectSolver)
{
  const std::string lid =
    ", \"boundary\": {\"y_max\": {\"velocity\": {\"value\": [\"x*x*(1-x)^2*(1+t)\", 0]}}}";
  const std::string channel   = ", \"boundary\": {\"x_min\": {\"velocity\": {\"value\": "
                                "[\"y*(1-y)\", 0]}}, \"x_max\": {\"outflow\": {}}, \"y_max\": "
                                "{\"free_slip\": {}}}";
  const std::string laplacian = "\"viscous_form\": \"laplacian\"";
  const std::string symmetric = "\"viscous_form\": \"symmetric\"";
  compare<2>(box<2>(8), 0, laplacian);
  compare<2>(box<2>(8), 2, symmetric + ", \"grad_div\": 0.05");
  compare<2>(box<2>(8, lid), 2, symmetric + ", \"convection\": \"implicit\"");
  compare<2>(box<2>(8, channel), 1, symmetric);
  compare<2>(box<2>(8, channel), 1, laplacian + ", \"convection\": \"implicit\"");
  compare<2>(box<2>(8, ", \"periodic\": [\"x\", \"y\"]"), 2, symmetric);
  compare<2>(box<2>(8, ", \"upper\": [2, 1], \"periodic\": [\"y\"]"), 1, symmetric);
  // So viscous that coarser levels come first.
  compare<2>(box<2>(8, lid), 1, laplacian, "3");
  compare<2>(box<2>(8, channel), 2, symmetric, "3");
  compare<2>(box<2>(8, ", \"upper\": [2, 1], \"periodic\": [\"y\"]"), 1, symmetric, "3");
  compare<3>(box<3>(4), 1, symmetric, "20");
  // A mesh that has no coarser one.
  compare<2>(box<2>(5), 0, symmetric);
  compare<2>("{\"cells\": [12, 4]}", 1, symmetric);
  for (const std::string form : {"rotational", "skew_symmetric"})
    {
      compare<2>(box<2>(8, channel), 2, symmetric + ", \"convective_form\": \"" + form + "\"");
      compare<2>(box<2>(8, ", \"periodic\": [\"x\", \"y\"]"),
                 1,
                 symmetric + ", \"convective_form\": \"" + form + "\"");
    }
  compare<3>(box<3>(4), 1, symmetric);
  compare<3>(box<3>(4, ", \"periodic\": [\"x\"], \"boundary\": {\"y_max\": {\"free_slip\": {}}}"),
             0,
             laplacian);
}

TEST(Multigrid, IterationsDoNotGrow)
{
  // Over mesh size, refinement, time step and viscosity (docs/performance.md has more). The limits
  // are what was found, and one more.
  struct Limits
  {
    double dt, mu;
    unsigned int cold, warm;
  };
  for (const bool periodic : {false, true})
    for (const Limits &limits : periodic ? std::vector<Limits>{{1e-1, 1., 8, 5}, {1e-3, 1e-3, 8, 4}}
                                         : std::vector<Limits>{{1e-1, 1., 8, 4},
                                                               {1e-1, 1e-3, 8, 7},
                                                               {1e-3, 1., 8, 4},
                                                               {1e-3, 1e-3, 9, 3}})
      {
        const std::string more = periodic ? ", \"periodic\": [\"x\", \"y\"]" : "";
        const auto check       = [&](const unsigned int n, const unsigned int refinements) {
          const auto [cold, warm] =
            iterations<2>(box<2>(n, more), refinements, limits.dt, limits.mu);
          if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
            std::cout << (periodic ? "periodic" : "box") << ", dt " << limits.dt << ", mu "
                      << limits.mu << ", " << n << "^2 + " << refinements << ": cold " << cold
                      << ", warm " << warm << std::endl;
          EXPECT_LE(cold, limits.cold);
          EXPECT_LE(warm, limits.warm);
        };
        check(16, 0);
        check(64, 0);
        check(16, 2);
      }
  for (const Limits &limits : {Limits{1e-2, 1e-2, 9, 4}, Limits{1e-1, 1., 9, 4}})
    {
      const auto [cold, warm] = iterations<3>(box<3>(8), 1, limits.dt, limits.mu);
      std::cout << "3D, 8^3 + 1, dt " << limits.dt << ", mu " << limits.mu << ": cold " << cold
                << ", warm " << warm << std::endl;
      EXPECT_LE(cold, limits.cold);
      EXPECT_LE(warm, limits.warm);
    }
}

TEST(Multigrid, IterationsWithConvection)
{
  // A lid that moves by a quarter of a cell in a step, as with midpoint schemes at a CFL number of
  // 1/2; cell Reynolds numbers 16 to 63.
  const std::string lid    = ", \"boundary\": {\"y_max\": {\"velocity\": {\"value\": [1, 0]}}}";
  const std::string lid_3d = ", \"boundary\": {\"z_max\": {\"velocity\": {\"value\": [1, 0, 0]}}}";
  const auto check         = [](const auto &found, const std::string &name) {
    const auto [cold, warm] = found;
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << name << ": cold " << cold << ", warm " << warm << std::endl;
    EXPECT_LE(cold, 18u) << name;
    EXPECT_LE(warm, 11u) << name;
  };
  for (const unsigned int n : {16, 32, 64})
    check(iterations<2>(box<2>(n, lid), 0, .25 / n, 1e-3, "implicit"), std::to_string(n) + "^2");
  check(iterations<2>(box<2>(16, lid), 2, .25 / 64, 1e-3, "implicit"), "16^2 + 2");
  check(iterations<3>(box<3>(8, lid_3d), 0, .25 / 8, 1e-3, "implicit"), "8^3");
}

TEST(Multigrid, FluidAtRestUnderItsWeight)
{
  // All that moves is what tolerance and round-off leave, and its divergence counts for nothing.
  for (const std::string tolerance : {"1e-7", "1e-11"})
    {
      const auto space = feib::testing::make_space<2>(box<2>(8));
      const auto solver =
        make_solver<2>("\"density\": 1, \"viscosity\": 1, \"tolerance\": " + tolerance +
                       ", \"linear_solver\": \"multigrid\", \"body_force\": "
                       "[\"1\", \"-2\"]");
      solver->initialize(*space);
      const VelocityVector load = space->make_velocity();
      for (unsigned int step = 1; step <= 3; ++step)
        {
          space->old_velocity = space->older_velocity = space->velocity;
          const auto report = solver->advance(*space, {.01 * step, .01, load});
          solver->commit();
          EXPECT_LE(report.linear_iterations, 24u) << tolerance << ", step " << step;
        }
      EXPECT_LT(space->velocity.linfty_norm(), .1 * std::stod(tolerance));
    }
}

TEST(Multigrid, SlowFlowBesideALargeForce)
{
  // The force is balanced by the pressure; what counts is the lid, 3000 times slower than what the
  // force could cause in a step.
  const auto space = feib::testing::make_space<2>(
    box<2>(8, ", \"boundary\": {\"y_max\": {\"velocity\": {\"value\": [\"1e-5*x*(1-x)\", 0]}}}"));
  refine_around(*space, 3);
  const auto solver =
    make_solver<2>("\"density\": 1, \"viscosity\": 1e-3, \"tolerance\": 1e-7, "
                   "\"linear_solver\": \"multigrid\", \"body_force\": [\"3\", \"-7\"]");
  solver->initialize(*space);
  space->old_velocity = space->older_velocity = space->velocity;
  const VelocityVector load                   = space->make_velocity();
  solver->advance(*space, {1e-3, 1e-3, load});
  solver->commit();
  EXPECT_GT(space->velocity.l2_norm(), 1e-6);
  FluidOperators<2> operators({1., 1., 0., false, ConvectiveForm::rotational});
  operators.reinit(*space);
  VelocityVector r = space->make_velocity();
  PressureVector g = space->make_pressure(), p = space->make_pressure();
  operators.subtract_stokes(1., space->velocity, p, r, g);
  // The fluxes through the cells, root of the sum of their squares, are about 1e-6.
  EXPECT_LT(g.l2_norm(), 1e-7 * 1e-6);
}

TEST(Multigrid, DiagonalsAreThoseOfTheForm)
{
  // Of every component, with hanging nodes and cells longer than wide.
  const auto space = feib::testing::make_space<2>(box<2>(4, ", \"upper\": [2, 1]"));
  refine_around(*space, 1);
  const LatticeCells<2> mesh(*space);
  const MultigridLevel<2> level(
    mesh, space->domain(), space->communicator(), true, nullptr, nullptr);
  const VelocityForm form{5., 2., 1.5, .5, 3.};
  LevelVector<float> inverse;
  level.inverse_diagonal(form, false, inverse);
  LevelVector<double> u, result;
  level.reinit_velocity(u);
  level.reinit_velocity(result);
  unsigned int count = 0;
  for (unsigned int i = 0; i < u.locally_owned_size(); ++i)
    if (!level.inactive(i))
      {
        u                  = 0.;
        u.local_element(i) = 1.;
        level.expand(u);
        level.apply_velocity_form(form, u, result);
        EXPECT_NEAR(inverse.local_element(i) * result.local_element(i), 1., 1e-5);
        ++count;
      }
  EXPECT_GT(count, 100u);
}

TEST(Multigrid, SpectrumIsThatOfTheForm)
{
  // The largest eigenvalue, by the power method, on equal cells and beside hanging nodes.
  const std::string open =
    ", \"boundary\": {\"x_max\": {\"outflow\": {}}, \"y_max\": {\"outflow\": {}}}";
  for (const std::string &more :
       {std::string(", \"periodic\": [\"x\", \"y\"]"), std::string(", \"upper\": [2, 1]"), open})
    for (const VelocityForm form : {VelocityForm{1., 0.},
                                    VelocityForm{0., 1.},
                                    VelocityForm{0., 1., 1.},
                                    VelocityForm{0., 1., 1., 0., 3.},
                                    VelocityForm{1., 1e-6, 0., 0., 1e-3}})
      for (const unsigned int refinements : {0, 1})
        {
          const auto space = feib::testing::make_space<2>(box<2>(8, more));
          refine_around(*space, refinements);
          const LatticeCells<2> mesh(*space);
          const MultigridLevel<2> level(
            mesh, space->domain(), space->communicator(), true, nullptr, nullptr);
          LevelVector<float> inverse, u, product;
          level.inverse_diagonal(form, false, inverse);
          level.reinit_velocity(u);
          level.reinit_velocity(product);
          std::mt19937 random(3);
          std::uniform_real_distribution<float> uniform(-1, 1);
          for (unsigned int i = 0; i < u.locally_owned_size(); ++i)
            u.local_element(i) = level.inactive(i) ? 0. : uniform(random);
          double largest = 0;
          for (unsigned int i = 0; i < 200; ++i)
            {
              level.expand(u);
              level.apply_velocity_form(form, u, product);
              for (unsigned int j = 0; j < u.locally_owned_size(); ++j)
                u.local_element(j) =
                  level.inactive(j) ? 0. : inverse.local_element(j) * product.local_element(j);
              largest = u.l2_norm();
              u /= largest;
            }
          const double expected = spectrum(level, form).second;
          // The smoothers allow for 10 % more.
          EXPECT_LT(largest, 1.1 * expected) << more << form.eta << refinements;
          if (more != open) // where it is a bound
            {
              EXPECT_GT(largest, .85 * expected) << more << form.eta << refinements;
            }
        }
}

TEST(Multigrid, ProjectionAfterRemeshing)
{
  for (const std::string method : {"direct", "multigrid"})
    {
      const auto space = feib::testing::make_space<2>(box<2>(16));
      refine_around(*space, 1);
      const auto solver = make_solver<2>(
        "\"density\": 1, \"viscosity\": 0.1, \"tolerance\": 1e-9, \"linear_solver\": \"" + method +
        "\", \"initial_velocity\": [\"sin(pi*x)^2*sin(2*pi*y)\", \"-sin(pi*y)^2*sin(2*pi*x)\"]");
      solver->initialize(*space);
      FluidOperators<2> operators({1., 1., 0., false, ConvectiveForm::rotational});
      const auto divergence = [&] {
        operators.reinit(*space);
        VelocityVector r = space->make_velocity();
        PressureVector g = space->make_pressure(), p = space->make_pressure();
        operators.subtract_stokes(1., space->velocity, p, r, g);
        return g.l2_norm();
      };
      // The tolerance, and the norm of the fluxes through the cells, which is about 1.
      EXPECT_LT(divergence(), 1e-9);
      // Coarsening loses what the finer cells knew.
      space->adapt(
        [&](auto &mesh) {
          for (const auto &cell : mesh.active_cell_iterators())
            if (cell->is_locally_owned())
              {
                if (space->level(*cell) > 0)
                  cell->set_coarsen_flag();
                else if (cell->center()[0] > .8)
                  cell->set_refine_flag();
              }
        },
        false);
      EXPECT_GT(divergence(), 3e-6);
      const VelocityVector before = space->velocity;
      solver->project(*space);
      EXPECT_LT(divergence(), 1e-9);
      VelocityVector change = space->velocity;
      change -= before;
      EXPECT_LT(change.l2_norm(), .02 * before.l2_norm());
    }
}

TEST(Multigrid, AStalledSolveIsAnError)
{
  // So much grad-div is beyond what the velocity's cycle knows.
  const auto space  = feib::testing::make_space<2>(box<2>(16));
  const auto solver = make_solver<2>("\"density\": 1, \"viscosity\": 1e-6, \"grad_div\": 1e6, "
                                     "\"linear_solver\": \"multigrid\", \"body_force\": "
                                     "[\"sin(7*y)\", \"10*x*x*y\"]");
  solver->initialize(*space);
  space->old_velocity = space->older_velocity = space->velocity;
  const VelocityVector load                   = space->make_velocity();
  try
    {
      solver->advance(*space, {.1, .1, load});
      solver->commit();
      FAIL() << "no error";
    }
  catch (const RunFailure &failure)
    {
      const std::string message = failure.what();
      EXPECT_NE(message.find("multigrid"), std::string::npos) << message;
      EXPECT_NE(message.find("residuals, relative to the first: 1, "), std::string::npos)
        << message;
      EXPECT_NE(message.find("\"linear_solver\": \"direct\""), std::string::npos) << message;
    }
}
