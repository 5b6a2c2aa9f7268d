// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_convection_kernels_h
#define feib_plugins_navier_stokes_convection_kernels_h

#include "operators/cell_kernels.h"

#include <feib/reconstruction.h>

#include <algorithm>

namespace feib
{
  /// Kernels of convection by products of one-dimensional matrices, on batches of cells as in
  /// cell_kernels.h: values at the 4^dim Gauss points of a cell (x fastest) of Q2 functions, their
  /// derivatives and the reconstruction R of the velocity, and what functionals at these points
  /// make of the unknowns. Four points per direction integrate curl w (R u) (R v) exactly: degrees
  /// 2, 3 and 2 or 2, 2 and 3.
  struct PointMatrices
  {
    static constexpr unsigned int n = 4; // points per direction

    // Gauss points on [-1, 1] and weights on the unit interval.
    static constexpr double x[n]       = {-0.86113631159405257522,
                                          -0.33998104358485626480,
                                          0.33998104358485626480,
                                          0.86113631159405257522};
    static constexpr double weights[n] = {0.17392742256872692869,
                                          0.32607257743127307131,
                                          0.32607257743127307131,
                                          0.17392742256872692869};

    // Q2 functions and their derivatives on the unit interval: [point][node].
    double values[n][3] = {}, derivatives[n][3] = {};
    // Legendre polynomials L_0, L_1, L_2 on [-1, 1], and N_2 with N_2' = L_2, N_2(+-1) = 0.
    double modes[n][4] = {}, few_modes[n][3] = {};

    constexpr PointMatrices()
    {
      for (unsigned int q = 0; q < n; ++q)
        {
          const double s    = x[q];
          values[q][0]      = s * (s - 1) / 2;
          values[q][1]      = 1 - s * s;
          values[q][2]      = s * (s + 1) / 2;
          derivatives[q][0] = 2 * s - 1;
          derivatives[q][1] = -4 * s;
          derivatives[q][2] = 2 * s + 1;
          modes[q][0] = few_modes[q][0] = 1;
          modes[q][1] = few_modes[q][1] = s;
          modes[q][2] = few_modes[q][2] = (3 * s * s - 1) / 2;
          modes[q][3]                   = s * (s * s - 1) / 2;
        }
    }
  };
  inline constexpr PointMatrices point_matrices;

  template <int dim>
  inline constexpr unsigned int n_points = dim == 2 ? 16 : 64;

  /// The product of the weights at point q of the unit cell.
  template <int dim>
  constexpr double
  point_weight(const unsigned int q)
  {
    const double plane = PointMatrices::weights[q % 4] * PointMatrices::weights[q / 4 % 4];
    return dim == 2 ? plane : plane * PointMatrices::weights[q / 16];
  }


  /// out (+)= matrix, or its transpose, along one index of an array: @p before is the number of
  /// entries that come faster than that index, @p after that of the slower ones.
  template <bool transpose,
            bool add,
            unsigned int before,
            unsigned int after,
            unsigned int rows,
            unsigned int columns,
            typename V>
  inline void
  contract(const double (&matrix)[rows][columns], const V *in, V *out)
  {
    constexpr unsigned int n_in = transpose ? rows : columns, n_out = transpose ? columns : rows;
#pragma GCC unroll 16
    for (unsigned int k = 0; k < after; ++k)
#pragma GCC unroll 16
      for (unsigned int i = 0; i < before; ++i)
        {
          V x[n_in];
          for (unsigned int c = 0; c < n_in; ++c)
            x[c] = in[(k * n_in + c) * before + i];
          for (unsigned int r = 0; r < n_out; ++r)
            {
              V sum = x[0] * (transpose ? matrix[0][r] : matrix[r][0]);
              for (unsigned int c = 1; c < n_in; ++c)
                sum += x[c] * (transpose ? matrix[c][r] : matrix[r][c]);
              V &place = out[(k * n_out + r) * before + i];
              place    = add ? place + sum : sum;
            }
        }
  }


  /// From coefficients with @p e0 x @p e1 (x @p e2) entries to values at points, each direction by
  /// its own matrix, or (transpose) back.
  template <int dim, bool transpose, unsigned int e0, unsigned int e1, unsigned int e2, typename V>
  inline void
  contract_all(const double (&m0)[4][e0],
               const double (&m1)[4][e1],
               const double (&m2)[4][e2],
               const V *in,
               V *out)
  {
    constexpr unsigned int third = dim == 2 ? 1 : e2;
    if constexpr (!transpose)
      {
        V s[4 * e1 * third];
        contract<false, false, 1, e1 * third>(m0, in, s);
        if constexpr (dim == 2)
          contract<false, false, 4, 1>(m1, s, out);
        else
          {
            V t[16 * e2];
            contract<false, false, 4, e2>(m1, s, t);
            contract<false, false, 16, 1>(m2, t, out);
          }
      }
    else
      {
        V s[4 * e1 * third];
        if constexpr (dim == 2)
          contract<true, false, 4, 1>(m1, in, s);
        else
          {
            V t[16 * e2];
            contract<true, false, 16, 1>(m2, in, t);
            contract<true, false, 4, e2>(m1, t, s);
          }
        contract<true, false, 1, e1 * third>(m0, s, out);
      }
  }


  /// Values at the points of a Q2 function, or its derivative in direction @p a on the unit cell
  /// (a = dim: the value), or (transpose) what a functional at the points makes of the nodes.
  template <int dim, bool transpose, unsigned int a, typename V>
  inline void
  at_points(const V *in, V *out)
  {
    constexpr const PointMatrices &m = point_matrices;
    contract_all<dim, transpose, 3, 3, 3>(a == 0 ? m.derivatives : m.values,
                                          a == 1 ? m.derivatives : m.values,
                                          a == 2 && dim == 3 ? m.derivatives : m.values,
                                          in,
                                          out);
  }


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


  /// How many numbers per point the convecting velocity w is stored as: the vorticity, or w.
  enum class ConvectiveForm
  {
    skew_symmetric,
    rotational
  };

  template <int dim>
  constexpr unsigned int
  n_stored(const ConvectiveForm form)
  {
    return n_points<dim> * (form == ConvectiveForm::rotational && dim == 2 ? 1 : dim);
  }


  /// What the kernels below need of w on a cell: for the rotational form curl w, for the other one
  /// w_a / size[a] / 2, times weights, the volume and rho.
  template <int dim, typename V>
  inline void
  prepare_convection(const ConvectiveForm form,
                     const dealii::Tensor<1, dim> &size,
                     const double rho,
                     const V *w,
                     V *stored)
  {
    constexpr unsigned int n = dim == 2 ? 9 : 27, n_q = n_points<dim>;
    const double scale = rho * cell_volume(size);
    if (form == ConvectiveForm::skew_symmetric)
      for_directions<dim>([&](const auto a) {
        at_points<dim, false, dim>(w + a.value * n, stored + a.value * n_q);
        for (unsigned int q = 0; q < n_q; ++q)
          stored[a.value * n_q + q] *= scale * point_weight<dim>(q) / (2 * size[a.value]);
      });
    else
      {
        std::fill_n(stored, n_stored<dim>(form), V{});
        // (curl w)_c = d_a w_b - d_b w_a with a = c + 1, b = c + 2 cyclically; in 2D for z alone.
        const auto add = [&](const auto derivative, const unsigned int of, V *to, const int sign) {
          V at[n_q];
          at_points<dim, false, derivative.value>(w + of * n, at);
          for (unsigned int q = 0; q < n_q; ++q)
            to[q] += sign * scale * point_weight<dim>(q) / size[derivative.value] * at[q];
        };
        using D0   = std::integral_constant<unsigned int, 0>;
        using D1   = std::integral_constant<unsigned int, 1>;
        V *const z = stored + (dim == 3 ? 2 * n_q : 0);
        add(D0(), 1, z, 1);
        add(D1(), 0, z, -1);
        if constexpr (dim == 3)
          {
            using D2 = std::integral_constant<unsigned int, 2>;
            add(D1(), 2, stored, 1);
            add(D2(), 1, stored, -1);
            add(D2(), 0, stored + n_q, 1);
            add(D0(), 2, stored + n_q, -1);
          }
      }
  }


  /// out += rho (curl w x R u, R v) for all v, with w as prepared.
  template <int dim, typename V>
  inline void
  add_rotational(const ReconstructionAtPoints<dim> &reconstruction,
                 const V *stored,
                 const V *u,
                 V *out)
  {
    constexpr unsigned int n_q = n_points<dim>;
    V at[dim * n_q];
    reconstruction.evaluate(u, at);
    for (unsigned int q = 0; q < n_q; ++q)
      if constexpr (dim == 2)
        {
          const V x   = at[q];
          at[q]       = -stored[q] * at[n_q + q];
          at[n_q + q] = stored[q] * x;
        }
      else
        {
          const V u0 = at[q], u1 = at[n_q + q], u2 = at[2 * n_q + q];
          const V w0 = stored[q], w1 = stored[n_q + q], w2 = stored[2 * n_q + q];
          at[q]           = w1 * u2 - w2 * u1;
          at[n_q + q]     = w2 * u0 - w0 * u2;
          at[2 * n_q + q] = w0 * u1 - w1 * u0;
        }
    reconstruction.add_tested(at, out);
  }


  /// out += rho/2 [(w . grad u, v) - (w . grad v, u)] for all v, with w as prepared.
  template <int dim, typename V>
  inline void
  add_skew_symmetric(const V *stored, const V *u, V *out)
  {
    constexpr unsigned int n = dim == 2 ? 9 : 27, n_q = n_points<dim>;
    for (unsigned int c = 0; c < dim; ++c)
      {
        V value[n_q], derivative[n_q], advected[n_q] = {}, nodes[n];
        at_points<dim, false, dim>(u + c * n, value);
        for_directions<dim>([&](const auto a) {
          const V *w = stored + a.value * n_q;
          at_points<dim, false, a.value>(u + c * n, derivative);
          for (unsigned int q = 0; q < n_q; ++q)
            {
              advected[q] += w[q] * derivative[q];
              derivative[q] = -w[q] * value[q];
            }
          at_points<dim, true, a.value>(derivative, nodes);
          for (unsigned int j = 0; j < n; ++j)
            out[c * n + j] += nodes[j];
        });
        at_points<dim, true, dim>(advected, nodes);
        for (unsigned int j = 0; j < n; ++j)
          out[c * n + j] += nodes[j];
      }
  }
} // namespace feib

#endif
