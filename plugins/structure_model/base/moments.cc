// SPDX-License-Identifier: LGPL-2.1-or-later
#include "moments.h"

#include <deal.II/base/derivative_form.h>

namespace feib
{
  template <int structure_dim, int dim>
  std::pair<double, dealii::Tensor<1, dim>>
  moments(const LagrangianMesh<dim> &mesh, const Positions<dim> &X)
  {
    constexpr unsigned int m = structure_dim;
    // A closed curve or surface encloses the cones over its elements with a common tip, X[0].
    const bool cones = m < dim && mesh.closed();
    std::pair<double, dealii::Tensor<1, dim>> result;
    for (const auto &element : mesh.elements())
      {
        dealii::Tensor<2, dim> edges;
        dealii::Tensor<1, dim> sum;
        for (unsigned int k = 0; k <= m; ++k)
          sum += X[element.nodes[k]] - X[0];
        double size;
        if (m == dim || cones)
          {
            for (unsigned int k = 0; k < dim; ++k)
              edges[k] =
                cones ? X[element.nodes[k]] - X[0] : X[element.nodes[k + 1]] - X[element.nodes[0]];
            size = determinant(edges) / (dim == 2 ? 2 : 6);
          }
        else
          {
            dealii::DerivativeForm<1, structure_dim, dim> map;
            for (unsigned int k = 0; k < m; ++k)
              for (unsigned int i = 0; i < dim; ++i)
                map[i][k] = X[element.nodes[k + 1]][i] - X[element.nodes[0]][i];
            size = map.determinant() / m;
          }
        result.first += size;
        result.second += size / (cones ? dim + 1 : m + 1) * sum;
      }
    return result;
  }


  template std::pair<double, dealii::Tensor<1, 2>> moments<1, 2>(const LagrangianMesh<2> &,
                                                                 const Positions<2> &);
  template std::pair<double, dealii::Tensor<1, 2>> moments<2, 2>(const LagrangianMesh<2> &,
                                                                 const Positions<2> &);
  template std::pair<double, dealii::Tensor<1, 3>> moments<2, 3>(const LagrangianMesh<3> &,
                                                                 const Positions<3> &);
  template std::pair<double, dealii::Tensor<1, 3>> moments<3, 3>(const LagrangianMesh<3> &,
                                                                 const Positions<3> &);
} // namespace feib
