// SPDX-License-Identifier: LGPL-2.1-or-later
#include "fluid_integrals.h"

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  template <int dim>
  typename FluidSolver<dim>::Balance
  fluid_balance(const EulerianSpace<dim> &space,
                const CellOperators<dim> &operators,
                const double rho)
  {
    constexpr unsigned int n = CellOperators<dim>::n, n_u = CellOperators<dim>::n_u;
    std::vector<std::vector<double>> masses; // rho M of each level
    typename FluidSolver<dim>::Balance result;
    double u[n_u];
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const auto &cell = space.cells()[c];
        if (cell.level >= masses.size())
          masses.resize(cell.level + 1);
        if (masses[cell.level].empty())
          masses[cell.level] = operators.velocity_matrix(cell.size, rho, 0., false);
        for (unsigned int i = 0; i < n_u; ++i)
          u[i] = space.velocity.local_element(space.velocity_dofs(c)[i]);
        result.kinetic_energy += .5 * CellOperators<dim>::quadratic_form(masses[cell.level], u);

        double det = 1;
        for (unsigned int a = 0; a < dim; ++a)
          det *= cell.size[a];
        for (unsigned int q = 0; q < CellOperators<dim>::n_q; ++q)
          {
            double divergence = 0;
            for (unsigned int a = 0; a < dim; ++a)
              {
                double derivative = 0;
                for (unsigned int i = 0; i < n; ++i)
                  derivative += operators.dphi[a][q][i] * u[a * n + i];
                divergence += derivative / cell.size[a];
              }
            result.divergence += det * operators.weights[q] * divergence * divergence;
          }
        double mean[dim] = {}, moment[dim][dim] = {}; // int u_a, int x_b u_a
        for (unsigned int a = 0; a < dim; ++a)
          {
            for (unsigned int j = 0; j < n_u; ++j)
              {
                mean[a] += det * operators.mean[a][j] * u[j];
                for (unsigned int b = 0; b < dim; ++b)
                  moment[a][b] += det *
                                  (cell.lower[b] * operators.mean[a][j] +
                                   cell.size[b] * operators.moment[b][a][j]) *
                                  u[j];
              }
            result.momentum[a] += rho * mean[a];
          }
        result.angular_momentum[2] += rho * (moment[1][0] - moment[0][1]);
        if constexpr (dim == 3)
          {
            result.angular_momentum[0] += rho * (moment[2][1] - moment[1][2]);
            result.angular_momentum[1] += rho * (moment[0][2] - moment[2][0]);
          }
        for (unsigned int i = 0; i < n; ++i)
          {
            double square = 0, rate = 0;
            for (unsigned int a = 0; a < dim; ++a)
              {
                square += u[a * n + i] * u[a * n + i];
                rate += std::abs(u[a * n + i]) / cell.size[a];
              }
            result.largest_velocity = std::max(result.largest_velocity, square);
            result.cfl_rate         = std::max(result.cfl_rate, rate);
          }
      }
    const MPI_Comm communicator = space.communicator();
    result.kinetic_energy       = dealii::Utilities::MPI::sum(result.kinetic_energy, communicator);
    result.divergence = std::sqrt(dealii::Utilities::MPI::sum(result.divergence, communicator));
    result.momentum   = dealii::Utilities::MPI::sum(result.momentum, communicator);
    result.angular_momentum = dealii::Utilities::MPI::sum(result.angular_momentum, communicator);
    result.largest_velocity =
      std::sqrt(dealii::Utilities::MPI::max(result.largest_velocity, communicator));
    result.cfl_rate = dealii::Utilities::MPI::max(result.cfl_rate, communicator);
    return result;
  }


  template <int dim>
  VelocityVector
  load_of_body_force(const EulerianSpace<dim> &space,
                     const dealii::Function<dim> &force,
                     const Reconstruction<dim> *reconstruction)
  {
    constexpr unsigned int n_u = EulerianSpace<dim>::n_velocity;
    VelocityVector result      = space.make_velocity();
    const dealii::QGauss<dim> quadrature(reconstruction ? 8 : 4);
    struct Values
    {
      double of[dim][n_u];
    };
    std::vector<Values> tested(quadrature.size());
    for (unsigned int q = 0; q < quadrature.size(); ++q)
      velocity_values<dim>(reconstruction, quadrature.point(q), tested[q].of);
    std::vector<dealii::Point<dim>> points(quadrature.size());
    std::vector<dealii::Vector<double>> forces(quadrature.size(), dealii::Vector<double>(dim));
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const auto &cell = space.cells()[c];
        double det       = 1;
        for (unsigned int a = 0; a < dim; ++a)
          det *= cell.size[a];
        for (unsigned int q = 0; q < quadrature.size(); ++q)
          for (unsigned int a = 0; a < dim; ++a)
            points[q][a] = cell.lower[a] + cell.size[a] * quadrature.point(q)[a];
        force.vector_value_list(points, forces);
        double local[n_u] = {};
        for (unsigned int q = 0; q < quadrature.size(); ++q)
          for (unsigned int a = 0; a < dim; ++a)
            for (unsigned int i = 0; i < n_u; ++i)
              local[i] += det * quadrature.weight(q) * forces[q][a] * tested[q].of[a][i];
        for (unsigned int i = 0; i < n_u; ++i)
          result.local_element(space.velocity_dofs(c)[i]) += local[i];
      }
    result.compress(dealii::VectorOperation::add);
    return result;
  }


  template FluidSolver<2>::Balance
  fluid_balance(const EulerianSpace<2> &, const CellOperators<2> &, double);
  template VelocityVector load_of_body_force(const EulerianSpace<2> &,
                                             const dealii::Function<2> &,
                                             const Reconstruction<2> *);

  template FluidSolver<3>::Balance
  fluid_balance(const EulerianSpace<3> &, const CellOperators<3> &, double);
  template VelocityVector load_of_body_force(const EulerianSpace<3> &,
                                             const dealii::Function<3> &,
                                             const Reconstruction<3> *);
} // namespace feib
