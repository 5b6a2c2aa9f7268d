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
  FluidOperators<dim>::reinit(const Space &space)
  {
    const Domain<dim> &box = space.domain();
    communicator           = space.communicator();
    std::map<std::pair<unsigned int, unsigned int>, std::vector<unsigned int>> groups;
    divergence_matrices.clear();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const auto &cell        = space.cells()[c];
        unsigned int open_faces = 0;
        for (unsigned int f = 0; f < 2 * dim; ++f)
          if (box.faces[f].condition == BoundaryCondition::outflow)
            {
              const double distance = f % 2 == 0
                                        ? cell.lower[f / 2] - box.lower[f / 2]
                                        : box.upper[f / 2] - cell.lower[f / 2] - cell.size[f / 2];
              if (std::abs(distance) < .5 * cell.size[f / 2])
                open_faces |= 1U << f;
            }
        groups[{cell.level, open_faces}].push_back(c);
        if (cell.level >= divergence_matrices.size())
          divergence_matrices.resize(cell.level + 1);
        if (divergence_matrices[cell.level].empty())
          divergence_matrices[cell.level] = operators.divergence_matrix(cell.size);
      }
    batches.clear();
    place_of_cell.resize(space.cells().size());
    unsigned int n_open = 0;
    for (const auto &[key, cells] : groups)
      for (unsigned int first = 0; first < cells.size(); first += lanes)
        {
          CellBatch batch;
          batch.size       = space.cells()[cells[first]].size;
          batch.level      = key.first;
          batch.open_faces = key.second;
          batch.first_open = n_open;
          if (batch.open_faces != 0)
            n_open += n_u;
          batch.filled = std::min<unsigned int>(lanes, cells.size() - first);
          for (unsigned int l = 0; l < lanes; ++l)
            {
              const unsigned int c = cells[first + std::min(l, batch.filled - 1)];
              batch.cells[l]       = c;
              if (l < batch.filled)
                place_of_cell[c] = batches.size() * lanes + l;
              for (unsigned int i = 0; i < n_u; ++i)
                batch.velocities[i * lanes + l] = space.velocity_dofs(c)[i];
              for (unsigned int k = 0; k < n_p; ++k)
                batch.pressures[k * lanes + l] = space.pressure_dofs(c)[k];
            }
          batches.push_back(batch);
        }
    dealii::Tensor<1, dim> size;
    for (unsigned int a = 0; a < dim; ++a)
      size[a] = (box.upper[a] - box.lower[a]) / box.cells[a];
    reconstruction.emplace(size);
    at_points.clear();
    at_nodes.resize(n_open);
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
  FluidOperators<dim>::set_convecting_velocity(const VelocityVector &w)
  {
    const ConvectiveForm form = given_terms.convective_form;
    at_points.resize(batches.size() * n_stored<dim>(form));
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        const CellBatch &batch = batches[b];
        Values local[n_u];
        gather(w, batch, local);
        prepare_convection<dim>(
          form, batch.size, given_terms.rho, local, &at_points[b * n_stored<dim>(form)]);
        if (batch.open_faces != 0)
          std::copy_n(local, n_u, &at_nodes[batch.first_open]);
      }
  }


  template <int dim>
  inline void
  FluidOperators<dim>::convect(const Values *at_points,
                               const Values (&u)[n_u],
                               Values (&out)[n_u]) const
  {
    if (given_terms.convective_form == ConvectiveForm::rotational)
      add_rotational<dim>(*reconstruction, at_points, u, out);
    else
      add_skew_symmetric<dim>(at_points, u, out);
  }


  template <int dim>
  inline void
  FluidOperators<dim>::convect_out(const CellBatch &batch,
                                   const Values *at_nodes,
                                   const Values *by,
                                   const Values (&u)[n_u],
                                   Values (&out)[n_u]) const
  {
    if (batch.open_faces != 0)
      operators.add_open_boundary(batch.size,
                                  batch.open_faces,
                                  given_terms.rho,
                                  given_terms.convective_form,
                                  at_nodes,
                                  by,
                                  u,
                                  out);
  }


  template <int dim>
  void
  FluidOperators<dim>::add_convection(const double factor,
                                      const VelocityVector &u,
                                      VelocityVector &r) const
  {
    const unsigned int stride = n_stored<dim>(given_terms.convective_form);
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        Values local[n_u], product[n_u] = {};
        gather(u, batches[b], local);
        for (unsigned int i = 0; i < n_u; ++i)
          local[i] *= factor;
        convect(&at_points[b * stride], local, product);
        const Values *w = at_nodes.data() + batches[b].first_open;
        convect_out(batches[b], w, w, local, product);
        scatter_add(product, batches[b], r);
      }
  }


  template <int dim>
  void
  FluidOperators<dim>::add_convection_by(const double factor,
                                         const VelocityVector &w,
                                         const VelocityVector &u,
                                         VelocityVector &r) const
  {
    for (const CellBatch &batch : batches)
      {
        Values local_w[n_u], local_u[n_u], stored[most_stored], product[n_u] = {};
        gather(w, batch, local_w);
        gather(u, batch, local_u);
        prepare_convection<dim>(
          given_terms.convective_form, batch.size, factor * given_terms.rho, local_w, stored);
        convect(stored, local_u, product);
        if (batch.open_faces != 0)
          {
            for (unsigned int i = 0; i < n_u; ++i)
              local_w[i] *= factor;
            convect_out(batch, local_u, local_w, local_u, product);
          }
        scatter_add(product, batch, r);
      }
  }


  template <int dim>
  void
  FluidOperators<dim>::add_dynamic_pressure(const double factor,
                                            const VelocityVector &u,
                                            PressureVector &p) const
  {
    for (const CellBatch &batch : batches)
      {
        Values local[n_u], square[n_points<dim>] = {};
        gather(u, batch, local);
        for (unsigned int a = 0; a < dim; ++a)
          {
            Values at[n_points<dim>];
            feib::at_points<dim, false, dim>(local + a * n, at);
            for (unsigned int q = 0; q < n_points<dim>; ++q)
              square[q] += at[q] * at[q];
          }
        // The functions of the pressure are orthonormal on the unit cell.
        for (unsigned int k = 0; k < n_p; ++k)
          {
            Values sum = {};
            for (unsigned int q = 0; q < n_points<dim>; ++q)
              {
                const unsigned int place[3] = {q % 4, q / 4 % 4, q / 16};
                const double function =
                  k == 0 ? 1. : LineMatrices::root / 2 * PointMatrices::x[place[k - 1]];
                sum += point_weight<dim>(q) * function * square[q];
              }
            feib::scatter_add<double>(factor * given_terms.rho / 2 * sum,
                                      batch.pressures + k * lanes,
                                      batch.filled,
                                      p.begin());
          }
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
          for (unsigned int j = 0; j < n; ++j)
            {
              mean[a] += measure * operators.mean[j] * u[a * n + j];
              for (unsigned int b = 0; b < dim; ++b)
                moment[a][b] += measure * batch.size[b] * operators.moment[b][j] * u[a * n + j];
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
  FluidOperators<dim>::convection_matrix(const unsigned int cell,
                                         const VelocityVector &velocity) const
  {
    // Columns are what convection makes of unit vectors: a batch of them at once, with the cell's w
    // in every lane.
    const unsigned int batch = place_of_cell[cell] / lanes, lane = place_of_cell[cell] % lanes;
    const CellBatch &cells    = batches[batch];
    const unsigned int stride = n_stored<dim>(given_terms.convective_form);
    Values stored[most_stored], w[n_u], u[n_u];
    for (unsigned int i = 0; i < stride; ++i)
      stored[i] = Values{} + at_points[batch * stride + i][lane];
    for (unsigned int i = 0; i < n_u; ++i)
      {
        if (cells.open_faces != 0)
          w[i] = Values{} + at_nodes[cells.first_open + i][lane];
        u[i] = Values{} + velocity.begin()[cells.velocities[i * lanes + lane]];
      }
    std::vector<double> matrix(n_u * n_u);
    for (unsigned int first = 0; first < n_u; first += lanes)
      {
        const unsigned int filled = std::min(lanes, n_u - first);
        Values unit[n_u] = {}, column[n_u] = {};
        for (unsigned int l = 0; l < filled; ++l)
          unit[first + l][l] = 1;
        convect(stored, unit, column);
        convect_out(cells, w, w, unit, column);
        Values by_unit[most_stored];
        prepare_convection<dim>(
          given_terms.convective_form, cells.size, given_terms.rho, unit, by_unit);
        convect(by_unit, u, column);
        convect_out(cells, u, unit, u, column);
        for (unsigned int l = 0; l < filled; ++l)
          for (unsigned int i = 0; i < n_u; ++i)
            matrix[i * n_u + first + l] = column[i][l];
      }
    return matrix;
  }


  template class FluidOperators<2>;
  template class FluidOperators<3>;
} // namespace feib
