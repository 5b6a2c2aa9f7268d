// SPDX-License-Identifier: LGPL-2.1-or-later
#include "body_force_load.h"

#include "cell_kernels.h"

#include <deal.II/base/quadrature_lib.h>

namespace feib
{
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
        const double det = cell_volume(cell.size);
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


  template VelocityVector load_of_body_force(const EulerianSpace<2> &,
                                             const dealii::Function<2> &,
                                             const Reconstruction<2> *);

  template VelocityVector load_of_body_force(const EulerianSpace<3> &,
                                             const dealii::Function<3> &,
                                             const Reconstruction<3> *);
} // namespace feib
