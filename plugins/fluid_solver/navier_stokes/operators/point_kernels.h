// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_point_kernels_h
#define feib_plugins_navier_stokes_point_kernels_h

namespace feib
{
  /// Kernels by products of one-dimensional matrices, on batches of cells as in cell_kernels.h:
  /// values at the 4^dim Gauss points of a cell (x fastest) of Q2 functions and their derivatives,
  /// and what functionals at these points make of the unknowns.
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
} // namespace feib

#endif
