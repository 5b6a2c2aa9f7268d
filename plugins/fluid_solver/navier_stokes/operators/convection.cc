// SPDX-License-Identifier: LGPL-2.1-or-later
#include "operators/convection.h"

#include <algorithm>

namespace feib
{
  template <int dim>
  Convection<dim>::Convection(const CellBatches<dim> &batches,
                              const CellOperators<dim> &operators,
                              const double rho,
                              const ConvectiveForm form)
    : batches(batches)
    , operators(operators)
    , rho(rho)
    , form(form)
  {}


  template <int dim>
  void
  Convection<dim>::reinit(const EulerianSpace<dim> &space)
  {
    const Domain<dim> &box = space.domain();
    dealii::Tensor<1, dim> size;
    for (unsigned int a = 0; a < dim; ++a)
      size[a] = (box.upper[a] - box.lower[a]) / box.cells[a];
    reconstruction.emplace(size);
    at_points.clear();
    at_nodes.resize(n_u * batches.n_open());
  }


  template <int dim>
  void
  Convection<dim>::set_velocity(const VelocityVector &w)
  {
    at_points.resize(batches.size() * n_stored<dim>(form));
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        const CellBatch &batch = batches[b];
        Values local[n_u];
        batch.gather(w, local);
        prepare_convection<dim>(form, batch.size, rho, local, &at_points[b * n_stored<dim>(form)]);
        if (batch.open_faces != 0)
          std::copy_n(local, n_u, &at_nodes[batch.open_number * n_u]);
      }
  }


  template <int dim>
  inline void
  Convection<dim>::convect(const Values *at_points,
                           const Values (&u)[n_u],
                           Values (&out)[n_u]) const
  {
    if (form == ConvectiveForm::rotational)
      add_rotational<dim>(*reconstruction, at_points, u, out);
    else
      add_skew_symmetric<dim>(at_points, u, out);
  }


  template <int dim>
  inline void
  Convection<dim>::convect_out(const CellBatch &batch,
                               const Values *at_nodes,
                               const Values *by,
                               const Values (&u)[n_u],
                               Values (&out)[n_u]) const
  {
    if (batch.open_faces != 0)
      operators.add_open_boundary(
        batch.size, batch.open_faces, batch.static_faces, rho, form, at_nodes, by, u, out);
  }


  template <int dim>
  void
  Convection<dim>::add(const double factor, const VelocityVector &u, VelocityVector &r) const
  {
    const unsigned int stride = n_stored<dim>(form);
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        Values local[n_u], product[n_u] = {};
        batches[b].gather(u, local);
        for (unsigned int i = 0; i < n_u; ++i)
          local[i] *= factor;
        convect(&at_points[b * stride], local, product);
        const Values *w = at_nodes.data() + batches[b].open_number * n_u;
        convect_out(batches[b], w, w, local, product);
        batches[b].scatter_add(product, r);
      }
  }


  template <int dim>
  void
  Convection<dim>::add_by(const double factor,
                          const VelocityVector &w,
                          const VelocityVector &u,
                          VelocityVector &r) const
  {
    for (const CellBatch &batch : batches)
      {
        Values local_w[n_u], local_u[n_u], stored[most_stored], product[n_u] = {};
        batch.gather(w, local_w);
        batch.gather(u, local_u);
        prepare_convection<dim>(form, batch.size, factor * rho, local_w, stored);
        convect(stored, local_u, product);
        if (batch.open_faces != 0)
          {
            for (unsigned int i = 0; i < n_u; ++i)
              local_w[i] *= factor;
            convect_out(batch, local_u, local_w, local_u, product);
          }
        batch.scatter_add(product, r);
      }
  }


  template <int dim>
  void
  Convection<dim>::add_dynamic_pressure(const double factor,
                                        const VelocityVector &u,
                                        PressureVector &p) const
  {
    for (const CellBatch &batch : batches)
      {
        Values local[n_u], square[n_points<dim>] = {};
        batch.gather(u, local);
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
            feib::scatter_add<double>(factor * rho / 2 * sum,
                                      batch.pressures + k * lanes,
                                      batch.filled,
                                      p.begin());
          }
      }
  }


  template <int dim>
  std::vector<double>
  Convection<dim>::matrix(const unsigned int cell, const VelocityVector &velocity) const
  {
    // Columns are what convection makes of unit vectors: a batch of them at once, with the cell's w
    // in every lane.
    const unsigned int batch = batches.place(cell) / lanes, lane = batches.place(cell) % lanes;
    const CellBatch &cells    = batches[batch];
    const unsigned int stride = n_stored<dim>(form);
    Values stored[most_stored], w[n_u], u[n_u];
    for (unsigned int i = 0; i < stride; ++i)
      stored[i] = Values{} + at_points[batch * stride + i][lane];
    for (unsigned int i = 0; i < n_u; ++i)
      {
        if (cells.open_faces != 0)
          w[i] = Values{} + at_nodes[cells.open_number * n_u + i][lane];
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
        prepare_convection<dim>(form, cells.size, rho, unit, by_unit);
        convect(by_unit, u, column);
        convect_out(cells, u, unit, u, column);
        for (unsigned int l = 0; l < filled; ++l)
          for (unsigned int i = 0; i < n_u; ++i)
            matrix[i * n_u + first + l] = column[i][l];
      }
    return matrix;
  }


  template class Convection<2>;
  template class Convection<3>;
} // namespace feib
