// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_convection_kernels_h
#define feib_plugins_navier_stokes_convection_kernels_h

#include "operators/reconstruction_at_points.h"

#include <algorithm>

namespace feib
{
  // Values at points as in point_kernels.h: four per direction integrate curl w (R u) (R v)
  // exactly, of degrees 2, 3 and 2 or 2, 2 and 3.

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
