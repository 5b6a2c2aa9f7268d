// SPDX-License-Identifier: LGPL-2.1-or-later
#include "fluid_operators.h"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace feib
{
  template <int dim>
  void
  FluidOperators<dim>::set_reconstruction(const Reconstruction<dim> &reconstruction)
  {
    with_reconstruction = true;
    operators           = CellOperators<dim>(&reconstruction);
  }


  template <int dim>
  void
  FluidOperators<dim>::reinit(const Space &space)
  {
    const Domain<dim> &box = space.domain();
    communicator           = space.communicator();
    outflow_faces.assign(space.cells().size(), 0);
    for (unsigned int f = 0; f < 2 * dim; ++f)
      if (box.faces[f].condition == BoundaryCondition::outflow)
        for (unsigned int c = 0; c < space.cells().size(); ++c)
          {
            const auto &cell      = space.cells()[c];
            const double distance = f % 2 == 0
                                      ? cell.lower[f / 2] - box.lower[f / 2]
                                      : box.upper[f / 2] - cell.lower[f / 2] - cell.size[f / 2];
            if (std::abs(distance) < .5 * cell.size[f / 2])
              outflow_faces[c] |= 1U << f;
          }

    std::map<std::pair<unsigned int, unsigned int>, std::vector<unsigned int>> groups;
    masses.clear();
    divergence_matrices.clear();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const auto &cell = space.cells()[c];
        groups[{cell.level, outflow_faces[c]}].push_back(c);
        if (cell.level >= masses.size())
          {
            masses.resize(cell.level + 1);
            divergence_matrices.resize(cell.level + 1);
          }
        if (divergence_matrices[cell.level].empty())
          {
            divergence_matrices[cell.level] = operators.divergence_matrix(cell.size);
            masses[cell.level] = operators.velocity_matrix(cell.size, given_terms.rho, 0., false);
          }
      }
    batches.clear();
    for (const auto &[key, cells] : groups)
      for (unsigned int first = 0; first < cells.size(); first += lanes)
        {
          CellBatch batch;
          batch.size          = space.cells()[cells[first]].size;
          batch.level         = key.first;
          batch.outflow_faces = key.second;
          batch.filled        = std::min<unsigned int>(lanes, cells.size() - first);
          for (unsigned int l = 0; l < lanes; ++l)
            {
              const unsigned int c = cells[first + std::min(l, batch.filled - 1)];
              batch.cells[l]       = c;
              for (unsigned int i = 0; i < n_u; ++i)
                batch.velocities[i * lanes + l] = space.velocity_dofs(c)[i];
              for (unsigned int k = 0; k < n_p; ++k)
                batch.pressures[k * lanes + l] = space.pressure_dofs(c)[k];
            }
          batches.push_back(batch);
        }
  }


  template <int dim>
  inline void
  FluidOperators<dim>::gather(const VelocityVector &u,
                              const CellBatch &batch,
                              Values (&local)[n_u]) const
  {
    for (unsigned int i = 0; i < n_u; ++i)
      local[i] = feib::gather(u.begin(), batch.velocities + i * lanes);
  }


  template <int dim>
  inline void
  FluidOperators<dim>::scatter_add(const Values (&local)[n_u],
                                   const CellBatch &batch,
                                   VelocityVector &r) const
  {
    for (unsigned int i = 0; i < n_u; ++i)
      feib::scatter_add(local[i], batch.velocities + i * lanes, batch.filled, r.begin());
  }


  template <int dim>
  void
  FluidOperators<dim>::velocity_form(const CellBatch &batch,
                                     const double rate,
                                     const double viscosity,
                                     const Values (&u)[n_u],
                                     Values (&out)[n_u]) const
  {
    apply_velocity_form<dim, double>({with_reconstruction ? 0. : rate * given_terms.rho,
                                      viscosity * given_terms.mu,
                                      given_terms.symmetric ? viscosity * given_terms.mu : 0.,
                                      viscosity * given_terms.grad_div},
                                     batch.size,
                                     u,
                                     out);
    if (with_reconstruction && rate != 0)
      {
        const std::vector<double> &mass = masses[batch.level];
        for (unsigned int i = 0; i < n_u; ++i)
          {
            Values sum = {};
            for (unsigned int j = 0; j < n_u; ++j)
              sum += mass[i * n_u + j] * u[j];
            out[i] += rate * sum;
          }
      }
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
        gather(u, batch, local);
        velocity_form(batch, rate, factor, local, product);
        scatter_add(product, batch, r);
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
        gather(u, batch, local);
        for (unsigned int k = 0; k < n_p; ++k)
          pressure[k] = feib::gather(p.begin(), batch.pressures + k * lanes);
        velocity_form(batch, rate, 1., local, product);
        const double measure = cell_volume(batch.size);
        for_directions<dim>([&](const auto a) {
          const double scale = measure / batch.size[a.value];
          apply_gradient<dim, a.value>(scale, pressure, force);
          feib::add_divergence<dim, a.value>(scale, local + a.value * n, divergence);
          for (unsigned int i = 0; i < n; ++i)
            product[a.value * n + i] = force[i] - product[a.value * n + i];
        });
        scatter_add(product, batch, r);
        for (unsigned int k = 0; k < n_p; ++k)
          feib::scatter_add(divergence[k], batch.pressures + k * lanes, batch.filled, g.begin());
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
        for (unsigned int k = 0; k < n_p; ++k)
          pressure[k] = feib::gather(p.begin(), batch.pressures + k * lanes);
        for_directions<dim>([&](const auto a) {
          apply_gradient<dim, a.value>(measure / batch.size[a.value],
                                       pressure,
                                       force + a.value * n);
        });
        scatter_add(force, batch, r);
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
        gather(u, batch, local);
        for_directions<dim>([&](const auto a) {
          feib::add_divergence<dim, a.value>(measure / batch.size[a.value],
                                             local + a.value * n,
                                             divergence);
        });
        for (unsigned int k = 0; k < n_p; ++k)
          feib::scatter_add(divergence[k], batch.pressures + k * lanes, batch.filled, g.begin());
      }
  }


  template <int dim>
  void
  FluidOperators<dim>::add_convection(const double factor,
                                      const VelocityVector &w,
                                      const VelocityVector &u,
                                      VelocityVector &r) const
  {
    for (const CellBatch &batch : batches)
      {
        Values local_w[n_u], local_u[n_u], product[n_u] = {};
        gather(w, batch, local_w);
        gather(u, batch, local_u);
        operators.add_convection(batch.size,
                                 local_w,
                                 local_u,
                                 factor * given_terms.rho,
                                 given_terms.convective_form,
                                 product,
                                 batch.outflow_faces);
        scatter_add(product, batch, r);
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
        gather(u, batch, local);
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
        gather(u, batch, local);
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
  typename FluidSolver<dim>::Balance
  FluidOperators<dim>::balance(const Space &space) const
  {
    typename FluidSolver<dim>::Balance result;
    for (const CellBatch &batch : batches)
      {
        const double measure = cell_volume(batch.size);
        Values u[n_u], product[n_u], energy = {}, divergence = {};
        gather(space.velocity, batch, u);
        velocity_form(batch, .5, 0., u, product);
        for (unsigned int i = 0; i < n_u; ++i)
          energy += u[i] * product[i];
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
            divergence += measure * operators.weights[q] * at_point * at_point;
          }
        Values mean[dim] = {}, moment[dim][dim] = {}; // int u_a, int x_b u_a from the cell's corner
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int j = operators.first[a]; j < operators.last[a]; ++j)
            {
              mean[a] += measure * operators.mean[a][j] * u[j];
              for (unsigned int b = 0; b < dim; ++b)
                moment[a][b] += measure * batch.size[b] * operators.moment[b][a][j] * u[j];
            }
        for (unsigned int l = 0; l < batch.filled; ++l)
          {
            const dealii::Point<dim> &lower = space.cells()[batch.cells[l]].lower;
            result.kinetic_energy += energy[l];
            result.divergence += divergence[l];
            const auto arm = [&](const unsigned int a, const unsigned int b) {
              return lower[b] * mean[a][l] + moment[a][b][l];
            };
            for (unsigned int a = 0; a < dim; ++a)
              result.momentum[a] += given_terms.rho * mean[a][l];
            result.angular_momentum[2] += given_terms.rho * (arm(1, 0) - arm(0, 1));
            if constexpr (dim == 3)
              {
                result.angular_momentum[0] += given_terms.rho * (arm(2, 1) - arm(1, 2));
                result.angular_momentum[1] += given_terms.rho * (arm(0, 2) - arm(2, 0));
              }
          }
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int l = 0; l < lanes; ++l)
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


  template <int dim>
  std::vector<double>
  FluidOperators<dim>::velocity_matrix(const Space &space,
                                       const unsigned int c,
                                       const double rate,
                                       const VelocityVector *w) const
  {
    const auto &cell           = space.cells()[c];
    std::vector<double> matrix = operators.velocity_matrix(cell.size,
                                                           rate * given_terms.rho,
                                                           given_terms.mu,
                                                           given_terms.symmetric,
                                                           given_terms.grad_div);
    if (w)
      {
        double local[n_u];
        for (unsigned int i = 0; i < n_u; ++i)
          local[i] = w->local_element(space.velocity_dofs(c)[i]);
        const std::vector<double> convection = operators.convection_matrix(
          cell.size, local, given_terms.rho, given_terms.convective_form, outflow_faces[c]);
        for (unsigned int i = 0; i < matrix.size(); ++i)
          matrix[i] += convection[i];
      }
    return matrix;
  }


  template class FluidOperators<2>;
  template class FluidOperators<3>;
} // namespace feib
