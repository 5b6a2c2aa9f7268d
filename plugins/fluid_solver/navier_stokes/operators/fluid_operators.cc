// SPDX-License-Identifier: LGPL-2.1-or-later
#include "operators/fluid_operators.h"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  template <int dim>
  void
  FluidOperators<dim>::reinit(const Space &space)
  {
    communicator = space.communicator();
    batches.reinit(space);
    convection_terms.reinit(space);
    divergence_matrices.clear();
    for (const auto &cell : space.cells())
      {
        if (cell.level >= divergence_matrices.size())
          divergence_matrices.resize(cell.level + 1);
        if (divergence_matrices[cell.level].empty())
          divergence_matrices[cell.level] = operators.divergence_matrix(cell.size);
      }
  }


  template <int dim>
  void
  FluidOperators<dim>::velocity_form(const CellBatch &batch,
                                     const double rate,
                                     const double viscosity,
                                     const Values (&u)[n_u],
                                     Values (&out)[n_u]) const
  {
    apply_velocity_form<dim, double>({rate * given_terms.rho,
                                      viscosity * given_terms.mu,
                                      given_terms.symmetric ? viscosity * given_terms.mu : 0.,
                                      viscosity * given_terms.grad_div},
                                     batch.size,
                                     u,
                                     out);
  }


  template <int dim>
  void
  FluidOperators<dim>::add_velocity_form(const double rate,
                                         const double factor,
                                         const VelocityVector &u,
                                         VelocityVector &r) const
  {
    for (const CellBatch &batch : batches)
      {
        Values local[n_u], product[n_u];
        batch.gather(u, local);
        velocity_form(batch, rate, factor, local, product);
        batch.scatter_add(product, r);
      }
  }


  template <int dim>
  void
  FluidOperators<dim>::subtract_stokes(const double rate,
                                       const VelocityVector &u,
                                       const PressureVector &p,
                                       VelocityVector &r,
                                       PressureVector &g) const
  {
    for (const CellBatch &batch : batches)
      {
        Values local[n_u], product[n_u], pressure[n_p], divergence[n_p] = {}, force[n];
        batch.gather(u, local);
        batch.gather_pressure(p, pressure);
        velocity_form(batch, rate, 1., local, product);
        const double measure = cell_volume(batch.size);
        for_directions<dim>([&](const auto a) {
          const double scale = measure / batch.size[a.value];
          apply_gradient<dim, a.value>(scale, pressure, force);
          feib::add_divergence<dim, a.value>(scale, local + a.value * n, divergence);
          for (unsigned int i = 0; i < n; ++i)
            product[a.value * n + i] = force[i] - product[a.value * n + i];
        });
        batch.scatter_add(product, r);
        batch.scatter_add_pressure(divergence, g);
      }
  }


  template <int dim>
  void
  FluidOperators<dim>::add_gradient(const PressureVector &p, VelocityVector &r) const
  {
    for (const CellBatch &batch : batches)
      {
        const double measure = cell_volume(batch.size);
        Values pressure[n_p], force[n_u];
        batch.gather_pressure(p, pressure);
        for_directions<dim>([&](const auto a) {
          apply_gradient<dim, a.value>(measure / batch.size[a.value],
                                       pressure,
                                       force + a.value * n);
        });
        batch.scatter_add(force, r);
      }
  }


  template <int dim>
  void
  FluidOperators<dim>::add_divergence(const VelocityVector &u, PressureVector &g) const
  {
    for (const CellBatch &batch : batches)
      {
        const double measure = cell_volume(batch.size);
        Values local[n_u], divergence[n_p] = {};
        batch.gather(u, local);
        for_directions<dim>([&](const auto a) {
          feib::add_divergence<dim, a.value>(measure / batch.size[a.value],
                                             local + a.value * n,
                                             divergence);
        });
        batch.scatter_add_pressure(divergence, g);
      }
  }


  template <int dim>
  double
  FluidOperators<dim>::quadratic_form(const double rate,
                                      const double viscosity,
                                      const VelocityVector &u) const
  {
    double result = 0;
    for (const CellBatch &batch : batches)
      {
        Values local[n_u], product[n_u], sum = {};
        batch.gather(u, local);
        velocity_form(batch, rate, viscosity, local, product);
        for (unsigned int i = 0; i < n_u; ++i)
          sum += local[i] * product[i];
        for (unsigned int l = 0; l < batch.filled; ++l)
          result += sum[l];
      }
    return dealii::Utilities::MPI::sum(result, communicator);
  }


  template <int dim>
  double
  FluidOperators<dim>::dissipation(const VelocityVector &u) const
  {
    return quadratic_form(0., 1., u);
  }


  template <int dim>
  double
  FluidOperators<dim>::square(const VelocityVector &u) const
  {
    return quadratic_form(1., 0., u);
  }


  template <int dim>
  double
  FluidOperators<dim>::cfl_rate(const VelocityVector &u) const
  {
    double largest = 0;
    for (const CellBatch &batch : batches)
      {
        Values local[n_u];
        batch.gather(u, local);
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int l = 0; l < lanes; ++l)
            {
              double rate = 0;
              for (unsigned int a = 0; a < dim; ++a)
                rate += std::abs(local[a * n + i][l]) / batch.size[a];
              largest = std::max(largest, rate);
            }
      }
    return dealii::Utilities::MPI::max(largest, communicator);
  }


  template <int dim>
  typename FluidOperators<dim>::Values
  FluidOperators<dim>::divergence_square(const CellBatch &batch, const Values (&u)[n_u]) const
  {
    const double measure = cell_volume(batch.size);
    Values result        = {};
    for (unsigned int q = 0; q < CellOperators<dim>::n_q; ++q)
      {
        Values at_point = {};
        for (unsigned int a = 0; a < dim; ++a)
          {
            Values derivative = {};
            for (unsigned int i = 0; i < n; ++i)
              derivative += operators.dphi[a][q][i] * u[a * n + i];
            at_point += derivative / batch.size[a];
          }
        result += measure * operators.weights[q] * at_point * at_point;
      }
    return result;
  }


  template <int dim>
  void
  FluidOperators<dim>::add_momentum(const Space &space,
                                    const CellBatch &batch,
                                    const Values (&u)[n_u],
                                    typename FluidSolver<dim>::Balance &balance) const
  {
    const double measure = cell_volume(batch.size);
    Values mean[dim] = {}, moment[dim][dim] = {}; // int u_a, int x_b u_a from the cell's corner
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int j = 0; j < n; ++j)
        {
          mean[a] += measure * operators.mean[j] * u[a * n + j];
          for (unsigned int b = 0; b < dim; ++b)
            moment[a][b] += measure * batch.size[b] * operators.moment[b][j] * u[a * n + j];
        }
    for (unsigned int l = 0; l < batch.filled; ++l)
      {
        const dealii::Point<dim> &lower = space.cells()[batch.cells[l]].lower;
        const auto arm                  = [&](const unsigned int a, const unsigned int b) {
          return lower[b] * mean[a][l] + moment[a][b][l];
        };
        for (unsigned int a = 0; a < dim; ++a)
          balance.momentum[a] += given_terms.rho * mean[a][l];
        balance.angular_momentum[2] += given_terms.rho * (arm(1, 0) - arm(0, 1));
        if constexpr (dim == 3)
          {
            balance.angular_momentum[0] += given_terms.rho * (arm(2, 1) - arm(1, 2));
            balance.angular_momentum[1] += given_terms.rho * (arm(0, 2) - arm(2, 0));
          }
      }
  }


  template <int dim>
  typename FluidSolver<dim>::Balance
  FluidOperators<dim>::balance(const Space &space) const
  {
    typename FluidSolver<dim>::Balance result;
    for (const CellBatch &batch : batches)
      {
        Values u[n_u], product[n_u], energy = {};
        batch.gather(space.velocity, u);
        velocity_form(batch, .5, 0., u, product);
        for (unsigned int i = 0; i < n_u; ++i)
          energy += u[i] * product[i];
        const Values divergence = divergence_square(batch, u);
        for (unsigned int l = 0; l < batch.filled; ++l)
          {
            result.kinetic_energy += energy[l];
            result.divergence += divergence[l];
          }
        add_momentum(space, batch, u, result);
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int l = 0; l < batch.filled; ++l)
            {
              double speed = 0;
              for (unsigned int a = 0; a < dim; ++a)
                speed += u[a * n + i][l] * u[a * n + i][l];
              result.largest_velocity = std::max(result.largest_velocity, speed);
            }
      }
    using namespace dealii::Utilities::MPI;
    result.kinetic_energy   = sum(result.kinetic_energy, communicator);
    result.divergence       = std::sqrt(sum(result.divergence, communicator));
    result.momentum         = sum(result.momentum, communicator);
    result.angular_momentum = sum(result.angular_momentum, communicator);
    result.largest_velocity = std::sqrt(max(result.largest_velocity, communicator));
    result.cfl_rate         = cfl_rate(space.velocity);
    return result;
  }


  template class FluidOperators<2>;
  template class FluidOperators<3>;
} // namespace feib
