// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/error.h>
#include <feib/message.h>
#include <feib/time_integrator/geometry_iteration.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    using Vector = std::vector<double>;

    double
    product(const Vector &a, const Vector &b)
    {
      double sum = 0;
      for (unsigned int i = 0; i < a.size(); ++i)
        sum += a[i] * b[i];
      return sum;
    }

    void
    add(Vector &a, const double factor, const Vector &b)
    {
      for (unsigned int i = 0; i < a.size(); ++i)
        a[i] += factor * b[i];
    }

    Vector
    difference(Vector a, const Vector &b)
    {
      add(a, -1., b);
      return a;
    }
  } // namespace


  template <int dim>
  GeometryIteration<dim>::GeometryIteration(const double tolerance)
    : tolerance(tolerance)
  {}


  template <int dim>
  bool
  GeometryIteration<dim>::converged(const Configuration &G, const Configuration &g)
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
                       std::to_string(allowed) + " iterations; changes over tolerance: " + history);
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


  template <int dim>
  typename GeometryIteration<dim>::Configuration
  GeometryIteration<dim>::next() const
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


  template class GeometryIteration<2>;
  template class GeometryIteration<3>;
} // namespace feib
