// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_chebyshev_h
#define feib_plugins_navier_stokes_chebyshev_h

#include "operators/cell_kernels.h"

namespace feib
{
  /// Chebyshev's iteration on D^{-1} A over an interval that holds the upper end of the spectrum,
  /// or all of it: a smoother, or a solver.
  struct Chebyshev
  {
    double lower, upper;
    unsigned int degree;

    /// Calls first(1 / theta) and then next(c, s), for steps d = c d + s D^{-1} r and x += d.
    template <class First, class Next>
    void
    iterate(const First &first, const Next &next) const
    {
      const double theta = (upper + lower) / 2, delta = (upper - lower) / 2;
      double rho = delta / theta;
      first(1 / theta);
      for (unsigned int k = 1; k < degree; ++k)
        {
          const double rho_next = 1 / (2 * theta / delta - rho);
          next(rho_next * rho, 2 * rho_next / delta);
          rho = rho_next;
        }
    }
  };


  /// A step with diagonal D, of which the inverse is given, and r = f - product.
  inline void
  step_with_diagonal(const unsigned int n,
                     const float c,
                     const float s,
                     const float *__restrict inverse_diagonal,
                     const float *__restrict f,
                     const float *__restrict product,
                     float *__restrict d,
                     float *__restrict x)
  {
    for (unsigned int i = 0; i < n; ++i)
      {
        d[i] = c * d[i] + s * inverse_diagonal[i] * (f[i] - product[i]);
        x[i] += d[i];
      }
  }


  /// The same with the inverse blocks of the pressures of batches of cells, as
  /// MultigridLevel::invert_blocks() makes them. Without @p product, r = f.
  template <int dim>
  inline void
  step_with_blocks(const unsigned int n_batches,
                   const float c,
                   const float s,
                   const float *blocks,
                   const float *f,
                   const float *product,
                   float *d,
                   float *x)
  {
    constexpr unsigned int n_pressure = dim + 1, lanes = Batch<float>::lanes;
    for (unsigned int b = 0; b < n_batches; ++b)
      {
        const float *block = blocks + b * n_pressure * n_pressure * lanes;
        float r[n_pressure][lanes];
        for (unsigned int k = 0; k < n_pressure; ++k)
          for (unsigned int l = 0; l < lanes; ++l)
            r[k][l] = f[(b * n_pressure + k) * lanes + l] -
                      (product ? product[(b * n_pressure + k) * lanes + l] : 0.f);
        for (unsigned int k = 0; k < n_pressure; ++k)
          {
            float sum[lanes] = {};
            for (unsigned int m = 0; m < n_pressure; ++m)
              for (unsigned int l = 0; l < lanes; ++l)
                sum[l] += block[(k * n_pressure + m) * lanes + l] * r[m][l];
            for (unsigned int l = 0; l < lanes; ++l)
              {
                const unsigned int i = (b * n_pressure + k) * lanes + l;
                d[i]                 = c * d[i] + s * sum[l];
                x[i] += d[i];
              }
          }
      }
  }
} // namespace feib

#endif
