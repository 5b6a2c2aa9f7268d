// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_fluid_accounts_h
#define feib_testing_fluid_accounts_h

#include <feib/cross_product.h>
#include <feib/testing/fluid_trial.h>

// What the kit of fluid solvers asks of reports and integrals.
namespace feib::testing
{
  /// What is small: the tolerance that solvers must reach, times what norms differ by.
  constexpr double fluid_tolerance = 1e-5;


  /// The momentum equation tested with the velocity computed, see FluidSolver::Report; with a load,
  /// and with one that depends on the velocity.
  template <int dim>
  void
  check_powers(const std::string &solver, const std::string &block)
  {
    for (const bool dragged : {false, true})
      {
        SCOPED_TRACE(dragged ? "with an implicit load" : "");
        FluidTrial<dim> trial(solver, block);
        Drag<dim> drag(*trial.space, 3.);
        const VelocityVector load = trial.stirring();
        for (unsigned int n = 0; n < 2; ++n)
          {
            const double before = trial.fluid->balance(*trial.space).kinetic_energy;
            const auto report   = trial.advance(load, dragged ? &drag : nullptr);
            trial.space->velocity.update_ghost_values();
            trial.space->old_velocity.update_ghost_values();
            VelocityVector all = load;
            if (dragged)
              drag.evaluate(trial.space->velocity, all);
            const double of_load = all * trial.space->velocity, inertia = trial.inertial_power();
            const double scale = std::abs(load * trial.space->velocity) + report.dissipation;
            EXPECT_NEAR(inertia + report.dissipation + report.convection_power,
                        report.boundary_power + report.body_force_power + of_load,
                        fluid_tolerance * scale)
              << "the powers of the step";
            EXPECT_NEAR(trial.fluid->balance(*trial.space).kinetic_energy - before +
                          report.increment_energy,
                        trial.dt * inertia,
                        1e-10 * trial.dt * scale)
              << "kinetic energy and that of the increment";
            EXPECT_GT(report.dissipation, 0);
            EXPECT_GT(report.increment_energy, 0);
            EXPECT_NEAR(report.convection_power, 0, fluid_tolerance * scale) << "in a closed box";
            trial.accept();
          }
      }
  }


  /// Integrals over the fluid are those of the velocity of the space.
  template <int dim>
  void
  check_balance(const std::string &solver, const std::string &block)
  {
    const auto space     = make_state<dim>();
    const auto fluid     = registry().create<FluidSolver<dim>>(solver, block);
    const double density = fluid->density();
    double energy = 0, divergence = 0;
    dealii::Tensor<1, dim> momentum;
    dealii::Tensor<1, 3> angular;
    for_each_cell(*space, [&](const auto &, const auto &values, const auto &) {
      for (unsigned int q = 0; q < values.n_quadrature_points; ++q)
        {
          const dealii::Point<dim> x         = values.quadrature_point(q);
          const dealii::Tensor<1, dim> u     = exact_velocity<dim>(x);
          const double weight                = values.JxW(q);
          const dealii::Tensor<1, dim> force = weight * density * u;
          energy += weight * density / 2 * u.norm_square();
          momentum += force;
          angular += cross_product<dim>(x, force);
          // d(u_0)/dx + d(u_1)/dy (+ d(u_2)/dz) of exact_velocity
          const double of_u = 2 * x[0] - 2 * x[1] + 2 * x[1] - (dim == 2 ? 1 : 0) + .5 * x[0];
          divergence += weight * of_u * of_u;
        }
    });
    double largest = 0;
    for_each_node(*space, [&](const dealii::Point<dim> &x, const unsigned int *) {
      largest = std::max(largest, exact_velocity<dim>(x).norm());
    });
    const auto all = [&](const double part) {
      return dealii::Utilities::MPI::sum(part, space->communicator());
    };
    const auto found = fluid->balance(*space);
    EXPECT_NEAR(found.kinetic_energy, all(energy), 1e-12 * all(energy));
    EXPECT_NEAR(found.divergence, std::sqrt(all(divergence)), 1e-12 * found.divergence);
    EXPECT_NEAR(found.largest_velocity,
                dealii::Utilities::MPI::max(largest, space->communicator()),
                1e-12 * found.largest_velocity);
    for (unsigned int a = 0; a < dim; ++a)
      EXPECT_NEAR(found.momentum[a], all(momentum[a]), 1e-12 * found.momentum.norm()) << a;
    for (unsigned int a = 0; a < 3; ++a)
      EXPECT_NEAR(found.angular_momentum[a], all(angular[a]), 1e-12 * found.momentum.norm()) << a;
    EXPECT_GT(found.cfl_rate, 0);
  }
} // namespace feib::testing

#endif
