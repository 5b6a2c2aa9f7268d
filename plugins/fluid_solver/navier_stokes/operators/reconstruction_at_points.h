// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_reconstruction_at_points_h
#define feib_plugins_navier_stokes_reconstruction_at_points_h

#include "operators/cell_kernels.h"
#include "operators/point_kernels.h"

#include <feib/reconstruction.h>

namespace feib
{
  /// R of reconstruction.h at the points. In component i, its bubbles beta(x_i) L_0 and
  /// beta(x_i) L_1 are (L_2 - L_0)/3 and N_2: R u has the functions L_0, L_1, L_2, N_2 in direction
  /// i, and L_0, L_1, L_2 in the others.
  template <int dim>
  struct ReconstructionAtPoints
  {
    static constexpr unsigned int n         = dim == 2 ? 9 : 27;
    static constexpr unsigned int stride[3] = {1, 3, 9};

    // What a coefficient of L_1, L_2 gives in the derivative, to L_0, L_1.
    static constexpr double derivative[3] = {0., 1., 3.};

    static constexpr unsigned int
    digit(const unsigned int m, const unsigned int a)
    {
      return m / stride[a] % 3;
    }

    static constexpr unsigned int
    extent(const unsigned int i, const unsigned int a)
    {
      return i == a ? 4 : 3;
    }

    /// The place of mode m among the coefficients of component i, with its degree in direction i
    /// raised by @p raise.
    static constexpr unsigned int
    place(const unsigned int i, const unsigned int m, const unsigned int raise = 0)
    {
      unsigned int result = 0, step = 1;
      for (unsigned int a = 0; a < dim; ++a)
        {
          result += (digit(m, a) + (a == i ? raise : 0)) * step;
          step *= extent(i, a);
        }
      return result;
    }

    static constexpr unsigned int n_coefficients = 4 * n / 3;

    /// @p size: the edges of a cell.
    explicit ReconstructionAtPoints(const dealii::Tensor<1, dim> &size)
    {
      const Reconstruction<dim> reconstruction(size);
      for (unsigned int a = 0; a < dim; ++a)
        {
          slope[a] = 2 / size[a];
          for (unsigned int m = 0; m < n; ++m)
            factors[a][m] = -reconstruction.factor(a, m);
        }
    }

    /// Legendre coefficients of Q2 functions, or (transpose) back.
    template <bool transpose, typename V>
    static void
    to_modes(const V *in, V *out)
    {
      V s[n];
      contract<transpose, false, 1, n / 3>(line_modes, in, s);
      if constexpr (dim == 2)
        contract<transpose, false, 3, 1>(line_modes, s, out);
      else
        {
          V t[n];
          contract<transpose, false, 3, 3>(line_modes, s, t);
          contract<transpose, false, 9, 1>(line_modes, t, out);
        }
    }

    template <bool transpose, unsigned int i, typename V>
    static void
    modes_at_points(const V *in, V *out)
    {
      constexpr const PointMatrices &m = point_matrices;
      if constexpr (i == 0)
        contract_all<dim, transpose, 4, 3, 3>(m.modes, m.few_modes, m.few_modes, in, out);
      else if constexpr (i == 1)
        contract_all<dim, transpose, 3, 4, 3>(m.few_modes, m.modes, m.few_modes, in, out);
      else
        contract_all<dim, transpose, 3, 3, 4>(m.few_modes, m.few_modes, m.modes, in, out);
    }

    /// values[a * n_points + q] = component a of R u at point q.
    template <typename V>
    void
    evaluate(const V *u, V *values) const
    {
      V modes[dim][n], divergence[n] = {};
      for_directions<dim>([&](const auto i) {
        constexpr unsigned int a = i.value;
        to_modes<false>(u + a * n, modes[a]);
#pragma GCC unroll 27
        for (unsigned int m = 0; m < n; ++m)
          if (digit(m, a) > 0)
            divergence[m - stride[a]] += slope[a] * derivative[digit(m, a)] * modes[a][m];
      });
      for_directions<dim>([&](const auto i) {
        constexpr unsigned int a = i.value;
        V coefficients[n_coefficients];
#pragma GCC unroll 27
        for (unsigned int m = 0; m < n; ++m)
          coefficients[place(a, m)] = modes[a][m];
#pragma GCC unroll 27
        for (unsigned int m = 0; m < n; ++m)
          if (digit(m, a) == 1) // the bubble beta L_0
            {
              const V bubble = factors[a][m] * divergence[m] / 3.;
              coefficients[place(a, m - stride[a])] -= bubble;
              coefficients[place(a, m, 1)] += bubble;
            }
          else if (digit(m, a) == 2) // beta L_1
            coefficients[place(a, m, 1)] = factors[a][m] * divergence[m];
        modes_at_points<false, a>(coefficients, values + a * n_points<dim>);
      });
    }

    /// out_j += what sum_aq functional[a * n_points + q] (R v)_a(q) makes of each unknown of v.
    template <typename V>
    void
    add_tested(const V *functional, V *out) const
    {
      V modes[dim][n], divergence[n] = {};
      for_directions<dim>([&](const auto i) {
        constexpr unsigned int a = i.value;
        V coefficients[n_coefficients];
        modes_at_points<true, a>(functional + a * n_points<dim>, coefficients);
#pragma GCC unroll 27
        for (unsigned int m = 0; m < n; ++m)
          {
            modes[a][m] = coefficients[place(a, m)];
            if (digit(m, a) == 1)
              divergence[m] +=
                factors[a][m] / 3. *
                (coefficients[place(a, m, 1)] - coefficients[place(a, m - stride[a])]);
            else if (digit(m, a) == 2)
              divergence[m] += factors[a][m] * coefficients[place(a, m, 1)];
          }
      });
      for_directions<dim>([&](const auto i) {
        constexpr unsigned int a = i.value;
        V nodes[n];
#pragma GCC unroll 27
        for (unsigned int m = 0; m < n; ++m)
          if (digit(m, a) > 0)
            modes[a][m] += slope[a] * derivative[digit(m, a)] * divergence[m - stride[a]];
        to_modes<true>(modes[a], nodes);
        for (unsigned int j = 0; j < n; ++j)
          out[a * n + j] += nodes[j];
      });
    }

    double factors[dim][n]; // of d_m in the bubbles of component a, [a][m]
    double slope[dim];
  };
} // namespace feib

#endif
