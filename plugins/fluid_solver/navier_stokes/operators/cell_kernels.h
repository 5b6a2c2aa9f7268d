// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_cell_kernels_h
#define feib_plugins_navier_stokes_cell_kernels_h

#include <deal.II/base/tensor.h>

#include <algorithm>
#include <type_traits>

namespace feib
{
  /// The kernels of the loops that run in every iteration: forms of Q2 and discontinuous P1 on
  /// Cartesian cells, by products of one-dimensional matrices, for a batch of cells of the same
  /// size at once, one in each lane of the compiler's vectors.
  ///
  /// As in EulerianSpace, the n = 3^dim nodes of a cell are lexicographic; the pressure is in the
  /// orthonormal Legendre functions 1, sqrt(12) (x_a - 1/2) of the unit cell, as in FE_DGP(1).
  template <typename Number>
  struct Batch;

  template <>
  struct Batch<double>
  {
    static constexpr unsigned int lanes = 8;
    typedef double Values __attribute__((vector_size(8 * lanes)));
  };

  template <>
  struct Batch<float>
  {
    static constexpr unsigned int lanes = 16;
    typedef float Values __attribute__((vector_size(4 * lanes)));
  };


  /// from[indices[lane]] in each lane.
  template <typename Number>
  inline typename Batch<Number>::Values
  gather(const Number *from, const unsigned int *indices)
  {
    typename Batch<Number>::Values result = {};
    for (unsigned int l = 0; l < Batch<Number>::lanes; ++l)
      result[l] = from[indices[l]];
    return result;
  }

  /// to[indices[lane]] += values, one lane after the other, the first @p filled ones.
  template <typename Number>
  inline void
  scatter_add(const typename Batch<Number>::Values &values,
              const unsigned int *indices,
              const unsigned int filled,
              Number *to)
  {
    constexpr unsigned int lanes = Batch<Number>::lanes;
    // A known number is unrolled.
    if (filled == lanes)
#pragma GCC unroll 16
      for (unsigned int l = 0; l < lanes; ++l)
        to[indices[l]] += values[l];
    else
      for (unsigned int l = 0; l < filled; ++l)
        to[indices[l]] += values[l];
  }


  template <int dim>
  inline double
  cell_volume(const dealii::Tensor<1, dim> &size)
  {
    double result = 1;
    for (unsigned int a = 0; a < dim; ++a)
      result *= size[a];
    return result;
  }

  /// Calls action with std::integral_constant 0, ..., dim - 1.
  template <int dim, class Action>
  inline void
  for_directions(const Action &action)
  {
    action(std::integral_constant<unsigned int, 0>());
    action(std::integral_constant<unsigned int, 1>());
    if constexpr (dim == 3)
      action(std::integral_constant<unsigned int, 2>());
  }


  /// One-dimensional matrices of Q2 on the unit interval, nodes 0, 1/2, 1.
  struct LineMatrices
  {
    // int phi_i phi_j, int phi_i' phi_j', int phi_i phi_j'
    static constexpr double mass[3][3]       = {{4 / 30., 2 / 30., -1 / 30.},
                                                {2 / 30., 16 / 30., 2 / 30.},
                                                {-1 / 30., 2 / 30., 4 / 30.}};
    static constexpr double stiffness[3][3]  = {{7 / 3., -8 / 3., 1 / 3.},
                                                {-8 / 3., 16 / 3., -8 / 3.},
                                                {1 / 3., -8 / 3., 7 / 3.}};
    static constexpr double derivative[3][3] = {{-1 / 2., 2 / 3., -1 / 6.},
                                                {-2 / 3., 0., 2 / 3.},
                                                {1 / 6., -2 / 3., 1 / 2.}};
    // int L_k phi_j and int L_k phi_j' with L_0 = 1, L_1 = sqrt(12) (x - 1/2)
    static constexpr double root         = 3.4641016151377545871;
    static constexpr double moment[2][3] = {{1 / 6., 4 / 6., 1 / 6.}, {-root / 12, 0., root / 12}};
    static constexpr double slope[2][3]  = {{-1., 0., 1.}, {root / 3, -2 * root / 3, root / 3}};
  };


  /// out (+)= factor matrix, along direction @p a, applied to @p in; arrays of 3^dim.
  template <int dim, unsigned int a, bool transpose, bool add, typename V, typename Number>
  inline void
  apply_line(const double (&matrix)[3][3], const Number factor, const V *in, V *out)
  {
    constexpr unsigned int stride = a == 0 ? 1 : a == 1 ? 3 : 9;
    constexpr unsigned int n      = dim == 2 ? 9 : 27;
    Number m[3][3];
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        m[i][j] = factor * Number(transpose ? matrix[j][i] : matrix[i][j]);
#pragma GCC unroll 9
    for (unsigned int line = 0; line < n / 3; ++line)
      {
        const unsigned int first = line / stride * 3 * stride + line % stride;
        const V x0 = in[first], x1 = in[first + stride], x2 = in[first + 2 * stride];
        for (unsigned int i = 0; i < 3; ++i)
          {
            const V sum = m[i][0] * x0 + m[i][1] * x1 + m[i][2] * x2;
            if (add)
              out[first + i * stride] += sum;
            else
              out[first + i * stride] = sum;
          }
      }
  }


  /// The form alpha (u, v) + mu (grad u, grad v) + nu (grad u^T, grad v) + gamma (div u, div v) +
  /// eta (P div u, P div v), with P the projection to the discontinuous P1 pressures.
  struct VelocityForm
  {
    double alpha, mu, nu = 0, gamma = 0, eta = 0;

    /// Whether components depend on each other.
    bool
    couples() const
    {
      return nu != 0 || gamma != 0 || eta != 0;
    }
  };


  /// On a cell of given size, what directions weigh in the form of component @p a with itself.
  template <int dim, typename Number>
  struct CellFactors
  {
    CellFactors(const VelocityForm &form, const dealii::Tensor<1, dim> &size, const unsigned int a)
    {
      const double volume = cell_volume(size);
      mass                = form.alpha * volume;
      for (unsigned int b = 0; b < dim; ++b)
        stiffness[b] =
          (form.mu + (a == b ? form.nu + form.gamma : 0.)) * volume / (size[b] * size[b]);
    }
    Number mass, stiffness[dim];
  };


  /// out = the form of one component with itself, applied to u.
  template <int dim, typename V, typename Number>
  inline void
  apply_helmholtz(const CellFactors<dim, Number> &factors, const V *u, V *out)
  {
    constexpr unsigned int n = dim == 2 ? 9 : 27;
    V s[n], t[n];
    apply_line<dim, 0, false, false>(LineMatrices::mass, Number(1), u, s);
    apply_line<dim, 0, false, false>(LineMatrices::stiffness, factors.stiffness[0], u, t);
    // t: all that is left to be multiplied by the masses of the other directions.
#pragma GCC unroll 27
    for (unsigned int i = 0; i < n; ++i)
      t[i] += factors.mass * s[i];
    if constexpr (dim == 2)
      {
        apply_line<dim, 1, false, false>(LineMatrices::mass, Number(1), t, out);
        apply_line<dim, 1, false, true>(LineMatrices::stiffness, factors.stiffness[1], s, out);
      }
    else
      {
        V s2[n], t2[n];
        apply_line<dim, 1, false, false>(LineMatrices::mass, Number(1), s, s2);
        apply_line<dim, 1, false, false>(LineMatrices::mass, Number(1), t, t2);
        apply_line<dim, 1, false, true>(LineMatrices::stiffness, factors.stiffness[1], s, t2);
        apply_line<dim, 2, false, false>(LineMatrices::mass, Number(1), t2, out);
        apply_line<dim, 2, false, true>(LineMatrices::stiffness, factors.stiffness[2], s2, out);
      }
  }


  /// out_a += c_ab int d_a u_b d_b v_a + g_ab int d_b u_b d_a v_a for a != b: what the symmetric
  /// gradient and the divergence couple.
  template <int dim, unsigned int a, unsigned int b, typename V, typename Number>
  inline void
  add_coupling(const Number c, const Number g, const V *u_b, V *out_a)
  {
    constexpr unsigned int n = dim == 2 ? 9 : 27;
    V s[n], t[n];
    if constexpr (dim == 3)
      apply_line<dim, 3 - a - b, false, false>(LineMatrices::mass, Number(1), u_b, s);
    else
      std::copy_n(u_b, n, s);
    // int d_a u_b d_b v_a: the derivative is on u along a, on v along b.
    apply_line<dim, a, false, false>(LineMatrices::derivative, c, s, t);
    apply_line<dim, b, true, true>(LineMatrices::derivative, Number(1), t, out_a);
    if (g != 0)
      {
        apply_line<dim, b, false, false>(LineMatrices::derivative, g, s, t);
        apply_line<dim, a, true, true>(LineMatrices::derivative, Number(1), t, out_a);
      }
  }


  /// int q_k d_a phi_j on the unit cell, from products of line integrals.
  template <int dim>
  constexpr double
  divergence_entry(const unsigned int a, const unsigned int k, const unsigned int j)
  {
    double result       = 1;
    unsigned int stride = 1;
    for (unsigned int b = 0; b < dim; ++b, stride *= 3)
      {
        const unsigned int degree = k == b + 1, node = j / stride % 3;
        result *= a == b ? LineMatrices::slope[degree][node] : LineMatrices::moment[degree][node];
      }
    return result;
  }

  template <int dim>
  struct DivergenceTable
  {
    static constexpr unsigned int n = dim == 2 ? 9 : 27;
    double entry[dim][dim + 1][n]   = {};
    constexpr DivergenceTable()
    {
      for (unsigned int a = 0; a < dim; ++a)
        for (unsigned int k = 0; k <= dim; ++k)
          for (unsigned int j = 0; j < n; ++j)
            entry[a][k][j] = divergence_entry<dim>(a, k, j);
    }
  };

  template <int dim>
  inline constexpr DivergenceTable<dim> divergence_table;


  /// out_a = int p d_a v_a, for one direction: (p, div v). @p scale: volume / size[a].
  template <int dim, unsigned int a, typename V, typename Number>
  inline void
  apply_gradient(const Number scale, const V *p, V *out)
  {
    constexpr unsigned int n = dim == 2 ? 9 : 27;
#pragma GCC unroll 27
    for (unsigned int j = 0; j < n; ++j)
      {
        V sum = p[0] * Number(divergence_table<dim>.entry[a][0][j]);
#pragma GCC unroll 4
        for (unsigned int k = 1; k <= dim; ++k)
          if (divergence_table<dim>.entry[a][k][j] != 0)
            sum += p[k] * Number(divergence_table<dim>.entry[a][k][j]);
        out[j] = scale * sum;
      }
  }


  /// out_k += int q_k d_a u_a, for one direction.
  template <int dim, unsigned int a, typename V, typename Number>
  inline void
  add_divergence(const Number scale, const V *u, V *out)
  {
    constexpr unsigned int n = dim == 2 ? 9 : 27;
#pragma GCC unroll 4
    for (unsigned int k = 0; k <= dim; ++k)
      {
        V sum = {};
#pragma GCC unroll 27
        for (unsigned int j = 0; j < n; ++j)
          if (divergence_table<dim>.entry[a][k][j] != 0)
            sum += u[j] * Number(divergence_table<dim>.entry[a][k][j]);
        out[k] += scale * sum;
      }
  }


  /// out = the form applied to u, all components, component by component.
  template <int dim, typename Number, typename V>
  inline void
  apply_velocity_form(const VelocityForm &form,
                      const dealii::Tensor<1, dim> &size,
                      const V *u,
                      V *out)
  {
    constexpr unsigned int n = dim == 2 ? 9 : 27;
    for (unsigned int a = 0; a < dim; ++a)
      apply_helmholtz<dim>(CellFactors<dim, Number>(form, size, a), u + a * n, out + a * n);
    if (form.nu != 0 || form.gamma != 0)
      for_directions<dim>([&](const auto a) {
        for_directions<dim>([&](const auto b) {
          const double scale = cell_volume(size) / (size[a.value] * size[b.value]);
          if constexpr (a.value != b.value)
            add_coupling<dim, a.value, b.value>(Number(form.nu * scale),
                                                Number(form.gamma * scale),
                                                u + b.value * n,
                                                out + a.value * n);
        });
      });
    if (form.eta != 0)
      {
        // P div u in orthonormal functions of the cell
        V divergence[dim + 1] = {};
        for_directions<dim>([&](const auto a) {
          add_divergence<dim, a.value>(Number(1 / size[a.value]), u + a.value * n, divergence);
        });
        for_directions<dim>([&](const auto a) {
          V product[n];
          apply_gradient<dim, a.value>(Number(form.eta * cell_volume(size) / size[a.value]),
                                       divergence,
                                       product);
          for (unsigned int i = 0; i < n; ++i)
            out[a.value * n + i] += product[i];
        });
      }
  }


  /// The matrix of the form on a cell of given size; it is symmetric.
  template <int dim>
  struct VelocityFormMatrix
  {
    static constexpr unsigned int n = dim == 2 ? 9 : 27, n_velocity = dim * n;

    VelocityFormMatrix(const VelocityForm &form, const dealii::Tensor<1, dim> &size)
    {
      for (unsigned int j = 0; j < n_velocity; ++j)
        {
          double unit_vector[n_velocity] = {};
          unit_vector[j]                 = 1;
          apply_velocity_form<dim, double>(form, size, unit_vector, entry[j]);
        }
    }

    double entry[n_velocity][n_velocity];
  };
} // namespace feib

#endif
