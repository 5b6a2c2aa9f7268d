// SPDX-License-Identifier: LGPL-2.1-or-later
#include "resolution.h"

#include <feib/reconstruction.h>

#include <deal.II/base/mpi.h>

#include <algorithm>

namespace feib
{
  template <int dim>
  double
  roughness(const EulerianSpace<dim> &space)
  {
    // Squares of the norms of L_0, L_1, L_2 on a line.
    constexpr double squares[3] = {1, 1 / 3., 1 / 5.};
    constexpr unsigned int n    = EulerianSpace<dim>::n_nodes;

    double linear = 0, rest = 0, mean = 0; // squares of the parts of the velocity
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        double volume = 1;
        for (unsigned int a = 0; a < dim; ++a)
          volume *= space.cells()[c].size[a];
        const unsigned int *const dofs = space.velocity_dofs(c);
        for (unsigned int component = 0; component < dim; ++component)
          {
            double values[n], transformed[n];
            for (unsigned int j = 0; j < n; ++j)
              values[j] = space.velocity.local_element(dofs[component * n + j]);
            for (unsigned int a = 0, stride = 1; a < dim; ++a, stride *= 3)
              {
                for (unsigned int j = 0; j < n; ++j)
                  {
                    const unsigned int degree = j / stride % 3, first = j - degree * stride;
                    transformed[j] = 0;
                    for (unsigned int k = 0; k < 3; ++k)
                      transformed[j] += line_modes[degree][k] * values[first + k * stride];
                  }
                std::copy(transformed, transformed + n, values);
              }
            mean += volume * values[0] * values[0];
            for (unsigned int m = 1; m < n; ++m)
              {
                double square      = volume * values[m] * values[m];
                unsigned int total = 0;
                for (unsigned int a = 0, stride = 1; a < dim; ++a, stride *= 3)
                  {
                    square *= squares[m / stride % 3];
                    total += m / stride % 3;
                  }
                (total == 1 ? linear : rest) += square;
              }
          }
      }
    linear = dealii::Utilities::MPI::sum(linear, space.communicator());
    rest   = dealii::Utilities::MPI::sum(rest, space.communicator());
    mean   = dealii::Utilities::MPI::sum(mean, space.communicator());
    // A uniform stream varies by what the solver leaves.
    return linear + rest > 1e-8 * mean ? rest / (linear + rest) : 0;
  }


  template double roughness(const EulerianSpace<2> &);
  template double roughness(const EulerianSpace<3> &);
} // namespace feib
