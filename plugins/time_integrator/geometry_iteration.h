// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_time_integrator_geometry_iteration_h
#define feib_plugins_time_integrator_geometry_iteration_h

#include <feib/error.h>
#include <feib/lagrangian_mesh.h>
#include <feib/message.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <vector>

namespace feib
{
  /// Finds the geometry that reproduces itself, G = g(G), by Anderson's method: the fixed point
  /// iteration, with the combination of the last results whose residuals cancel best (Walker, Ni,
  /// SIAM J. Numer. Anal. 49 (2011) 1715).
  template <int dim>
  class GeometryIteration
  {
  public:
    using Configuration = std::vector<Positions<dim>>;

    /// @p tolerance: the largest movement of a node, [length].
    explicit GeometryIteration(const double tolerance)
      : tolerance(tolerance)
    {}

    /// Tells g(G); whether it is G to the tolerance. Throws RunFailure when this does not come
    /// about.
    bool
    converged(const Configuration &G, const Configuration &g)
    {
      shape = G;
      Vector x, f;
      double largest = 0;
      for (unsigned int s = 0; s < G.size(); ++s)
        for (unsigned int i = 0; i < G[s].size(); ++i)
          for (unsigned int a = 0; a < dim; ++a)
            {
              x.push_back(G[s][i][a]);
              f.push_back(g[s][i][a] - G[s][i][a]);
              if (!(std::abs(f.back()) <= largest)) // NaN too
                largest = std::abs(f.back());
            }
      if (largest <= tolerance)
        return true;
      history += (history.empty() ? "" : ", ") + readable(largest / tolerance);
      // What has not begun to converge by then will not.
      best = count == 0 ? largest : std::min(best, largest);
      if (count == 0)
        first = largest;
      const unsigned int allowed = best < .03 * first ? max_iterations : max_iterations / 3;
      if (!std::isfinite(largest) || ++count > allowed)
        throw RunFailure("the geometry at the end of the step was not found in " +
                         std::to_string(allowed) +
                         " iterations; changes over tolerance: " + history);
      if (count > 1)
        {
          position_differences.push_back(difference(x, position));
          residual_differences.push_back(difference(f, residual));
          if (residual_differences.size() > memory)
            {
              position_differences.pop_front();
              residual_differences.pop_front();
            }
        }
      position = std::move(x);
      residual = std::move(f);
      return false;
    }

    /// The geometry to try after one that did not reproduce itself.
    Configuration
    next() const
    {
      // Least squares by Gram-Schmidt, the newest difference first; what depends on the others to
      // round-off is left out.
      Vector rest = residual, step = residual;
      std::vector<Vector> basis, images; // of residuals, orthonormal; of positions + residuals
      for (unsigned int j = residual_differences.size(); j-- > 0;)
        {
          Vector q = residual_differences[j], image = position_differences[j];
          add(image, 1., residual_differences[j]);
          const double before = std::sqrt(product(q, q));
          for (unsigned int pass = 0; pass < 2; ++pass)
            for (unsigned int k = 0; k < basis.size(); ++k)
              {
                const double share = product(basis[k], q);
                add(q, -share, basis[k]);
                add(image, -share, images[k]);
              }
          const double norm = std::sqrt(product(q, q));
          if (!(norm > 1e-8 * before))
            continue;
          for (double &value : q)
            value /= norm;
          for (double &value : image)
            value /= norm;
          basis.push_back(std::move(q));
          images.push_back(std::move(image));
          const double share = product(basis.back(), rest);
          add(rest, -share, basis.back());
          add(step, -share, images.back());
        }
      Configuration result = shape;
      unsigned int entry   = 0;
      for (auto &positions : result)
        for (auto &X : positions)
          for (unsigned int a = 0; a < dim; ++a, ++entry)
            X[a] = position[entry] + step[entry];
      return result;
    }

  private:
    using Vector = std::vector<double>;

    static constexpr unsigned int memory = 20, max_iterations = 60;

    static double
    product(const Vector &a, const Vector &b)
    {
      double sum = 0;
      for (unsigned int i = 0; i < a.size(); ++i)
        sum += a[i] * b[i];
      return sum;
    }

    static void
    add(Vector &a, const double factor, const Vector &b)
    {
      for (unsigned int i = 0; i < a.size(); ++i)
        a[i] += factor * b[i];
    }

    static Vector
    difference(Vector a, const Vector &b)
    {
      add(a, -1., b);
      return a;
    }

    const double tolerance;
    Configuration shape; // of the last geometry
    unsigned int count = 0;
    double first = 0, best = 0;
    std::string history;
    Vector position, residual; // the newest
    std::deque<Vector> position_differences, residual_differences;
  };
} // namespace feib

#endif
