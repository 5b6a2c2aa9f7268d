// SPDX-License-Identifier: LGPL-2.1-or-later
#include "stiffness.h"

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    template <int n>
    using Square = std::array<std::array<double, n>, n>;


    /// Whether all eigenvalues of A are below lambda: whether lambda I - A has a Cholesky factor.
    template <int n>
    bool
    bounds(const Square<n> &A, const double lambda)
    {
      Square<n> L;
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j <= i; ++j)
          {
            double sum = (i == j ? lambda : 0) - A[i][j];
            for (unsigned int k = 0; k < j; ++k)
              sum -= L[i][k] * L[j][k];
            if (i != j)
              L[i][j] = sum / L[j][j];
            else if (sum > 0)
              L[i][i] = std::sqrt(sum);
            else
              return false;
          }
      return true;
    }


    /// Raises @p largest to the largest eigenvalue of A: one factorisation when it is no larger,
    /// and a bisection for the few matrices that raise the maximum.
    template <int n>
    void
    raise(const Square<n> &A, double &largest)
    {
      double norm = 0;
      for (const auto &row : A)
        for (const double a : row)
          norm += a * a;
      norm = std::sqrt(norm);
      if (norm <= largest || bounds<n>(A, largest * (1 + 1e-12)))
        return;
      double above = norm * (1 + 1e-12);
      while (above - largest > 1e-13 * above)
        {
          const double middle                      = (largest + above) / 2;
          (bounds<n>(A, middle) ? above : largest) = middle;
        }
    }


    /// R of F = Q R, upper triangular, Q with orthonormal columns.
    template <int m, int dim, typename Matrix>
    Square<m>
    triangle(const Matrix &F)
    {
      Square<m> R = {};
      for (unsigned int j = 0; j < m; ++j)
        for (unsigned int i = 0; i <= j; ++i)
          {
            double sum = 0;
            for (unsigned int a = 0; a < dim; ++a)
              sum += F[a][i] * F[a][j];
            for (unsigned int k = 0; k < i; ++k)
              sum -= R[k][i] * R[k][j];
            R[i][j] = i == j ? std::sqrt(std::max(sum, 0.)) : R[i][i] > 0 ? sum / R[i][i] : 0;
          }
      return R;
    }
  } // namespace


  template <int structure_dim, int dim>
  typename StructureModel<dim>::Stiffness
  largest_stiffness(const std::vector<typename FaceLoads<structure_dim, dim>::Matrix> &F,
                    const typename FaceLoads<structure_dim, dim>::Columns &columns)
  {
    constexpr int m = structure_dim, n = m * dim;
    typename StructureModel<dim>::Stiffness largest;
    for (unsigned int e = 0; e < F.size(); ++e)
      {
        // Index: row of F * m + column.
        Square<n> A, B = {};
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int j = 0; j < n; ++j)
            A[i][j] = columns[j][e][i / m][i % m];
        raise<n>(A, largest.reference);

        // F = Q R with R of the size of the structure: dF = (H Q) R, and H Q is as large as H.
        const auto R = triangle<m, dim>(F[e]);
        double J     = 1;
        for (unsigned int k = 0; k < m; ++k)
          J *= R[k][k];
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int j = 0; j < n; ++j)
            for (unsigned int k = 0; k < m; ++k)
              for (unsigned int l = 0; l < m; ++l)
                B[i][j] +=
                  R[i % m][k] * A[i / m * m + k][j / m * m + l] * R[j % m][l] / std::max(J, 1e-12);
        raise<n>(B, largest.spatial);
      }
    return largest;
  }


  template StructureModel<2>::Stiffness
  largest_stiffness<1, 2>(const std::vector<FaceLoads<1, 2>::Matrix> &,
                          const FaceLoads<1, 2>::Columns &);
  template StructureModel<2>::Stiffness
  largest_stiffness<2, 2>(const std::vector<FaceLoads<2, 2>::Matrix> &,
                          const FaceLoads<2, 2>::Columns &);
  template StructureModel<3>::Stiffness
  largest_stiffness<2, 3>(const std::vector<FaceLoads<2, 3>::Matrix> &,
                          const FaceLoads<2, 3>::Columns &);
  template StructureModel<3>::Stiffness
  largest_stiffness<3, 3>(const std::vector<FaceLoads<3, 3>::Matrix> &,
                          const FaceLoads<3, 3>::Columns &);
} // namespace feib
