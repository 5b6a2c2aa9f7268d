// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/spectrum.h"

#include <deal.II/lac/lapack_full_matrix.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace feib
{
  namespace
  {
    /// The eigenvalues, in order, of D^{-1} A on fields of so many components that change their
    /// sign from cell to cell in the directions of the bits of @p phase; or (@p open) of the cell
    /// alone.
    template <int dim>
    dealii::Vector<double>
    eigenvalues(const VelocityFormMatrix<dim> &matrix,
                const unsigned int n_components,
                const unsigned int phase,
                const bool open)
    {
      constexpr unsigned int n      = VelocityFormMatrix<dim>::n;
      const unsigned int n_unknowns = open ? n_components * n : n_components << dim;
      // Of each unknown of the cell, which of the lattice's 2^dim per cell and component it is, and
      // its sign.
      unsigned int place[dim * n];
      int sign[dim * n];
      dealii::Vector<double> diagonal(n_unknowns), values;
      for (unsigned int i = 0; i < n_components * n; ++i)
        {
          place[i] = open ? i : i / n << dim;
          sign[i]  = 1;
          for (unsigned int a = 0, node = i % n; a < dim && !open; ++a, node /= 3)
            if (node % 3 == 1)
              place[i] += 1 << a;
            else if (node % 3 == 2 && (phase >> a & 1))
              sign[i] = -sign[i];
          diagonal(place[i]) += matrix.entry[i][i];
        }
      dealii::LAPACKFullMatrix<double> scaled(n_unknowns, n_unknowns);
      for (unsigned int i = 0; i < n_components * n; ++i)
        for (unsigned int j = 0; j < n_components * n; ++j)
          scaled(place[i], place[j]) += sign[i] * sign[j] * matrix.entry[i][j] /
                                        std::sqrt(diagonal(place[i]) * diagonal(place[j]));
      dealii::FullMatrix<double> vectors;
      scaled.compute_eigenvalues_symmetric(-1., 2. * dim * n, 1e-10, values, vectors);
      return values;
    }
  } // namespace


  template <int dim>
  std::pair<double, double>
  spectrum(const LevelSpace<dim> &space, const VelocityForm &form)
  {
    // Without coupling, the first component tells all.
    const unsigned int n_components = form.couples() ? dim : 1;
    const bool open                 = space.has_open_corners();
    double least = std::numeric_limits<double>::max(), most = 0;
    for (const dealii::Tensor<1, dim> &size : space.sizes())
      {
        const VelocityFormMatrix<dim> matrix(form, size);
        for (unsigned int phase = 0; phase < (open ? 1 : 1 << dim); ++phase)
          {
            const auto values = eigenvalues(matrix, n_components, phase, open);
            least             = std::min(least, values[0]);
            most              = std::max(most, values[values.size() - 1]);
          }
      }
    return {least, most};
  }


  template std::pair<double, double> spectrum(const LevelSpace<2> &, const VelocityForm &);
  template std::pair<double, double> spectrum(const LevelSpace<3> &, const VelocityForm &);
} // namespace feib
