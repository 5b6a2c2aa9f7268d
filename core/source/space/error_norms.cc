// SPDX-License-Identifier: LGPL-2.1-or-later
#include "error_norms.h"

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_values.h>

#include <array>
#include <cmath>

namespace feib
{
  template <int dim>
  ErrorNorms
  error_norms(const EulerianSpace<dim> &space,
              const double time,
              dealii::Function<dim> &velocity,
              dealii::Function<dim> *pressure)
  {
    // Kinks of exact pressures cut through cells: a fine composite rule.
    const dealii::QIterated<dim> quadrature(dealii::QGauss<1>(3), 4);
    dealii::FEValues<dim> velocity_values(space.mapping(),
                                          space.velocity_handler().get_fe(),
                                          quadrature,
                                          dealii::update_values | dealii::update_gradients |
                                            dealii::update_quadrature_points |
                                            dealii::update_JxW_values);
    dealii::FEValues<dim> pressure_values(space.mapping(),
                                          space.pressure_handler().get_fe(),
                                          quadrature,
                                          dealii::update_values);
    const dealii::FEValuesExtractors::Vector velocities(0);
    const unsigned int n_q = quadrature.size();
    std::vector<dealii::Tensor<1, dim>> u(n_q);
    std::vector<dealii::Tensor<2, dim>> gradients(n_q);
    std::vector<double> p(n_q);
    constexpr double epsilon = 1e-3; // of a cell, to differentiate to fourth order
    // |u|^2, |grad u|^2, int (p - p_h)^2, int (p - p_h), volume
    std::array<double, 5> sums{};

    velocity.set_time(time);
    if (pressure)
      pressure->set_time(time);
    dealii::Vector<double> exact(dim), forward(dim), backward(dim);
    for (const auto &cell : space.velocity_handler().active_cell_iterators())
      if (cell->is_locally_owned())
        {
          velocity_values.reinit(cell);
          velocity_values[velocities].get_function_values(space.velocity, u);
          velocity_values[velocities].get_function_gradients(space.velocity, gradients);
          const typename dealii::DoFHandler<dim>::active_cell_iterator pressure_cell(
            &space.triangulation(), cell->level(), cell->index(), &space.pressure_handler());
          pressure_values.reinit(pressure_cell);
          pressure_values.get_function_values(space.pressure, p);
          const double h = epsilon * cell->extent_in_direction(0);
          for (unsigned int q = 0; q < n_q; ++q)
            {
              const double weight         = velocity_values.JxW(q);
              const dealii::Point<dim> &x = velocity_values.quadrature_point(q);
              velocity.vector_value(x, exact);
              for (unsigned int a = 0; a < dim; ++a)
                sums[0] += weight * std::pow(u[q][a] - exact[a], 2);
              for (unsigned int b = 0; b < dim; ++b)
                {
                  dealii::Tensor<1, dim> shift;
                  shift[b] = h;
                  dealii::Tensor<1, dim> derivative;
                  for (const auto &[steps, factor] : {std::pair(1, 8.), std::pair(2, -1.)})
                    {
                      velocity.vector_value(x + steps * shift, forward);
                      velocity.vector_value(x - steps * shift, backward);
                      for (unsigned int a = 0; a < dim; ++a)
                        derivative[a] += factor * (forward[a] - backward[a]) / (12 * h);
                    }
                  for (unsigned int a = 0; a < dim; ++a)
                    sums[1] += weight * std::pow(gradients[q][a][b] - derivative[a], 2);
                }
              if (pressure)
                {
                  const double error = p[q] - pressure->value(x);
                  sums[2] += weight * error * error;
                  sums[3] += weight * error;
                }
              sums[4] += weight;
            }
        }
    for (double &sum : sums)
      sum = dealii::Utilities::MPI::sum(sum, space.communicator());
    if (space.domain().enclosed())
      sums[2] = std::max(0., sums[2] - sums[3] * sums[3] / sums[4]);
    return {std::sqrt(sums[0]), std::sqrt(sums[1]), std::sqrt(sums[2])};
  }


  template <int dim>
  Issues
  issues_inside(const EulerianSpace<dim> &space, Expressions<dim> &expressions, const double time)
  {
    const dealii::QGauss<dim> points(3);
    dealii::Vector<double> value(expressions.n_components);
    expressions.set_time(time);
    for (const auto &cell : space.cells())
      for (const dealii::Point<dim> &unit : points.get_points())
        {
          dealii::Point<dim> x = cell.lower;
          for (unsigned int a = 0; a < dim; ++a)
            x[a] += cell.size[a] * unit[a];
          expressions.vector_value(x, value);
        }
    return expressions.not_finite(space.communicator());
  }


  template Issues issues_inside(const EulerianSpace<2> &, Expressions<2> &, double);
  template Issues issues_inside(const EulerianSpace<3> &, Expressions<3> &, double);
  template ErrorNorms
  error_norms<2>(const EulerianSpace<2> &, double, dealii::Function<2> &, dealii::Function<2> *);
  template ErrorNorms
  error_norms<3>(const EulerianSpace<3> &, double, dealii::Function<3> &, dealii::Function<3> *);
} // namespace feib
