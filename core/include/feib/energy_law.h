// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_energy_law_h
#define feib_energy_law_h

#include <feib/constitutive_law.h>
#include <feib/dual.h>
#include <feib/fibre_directions.h>

#include <algorithm>
#include <vector>

namespace feib
{
  /// A symmetric m x m matrix of numbers of any kind, each pair of equal entries once.
  template <int m, typename Number>
  struct SymmetricMatrix
  {
    static constexpr int n_entries = m * (m + 1) / 2;

    std::array<Number, n_entries> entries;

    /// The place of entry (k, l) among the entries.
    static constexpr int
    place(const int k, const int l)
    {
      return k >= l ? k * (k + 1) / 2 + l : place(l, k);
    }

    Number &
    operator()(const int k, const int l)
    {
      return entries[place(k, l)];
    }

    const Number &
    operator()(const int k, const int l) const
    {
      return entries[place(k, l)];
    }
  };

  template <int m, typename Number>
  Number
  trace(const SymmetricMatrix<m, Number> &C)
  {
    Number sum = C(0, 0);
    for (int k = 1; k < m; ++k)
      sum += C(k, k);
    return sum;
  }

  template <int m, typename Number>
  Number
  determinant(const SymmetricMatrix<m, Number> &C)
  {
    if constexpr (m == 1)
      return C(0, 0);
    else if constexpr (m == 2)
      return C(0, 0) * C(1, 1) - C(1, 0) * C(1, 0);
    else
      return C(0, 0) * (C(1, 1) * C(2, 2) - C(2, 1) * C(2, 1)) +
             C(1, 0) * (C(2, 1) * C(2, 0) - C(1, 0) * C(2, 2)) +
             C(2, 0) * (C(1, 0) * C(2, 1) - C(2, 0) * C(1, 1));
  }

  /// I2 = ((tr C)^2 - tr C^2) / 2; zero for m = 1 and det C for m = 2.
  template <int m, typename Number>
  Number
  second_invariant(const SymmetricMatrix<m, Number> &C)
  {
    Number sum(0.);
    for (int k = 0; k < m; ++k)
      for (int l = 0; l < k; ++l)
        sum += C(k, k) * C(l, l) - C(k, l) * C(k, l);
    return sum;
  }


  /// A vector for each of several points, in their frames.
  template <int m>
  struct Direction
  {
    Lanes entries[m];

    Lanes &
    operator[](const int k)
    {
      return entries[k];
    }

    const Lanes &
    operator[](const int k) const
    {
      return entries[k];
    }
  };

  /// a . C a, the square of the stretch along a unit vector.
  template <int m, typename Number>
  Number
  stretch_square(const SymmetricMatrix<m, Number> &C, const Direction<m> &a)
  {
    Number sum(0.);
    for (int k = 0; k < m; ++k)
      {
        sum += C(k, k) * (a[k] * a[k]);
        for (int l = 0; l < k; ++l)
          sum += C(k, l) * (2. * a[k] * a[l]);
      }
    return sum;
  }

  /// |C a|^2, also called I5.
  template <int m, typename Number>
  Number
  image_square(const SymmetricMatrix<m, Number> &C, const Direction<m> &a)
  {
    Number sum(0.);
    for (int k = 0; k < m; ++k)
      {
        Number entry(0.);
        for (int l = 0; l < m; ++l)
          entry += C(k, l) * a[l];
        sum += entry * entry;
      }
    return sum;
  }


  /// The points that an energy is asked for at once: what belongs to them is taken from a container
  /// with an entry for each point of the law.
  struct PointBatch
  {
    std::array<unsigned int, Lanes::n> index;

    /// Numbers, one for each point.
    Lanes
    operator()(const std::vector<double> &values) const
    {
      Lanes result;
      for (unsigned int lane = 0; lane < index.size(); ++lane)
        result.set(lane, values[index[lane]]);
      return result;
    }

    /// Directions in the frames of the points, @p directions(point, family) as FibreDirections
    /// gives them.
    template <int m, int dim>
    Direction<m>
    operator()(const FibreDirections<m, dim> &directions, const unsigned int family) const
    {
      Direction<m> a;
      for (unsigned int lane = 0; lane < index.size(); ++lane)
        for (int k = 0; k < m; ++k)
          a[k].set(lane, directions(index[lane], family)[k]);
      return a;
    }
  };


  /// A law that is given by its energy alone, a function of C = F^T F and so the same for an
  /// observer who turns, in numbers of any kind:
  ///
  ///   template <int m, int dim>
  ///   class MyLaw : public EnergyLaw<MyLaw<m, dim>, m, dim>
  ///   {
  ///   public:
  ///     template <typename Number>
  ///     Number
  ///     density(const SymmetricMatrix<m, Number> &C, const PointBatch &points) const;
  ///   };
  ///
  /// Stress and its derivative, P = F S and dP = dF S + F dS with S = 2 dW/dC, follow by dual
  /// numbers, for several points at once. The energy is made of + - * /, reciprocal, exp, log,
  /// sqrt, pow (to a constant power), sin, cos, positive_part and step, and of the functions above.
  template <class Law, int structure_dim, int dim>
  class EnergyLaw : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Matrix        = typename ConstitutiveLaw<structure_dim, dim>::Matrix;
    using MaterialPoint = typename ConstitutiveLaw<structure_dim, dim>::MaterialPoint;

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const final
    {
      W.resize(F.size());
      for_each_batch(F.size(), [&](const PointBatch &points, const unsigned int filled) {
        const Gradient at(F, points);
        SymmetricMatrix<m, Lanes> C;
        for (int k = 0; k < m; ++k)
          for (int l = 0; l <= k; ++l)
            C(k, l) = at.product(at, k, l);
        const Lanes value = law().density(C, points);
        for (unsigned int lane = 0; lane < filled; ++lane)
          W[points.index[lane]] = value[lane];
      });
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const final
    {
      P.resize(F.size());
      for_each_batch(F.size(), [&](const PointBatch &points, const unsigned int filled) {
        using Number = Dual<n, Lanes>;
        const Gradient at(F, points);
        SymmetricMatrix<m, Number> C;
        for (int k = 0; k < m; ++k)
          for (int l = 0; l <= k; ++l)
            {
              C(k, l)                      = Number(at.product(at, k, l));
              C(k, l).slope[C.place(k, l)] = 1.;
            }
        const Number W = law().density(C, points);
        for (int i = 0; i < dim; ++i)
          for (int k = 0; k < m; ++k)
            {
              Lanes sum = 0.;
              for (int l = 0; l < m; ++l)
                sum += at.entries[i][l] * twice(k, l, W.slope[C.place(k, l)]);
              for (unsigned int lane = 0; lane < filled; ++lane)
                P[points.index[lane]][i][k] = sum[lane];
            }
      });
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const final
    {
      dP.resize(F.size());
      for_each_batch(F.size(), [&](const PointBatch &points, const unsigned int filled) {
        using Along  = Dual<1, Lanes>; // the derivative along dF
        using Number = Dual<n, Along>;
        const Gradient at(F, points), d(dF, points);
        SymmetricMatrix<m, Number> C;
        for (int k = 0; k < m; ++k)
          for (int l = 0; l <= k; ++l)
            {
              Number &entry              = C(k, l);
              entry                      = Number(at.product(at, k, l));
              entry.value.slope[0]       = at.product(d, k, l) + d.product(at, k, l);
              entry.slope[C.place(k, l)] = Along(Lanes(1.));
            }
        const Number W = law().density(C, points);
        for (int i = 0; i < dim; ++i)
          for (int k = 0; k < m; ++k)
            {
              Lanes sum = 0.;
              for (int l = 0; l < m; ++l)
                {
                  const Along &S = W.slope[C.place(k, l)];
                  sum += d.entries[i][l] * twice(k, l, S.value) +
                         at.entries[i][l] * twice(k, l, S.slope[0]);
                }
              for (unsigned int lane = 0; lane < filled; ++lane)
                dP[points.index[lane]][i][k] = sum[lane];
            }
      });
    }

  private:
    static constexpr int m = structure_dim, n = SymmetricMatrix<m, Lanes>::n_entries;

    /// Deformation gradients of several points.
    struct Gradient
    {
      Gradient(const std::vector<Matrix> &F, const PointBatch &points)
      {
        for (unsigned int lane = 0; lane < points.index.size(); ++lane)
          for (int i = 0; i < dim; ++i)
            for (int k = 0; k < m; ++k)
              entries[i][k].set(lane, F[points.index[lane]][i][k]);
      }

      /// Entry (k, l) of F^T G.
      Lanes
      product(const Gradient &G, const int k, const int l) const
      {
        Lanes sum = entries[0][k] * G.entries[0][l];
        for (int i = 1; i < dim; ++i)
          sum += entries[i][k] * G.entries[i][l];
        return sum;
      }

      Lanes entries[dim][m];
    };

    const Law &
    law() const
    {
      return static_cast<const Law &>(*this);
    }

    /// S from the derivative by an entry of C, which stands for two beside the diagonal.
    static Lanes
    twice(const int k, const int l, const Lanes &derivative)
    {
      return k == l ? derivative + derivative : derivative;
    }

    /// The last batch repeats its last point.
    template <typename Action>
    static void
    for_each_batch(const std::size_t n_points, const Action &action)
    {
      constexpr unsigned int lanes = Lanes::n;
      for (std::size_t first = 0; first < n_points; first += lanes)
        {
          PointBatch points;
          for (unsigned int lane = 0; lane < lanes; ++lane)
            points.index[lane] = std::min(first + lane, n_points - 1);
          action(points, std::min<std::size_t>(lanes, n_points - first));
        }
    }
  };
} // namespace feib

#endif
