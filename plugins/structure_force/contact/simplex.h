// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_contact_simplex_h
#define feib_contact_simplex_h

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

// Geometry of points and simplices of at most dim corners.
namespace feib
{
  template <int dim>
  using Corners = std::array<dealii::Point<dim>, dim>; // the first n are used

  /// Barycentric coordinates of the point nearest to @p p in the plane, line or point of n corners.
  template <int dim>
  std::array<double, dim>
  nearest_in_plane(const dealii::Point<dim> &p, const Corners<dim> &corners, const unsigned int n)
  {
    // Normal equations, at most two of them.
    std::array<dealii::Tensor<1, dim>, 2> e;
    for (unsigned int m = 0; m + 1 < n; ++m)
      e[m] = corners[m + 1] - corners[0];
    const dealii::Tensor<1, dim> d = p - corners[0];
    std::array<double, dim> result{};
    if (n == 2)
      result[1] = (d * e[0]) / (e[0] * e[0]);
    else if (n == 3)
      {
        const double aa = e[0] * e[0], ab = e[0] * e[1], bb = e[1] * e[1], da = d * e[0],
                     db = d * e[1], determinant = aa * bb - ab * ab;
        result[1]       = (bb * da - ab * db) / determinant;
        result[dim - 1] = (aa * db - ab * da) / determinant;
      }
    result[0] = 1;
    for (unsigned int k = 1; k < n; ++k)
      result[0] -= result[k];
    return result;
  }


  template <int dim>
  dealii::Point<dim>
  combination(const std::array<double, dim> &weights,
              const Corners<dim> &corners,
              const unsigned int n)
  {
    dealii::Point<dim> result;
    for (unsigned int k = 0; k < n; ++k)
      result += weights[k] * dealii::Tensor<1, dim>(corners[k]);
    return result;
  }


  /// Which corners of a simplex span the smallest of its faces that holds the point nearest to
  /// @p p, as bits; and how far that is.
  template <int dim>
  std::pair<unsigned int, double>
  nearest_face(const dealii::Point<dim> &p, const Corners<dim> &corners, const unsigned int n)
  {
    std::pair<unsigned int, double> result{0, std::numeric_limits<double>::infinity()};
    for (unsigned int face = 1; face < 1u << n; ++face)
      {
        Corners<dim> of_face;
        unsigned int n_of_face = 0;
        for (unsigned int k = 0; k < n; ++k)
          if (face >> k & 1)
            of_face[n_of_face++] = corners[k];
        const auto weights = nearest_in_plane<dim>(p, of_face, n_of_face);
        if (std::any_of(weights.begin(), weights.begin() + n_of_face, [](const double weight) {
              return !(weight > 0);
            }))
          continue;
        const double distance = p.distance(combination<dim>(weights, of_face, n_of_face));
        if (distance < result.second)
          result = {face, distance};
      }
    return result;
  }


  /// The roots of a polynomial, lowest coefficient first, between 0 and 1.
  inline std::vector<double>
  roots(const std::vector<double> &coefficients)
  {
    if (coefficients.size() < 2)
      return {};
    std::vector<double> derivative;
    for (unsigned int k = 1; k < coefficients.size(); ++k)
      derivative.push_back(k * coefficients[k]);
    const auto value = [&](const double t) {
      double sum = 0;
      for (unsigned int k = coefficients.size(); k-- > 0;)
        sum = sum * t + coefficients[k];
      return sum;
    };
    std::vector<double> ends = roots(derivative), result; // it is monotone between them
    ends.insert(ends.begin(), 0.);
    ends.push_back(1.);
    for (unsigned int k = 0; k + 1 < ends.size(); ++k)
      {
        double below = ends[k], above = ends[k + 1];
        if (!((value(below) < 0) != (value(above) < 0)))
          continue;
        const bool rises = value(below) < 0;
        for (unsigned int step = 0; step < 60; ++step)
          {
            const double middle                            = (below + above) / 2;
            ((value(middle) < 0) == rises ? below : above) = middle;
          }
        result.push_back(above);
      }
    return result;
  }


  /// The times between 0 and 1 at which dim + 1 corners that go straight from @p start to @p end
  /// lie in one plane.
  template <int dim>
  std::vector<double>
  times_in_plane(const std::array<dealii::Point<dim>, dim + 1> &start,
                 const std::array<dealii::Point<dim>, dim + 1> &end)
  {
    // The roots of a determinant, a polynomial of degree dim: Newton's from dim + 1 values.
    std::array<double, dim + 1> values;
    for (unsigned int i = 0; i <= dim; ++i)
      {
        dealii::Tensor<2, dim> edges;
        for (unsigned int k = 0; k < dim; ++k)
          edges[k] = (1 - double(i) / dim) * (start[k + 1] - start[0]) +
                     double(i) / dim * (end[k + 1] - end[0]);
        values[i] = determinant(edges);
      }
    for (unsigned int order = 1; order <= dim; ++order)
      for (unsigned int i = dim; i >= order; --i)
        values[i] = (values[i] - values[i - 1]) * dim / order;
    std::vector<double> polynomial{values[dim]};
    for (unsigned int i = dim; i-- > 0;)
      {
        // times t - i/dim, plus the next value
        polynomial.insert(polynomial.begin(), 0.);
        for (unsigned int k = 0; k + 1 < polynomial.size(); ++k)
          polynomial[k] -= double(i) / dim * polynomial[k + 1];
        polynomial[0] += values[i];
      }
    return roots(polynomial);
  }


  /// Whether two simplices of together dim + 1 corners, the first n_first of which are the first
  /// one's, meet while all corners go straight from @p start to @p end: a point and a facet, or two
  /// edges in space.
  template <int dim>
  bool
  meet(const std::array<dealii::Point<dim>, dim + 1> &start,
       const std::array<dealii::Point<dim>, dim + 1> &end,
       const unsigned int n_first)
  {
    const auto inside = [](const double weight) { return weight >= -1e-9 && weight <= 1 + 1e-9; };
    for (const double t : times_in_plane<dim>(start, end))
      {
        std::array<dealii::Point<dim>, dim + 1> corners;
        double size = 0;
        for (unsigned int k = 0; k <= dim; ++k)
          {
            corners[k] = start[k] + t * (end[k] - start[k]);
            size       = std::max(size, corners[k].distance(corners[0]));
          }
        bool both_inside = true;
        dealii::Tensor<1, dim> gap; // of zero width, unless one of the simplices is flat then
        if (n_first == 1)
          {
            Corners<dim> facet;
            std::copy(corners.begin() + 1, corners.end(), facet.begin());
            const auto weights = nearest_in_plane<dim>(corners[0], facet, dim);
            both_inside        = std::all_of(weights.begin(), weights.end(), inside);
            gap                = corners[0] - combination<dim>(weights, facet, dim);
          }
        else
          {
            const dealii::Tensor<1, dim> a = corners[1] - corners[0], b = corners[3] - corners[2],
                                         d = corners[2] - corners[0];
            const double aa = a * a, ab = a * b, bb = b * b, determinant = aa * bb - ab * ab;
            const double on_a = (bb * (d * a) - ab * (d * b)) / determinant,
                         on_b = (ab * (d * a) - aa * (d * b)) / determinant;
            both_inside       = inside(on_a) && inside(on_b);
            gap               = on_a * a - d - on_b * b;
          }
        if (both_inside && gap.norm() <= 1e-6 * size)
          return true;
      }
    return false;
  }


  /// Whether an edge passes through a facet.
  template <int dim>
  bool
  crosses(const dealii::Point<dim> &from, const dealii::Point<dim> &to, const Corners<dim> &facet)
  {
    // from + t (to - from) = the facet's first corner + sum of weights times its edges
    dealii::Tensor<2, dim> columns;
    for (unsigned int a = 0; a < dim; ++a)
      {
        columns[a][0] = to[a] - from[a];
        for (unsigned int k = 1; k < dim; ++k)
          columns[a][k] = facet[0][a] - facet[k][a];
      }
    if (determinant(columns) == 0)
      return false;
    const dealii::Tensor<1, dim> solution = invert(columns) * (facet[0] - from);
    double rest                           = 1;
    bool inside                           = solution[0] >= 0 && solution[0] <= 1;
    for (unsigned int k = 1; k < dim; ++k)
      {
        inside = inside && solution[k] >= 0;
        rest -= solution[k];
      }
    return inside && rest >= 0;
  }
} // namespace feib

#endif
