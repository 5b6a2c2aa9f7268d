// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/structure_model/moments.h>

#include <deal.II/base/derivative_form.h>

#include <cmath>

namespace feib
{
  template <int structure_dim, int dim>
  Moments<dim>
  moments(const LagrangianMesh<dim> &mesh, const Positions<dim> &X)
  {
    constexpr unsigned int m = structure_dim;
    // A closed curve or surface encloses the cones over its elements with a common tip, X[0].
    const bool cones = m < dim && mesh.closed();
    Moments<dim> result;
    double gross = 0;
    for (const auto &element : mesh.elements())
      {
        dealii::Tensor<2, dim> edges;
        dealii::Tensor<1, dim> sum;
        dealii::SymmetricTensor<2, dim> squares;
        for (unsigned int k = 0; k <= m; ++k)
          {
            const dealii::Tensor<1, dim> x = X[element.nodes[k]] - X[0];
            sum += x;
            squares += symmetrize(outer_product(x, x));
          }
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
        // Of a simplex with n corners; that of a cone is X[0].
        const unsigned int n = cones ? dim + 1 : m + 1;
        gross += std::abs(size);
        result.measure += size;
        result.first += size / n * sum;
        result.second += size / (n * (n + 1)) * (squares + symmetrize(outer_product(sum, sum)));
      }
    if (std::abs(result.measure) < 1e-12 * gross)
      result.measure = 0; // but for round-off
    return result;
  }


  template Moments<2> moments<1, 2>(const LagrangianMesh<2> &, const Positions<2> &);
  template Moments<2> moments<2, 2>(const LagrangianMesh<2> &, const Positions<2> &);
  template Moments<3> moments<2, 3>(const LagrangianMesh<3> &, const Positions<3> &);
  template Moments<3> moments<3, 3>(const LagrangianMesh<3> &, const Positions<3> &);
} // namespace feib
