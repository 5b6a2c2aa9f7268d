// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_fields_h
#define feib_testing_fields_h

#include <feib/testing/spaces.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_values.h>

namespace feib::testing
{
  /// A domain whose faces are all open, so that no value is prescribed. @p cells: base cells, JSON.
  template <int dim>
  std::string
  open_box(const std::string &cells)
  {
    std::string faces;
    for (const char *face : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
      if (dim == 3 || face[0] != 'z')
        faces += (faces.empty() ? "\"" : ", \"") + std::string(face) + R"(": {"outflow": {}})";
    return R"({"cells": )" + cells + R"(, "boundary": {)" + faces + "}}";
  }

  /// Fields that the spaces hold exactly.
  template <int dim>
  dealii::Tensor<1, dim>
  exact_velocity(const dealii::Point<dim> &x)
  {
    dealii::Tensor<1, dim> u;
    u[0] = 1 + x[0] * x[0] - 2 * x[0] * x[1];
    u[1] = x[1] * x[1] + 3 * x[0] - x[dim - 1];
    u[dim - 1] += .5 * x[0] * x[dim - 1];
    return u;
  }

  template <int dim>
  double
  exact_pressure(const dealii::Point<dim> &x)
  {
    return 2 - x[0] + 3 * x[1] + .5 * x[dim - 1];
  }

  /// Calls @p visit with each velocity node of each locally owned cell: its place, and the index
  /// (VelocityVector::local_element) of its first component; those of the others are n_nodes
  /// further in velocity_dofs().
  template <int dim, typename Visit>
  void
  for_each_node(const EulerianSpace<dim> &space, const Visit &visit)
  {
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < EulerianSpace<dim>::n_nodes; ++i)
        {
          dealii::Point<dim> x = space.cells()[c].lower;
          unsigned int rest    = i;
          for (unsigned int a = 0; a < dim; ++a, rest /= 3)
            x[a] += space.cells()[c].size[a] * (rest % 3) / 2.;
          visit(x, space.velocity_dofs(c) + i);
        }
  }

  /// Sets u to f at the nodes, but to what the constraints say where there are any.
  template <int dim, typename Function>
  void
  set_velocity(const EulerianSpace<dim> &space, VelocityVector &u, const Function &f)
  {
    u.zero_out_ghost_values();
    for_each_node(space, [&](const dealii::Point<dim> &x, const unsigned int *dofs) {
      const dealii::Tensor<1, dim> value = f(x);
      for (unsigned int a = 0; a < dim; ++a)
        if (const auto dof = dofs[a * EulerianSpace<dim>::n_nodes]; dof < u.locally_owned_size())
          u.local_element(dof) = value[a];
    });
    space.distribute(u, false);
  }

  /// Sets p to the affine function f.
  template <int dim, typename Function>
  void
  set_pressure(const EulerianSpace<dim> &space, PressureVector &p, const Function &f)
  {
    const dealii::FiniteElement<dim> &fe = space.pressure_handler().get_fe();
    p.zero_out_ghost_values();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const auto &cell         = space.cells()[c];
        const unsigned int *dofs = space.pressure_dofs(c);
        p.local_element(dofs[0]) = f(cell.lower + .5 * cell.size);
        for (unsigned int a = 0; a < dim; ++a)
          {
            dealii::Point<dim> low, high;
            high[a] = 1;
            dealii::Tensor<1, dim> edge;
            edge[a]                      = cell.size[a];
            const double slope           = fe.shape_value(1 + a, high) - fe.shape_value(1 + a, low);
            p.local_element(dofs[1 + a]) = (f(cell.lower + edge) - f(cell.lower)) / slope;
          }
      }
    p.update_ghost_values();
  }

  /// The largest difference between u and f at the nodes, of all ranks.
  template <int dim, typename Function>
  double
  distance_at_nodes(const EulerianSpace<dim> &space, const VelocityVector &u, const Function &f)
  {
    double largest = 0;
    for_each_node(space, [&](const dealii::Point<dim> &x, const unsigned int *dofs) {
      const dealii::Tensor<1, dim> value = f(x);
      for (unsigned int a = 0; a < dim; ++a)
        largest =
          std::max(largest,
                   std::abs(u.local_element(dofs[a * EulerianSpace<dim>::n_nodes]) - value[a]));
    });
    return dealii::Utilities::MPI::max(largest, space.communicator());
  }

  /// Calls @p visit with each locally owned cell (of the velocity space) and the values of velocity
  /// and pressure space on it, at the points of a rule that is exact for polynomials of degree 7.
  template <int dim, typename Visit>
  void
  for_each_cell(const EulerianSpace<dim> &space, const Visit &visit)
  {
    using namespace dealii;
    const QGauss<dim> rule(4);
    FEValues<dim> u(space.mapping(),
                    space.velocity_handler().get_fe(),
                    rule,
                    update_values | update_gradients | update_quadrature_points |
                      update_JxW_values),
      p(space.mapping(), space.pressure_handler().get_fe(), rule, update_values);
    auto of_pressure = space.pressure_handler().begin_active();
    for (const auto &cell : space.velocity_handler().active_cell_iterators())
      {
        if (cell->is_locally_owned())
          {
            u.reinit(cell);
            p.reinit(of_pressure);
            visit(cell, u, p);
          }
        ++of_pressure;
      }
  }

  /// <f, v> for all v, before condensing.
  template <int dim, typename Function>
  VelocityVector
  load_of(const EulerianSpace<dim> &space, const Function &f)
  {
    VelocityVector load = space.make_velocity();
    std::vector<dealii::types::global_dof_index> dofs(EulerianSpace<dim>::n_velocity);
    for_each_cell(space, [&](const auto &cell, const dealii::FEValues<dim> &u, const auto &) {
      cell->get_dof_indices(dofs);
      for (unsigned int q = 0; q < u.n_quadrature_points; ++q)
        {
          const dealii::Tensor<1, dim> value = f(u.quadrature_point(q));
          for (unsigned int i = 0; i < dofs.size(); ++i)
            load(dofs[i]) +=
              u.JxW(q) * u.shape_value(i, q) * value[u.get_fe().system_to_component_index(i).first];
        }
    });
    load.compress(dealii::VectorOperation::add);
    return load;
  }

  /// A partly refined mesh of an open box with the exact fields.
  template <int dim>
  std::unique_ptr<EulerianSpace<dim>>
  make_state(const MPI_Comm communicator = MPI_COMM_WORLD)
  {
    auto space = make_space<dim>(open_box<dim>(dim == 2 ? "[4, 3]" : "[2, 3, 2]"), communicator);
    refine_where(*space, [](const auto &x) { return x[0] < .5; });
    set_velocity(*space, space->velocity, exact_velocity<dim>);
    set_pressure(*space, space->pressure, exact_pressure<dim>);
    return space;
  }
} // namespace feib::testing

#endif
