// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/reconstruction.h>

#include <algorithm>

namespace feib
{
  namespace
  {
    // |L_n|^2 / |N_n|^2; there is no N_0.
    constexpr double norm_ratio[3] = {0., 5 / 2., 21 / 2.};

    // L_n' = derivative[n] L_{n-1} up to degree 2.
    constexpr double derivative[3] = {0., 1., 3.};

    constexpr unsigned int stride[3] = {1, 3, 9};

    struct Digits
    {
      unsigned int values[27][3] = {};
      constexpr Digits()
      {
        for (unsigned int number = 0; number < 27; ++number)
          for (unsigned int a = 0; a < 3; ++a)
            values[number][a] = number / stride[a] % 3;
      }
    };
    constexpr Digits digits;

    /// The degree of a mode, or place of a node, in direction a.
    constexpr unsigned int
    digit(const unsigned int number, const unsigned int a)
    {
      return digits.values[number][a];
    }
  } // namespace


  template <int dim>
  Reconstruction<dim>::Reconstruction(const dealii::Tensor<1, dim> &size)
    : size(size)
    , factors()
  {
    for (unsigned int m = 0; m < n_modes; ++m)
      {
        unsigned int total = 0;
        double sum         = 0;
        for (unsigned int a = 0; a < dim; ++a)
          {
            total += digit(m, a);
            sum += norm_ratio[digit(m, a)] / (size[a] * size[a]);
          }
        for (unsigned int a = 0; a < dim; ++a)
          if (total > 1) // beyond P1
            factors[a][m] = norm_ratio[digit(m, a)] / (size[a] * size[a]) / sum * size[a] / 2;
        for (unsigned int j = 0; j < n_modes; ++j)
          {
            legendre[m][j] = 1;
            for (unsigned int a = 0; a < dim; ++a)
              legendre[m][j] *= line_modes[digit(m, a)][digit(j, a)];
          }
      }
  }


  template <int dim>
  void
  Reconstruction<dim>::modes(const dealii::Point<dim> &unit,
                             double (&L)[n_modes],
                             dealii::Tensor<1, dim> &bubble)
  {
    double line[dim][3];
    for (unsigned int a = 0; a < dim; ++a)
      {
        const double x = 2 * unit[a] - 1;
        bubble[a]      = (x * x - 1) / 2;
        line[a][0]     = 1;
        line[a][1]     = x;
        line[a][2]     = 3 * bubble[a] + 1;
      }
    for (unsigned int j = 0; j < 3; ++j)
      for (unsigned int i = 0; i < 3; ++i)
        L[3 * j + i] = line[0][i] * line[1][j];
    if constexpr (dim == 3)
      for (unsigned int k = 3; k-- > 0;) // the first nine last
        for (unsigned int m = 0; m < 9; ++m)
          L[9 * k + m] = line[2][k] * L[m];
  }


  template <int dim>
  void
  Reconstruction<dim>::coefficients(const double *v, Coefficients &result) const
  {
    double divergence[n_modes] = {}; // d_m
    for (unsigned int a = 0; a < dim; ++a)
      {
        for (unsigned int m = 0; m < n_modes; ++m)
          {
            double sum = 0;
            for (unsigned int j = 0; j < n_modes; ++j)
              sum += legendre[m][j] * v[a * n_modes + j];
            result.values[a][m]  = sum;
            result.bubbles[a][m] = 0;
          }
        for (unsigned int m = 0; m < n_modes; ++m)
          if (const unsigned int degree = digit(m, a); degree > 0)
            divergence[m - stride[a]] += 2 / size[a] * derivative[degree] * result.values[a][m];
      }
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int m = 0; m < n_modes; ++m)
        if (digit(m, a) > 0)
          result.bubbles[a][m - stride[a]] -= factors[a][m] * divergence[m];
  }


  template <int dim>
  void
  Reconstruction<dim>::weights(const Coefficients &functional, double *result) const
  {
    double divergence[n_modes] = {}; // what the functional makes of d_m
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int m = 0; m < n_modes; ++m)
        if (digit(m, a) > 0)
          divergence[m] -= factors[a][m] * functional.bubbles[a][m - stride[a]];
    for (unsigned int a = 0; a < dim; ++a)
      {
        double *component = result + a * n_modes;
        std::fill_n(component, n_modes, 0.);
        for (unsigned int m = 0; m < n_modes; ++m)
          {
            double value              = functional.values[a][m];
            const unsigned int degree = digit(m, a);
            if (degree > 0)
              value += 2 / size[a] * derivative[degree] * divergence[m - stride[a]];
            for (unsigned int j = 0; j < n_modes; ++j)
              component[j] += value * legendre[m][j];
          }
      }
  }


  template <int dim>
  void
  Reconstruction<dim>::weights(const dealii::Point<dim> &unit,
                               double (&result)[dim][n_velocity]) const
  {
    double L[n_modes];
    dealii::Tensor<1, dim> bubble;
    modes(unit, L, bubble);
    for (unsigned int i = 0; i < dim; ++i)
      {
        Coefficients functional = {};
        for (unsigned int m = 0; m < n_modes; ++m)
          {
            functional.values[i][m]  = L[m];
            functional.bubbles[i][m] = bubble[i] * L[m];
          }
        weights(functional, result[i]);
      }
  }


  template class Reconstruction<2>;
  template class Reconstruction<3>;
} // namespace feib
