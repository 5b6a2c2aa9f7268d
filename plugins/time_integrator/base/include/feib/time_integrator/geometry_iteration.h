// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_time_integrator_geometry_iteration_h
#define feib_time_integrator_geometry_iteration_h

#include <feib/lagrangian_mesh.h>

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
    using Configuration = std::vector<Positions<dim>>; // of all structures

    /// @p tolerance: the largest movement of a node, [length].
    explicit GeometryIteration(double tolerance);

    /// Tells g(G); whether it is G to the tolerance. Throws RunFailure when this does not come
    /// about.
    bool converged(const Configuration &G, const Configuration &g);

    /// The geometry to try after one that did not reproduce itself.
    Configuration next() const;

  private:
    using Vector = std::vector<double>;

    static constexpr unsigned int memory = 20, max_iterations = 60;

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
