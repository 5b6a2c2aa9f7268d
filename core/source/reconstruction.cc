// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/reconstruction.h>

#include <algorithm>

namespace feib
{
  namespace
  {
    // Legendre coefficients, on [-1, 1], of the three shape functions of Q2 and of their
    // derivatives: [degree][function].
    constexpr double value_modes[3][3]      = {{1 / 6., 2 / 3., 1 / 6.},
                                               {-.5, 0., .5},
                                               {1 / 3., -2 / 3., 1 / 3.}};
    constexpr double derivative_modes[3][3] = {{-.5, 0., .5}, {1., -2., 1.}, {0., 0., 0.}};

    // |L_n|^2 / |N_n|^2; there is no N_0.
    constexpr double norm_ratio[3] = {0., 5 / 2., 21 / 2.};

    /// The digits of a tensor-product number, the first direction fastest.
    template <int dim>
    std::array<unsigned int, dim>
    degrees(unsigned int number)
    {
      std::array<unsigned int, dim> result;
      for (unsigned int a = 0; a < dim; ++a, number /= 3)
        result[a] = number % 3;
      return result;
    }
  } // namespace


  template <int dim>
  Reconstruction<dim>::Reconstruction(const dealii::Tensor<1, dim> &size)
    : divergence()
    , factors()
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    for (unsigned int m = 0; m < n_modes; ++m)
      {
        const auto degree  = degrees<dim>(m);
        unsigned int total = 0;
        double sum         = 0;
        for (unsigned int a = 0; a < dim; ++a)
          {
            total += degree[a];
            sum += norm_ratio[degree[a]] / (size[a] * size[a]);
          }
        if (total < 2) // P1
          continue;
        for (unsigned int a = 0; a < dim; ++a)
          {
            factors[a][m] =
              norm_ratio[degree[a]] / (size[a] * size[a]) / sum * size[a] / (2 * size[0]);
            for (unsigned int j = 0; j < n; ++j)
              {
                const auto node = degrees<dim>(j);
                double product  = 2 * size[0] / size[a];
                for (unsigned int b = 0; b < dim; ++b)
                  product *= (a == b ? derivative_modes : value_modes)[degree[b]][node[b]];
                divergence[m][a * n + j] = product;
              }
          }
      }
  }


  template <int dim>
  void
  Reconstruction<dim>::divergence_modes(const double *v, double *d) const
  {
    for (unsigned int m = 0; m < n_modes; ++m)
      {
        d[m] = 0;
        for (unsigned int j = 0; j < n_velocity; ++j)
          d[m] += divergence[m][j] * v[j];
      }
  }


  template <int dim>
  void
  Reconstruction<dim>::subtract_transpose(const double *d, double *v) const
  {
    for (unsigned int m = 0; m < n_modes; ++m)
      for (unsigned int j = 0; j < n_velocity; ++j)
        v[j] -= d[m] * divergence[m][j];
  }


  template <int dim>
  void
  Reconstruction<dim>::corrections(const dealii::Point<dim> &unit, double (&w)[dim][n_modes]) const
  {
    double L[dim][3], N[dim][3];
    for (unsigned int a = 0; a < dim; ++a)
      {
        const double x      = 2 * unit[a] - 1;
        const double bubble = (x * x - 1) / 2;
        L[a][0]             = 1;
        L[a][1]             = x;
        L[a][2]             = (3 * x * x - 1) / 2;
        N[a][0]             = 0;
        N[a][1]             = bubble;
        N[a][2]             = x * bubble;
      }
    for (unsigned int c = 0; c < dim; ++c)
      {
        const auto &f = c == 0 ? N[0] : L[0];
        const auto &g = c == 1 ? N[1] : L[1];
        if constexpr (dim == 2)
          {
            for (unsigned int j = 0; j < 3; ++j)
              for (unsigned int i = 0; i < 3; ++i)
                w[c][3 * j + i] = factors[c][3 * j + i] * f[i] * g[j];
          }
        else
          {
            const auto &h = c == 2 ? N[2] : L[2];
            for (unsigned int k = 0; k < 3; ++k)
              for (unsigned int j = 0; j < 3; ++j)
                for (unsigned int i = 0; i < 3; ++i)
                  w[c][9 * k + 3 * j + i] = factors[c][9 * k + 3 * j + i] * f[i] * g[j] * h[k];
          }
      }
  }


  template <int dim>
  void
  Reconstruction<dim>::weights(const dealii::Point<dim> &unit,
                               double (&result)[dim][n_velocity]) const
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    double values[n], w[dim][n_modes];
    EulerianSpace<dim>::shape_values(unit, values);
    corrections(unit, w);
    for (unsigned int a = 0; a < dim; ++a)
      {
        std::fill_n(result[a], n_velocity, 0.);
        std::copy_n(values, n, &result[a][a * n]);
        subtract_transpose(w[a], result[a]);
      }
  }


  template class Reconstruction<2>;
  template class Reconstruction<3>;
} // namespace feib
