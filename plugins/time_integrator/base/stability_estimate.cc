// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/time_integrator/stability_estimate.h>

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace feib
{
  template <int dim>
  StructureScales
  structure_scales(const StructureModel<dim> &model, const Positions<dim> &X)
  {
    const LagrangianMesh<dim> &mesh = model.mesh();
    const unsigned int m            = mesh.structure_dim();
    const auto stiffness            = model.stiffness(X);
    StructureScales result{0, stiffness.reference, stiffness.spatial, 0};
    std::vector<double> node_measures(mesh.n_nodes(), 0.);
    double reference_measure = 0, largest_J = 0, smallest_J = std::numeric_limits<double>::max();
    for (const auto &element : mesh.elements())
      {
        const double longest = mesh.longest_edge(element, X);
        const double size    = mesh.measure(element, X);
        result.longest_edge  = std::max(result.longest_edge, longest);
        largest_J            = std::max(largest_J, size / element.measure);
        smallest_J           = std::min(smallest_J, size / element.measure);
        reference_measure += element.measure;
        for (unsigned int k = 0; k <= m; ++k)
          node_measures[element.nodes[k]] += size / (m + 1);
      }
    double mass = 0;
    for (const double node_mass : model.excess_mass())
      mass += node_mass;
    result.excess_density = mass / (reference_measure * std::max(largest_J, 1e-12));
    result.nodal          = stiffness.forces.nodal / std::max(smallest_J, 1e-12);
    result.bending        = stiffness.forces.bending / std::max(smallest_J, 1e-12);
    result.dim            = dim;
    result.node_size =
      std::pow(*std::max_element(node_measures.begin(), node_measures.end()), 1. / m);
    return result;
  }


  template <int dim>
  Body
  body_of(const StructureModel<dim> &model)
  {
    return model.mesh().structure_dim() == dim ? Body::thick
           : dim == 2                          ? Body::curve
                                               : Body::surface;
  }


  double
  stable_step(const StructureScales &scales,
              const Body body,
              const bool midpoint,
              const double rho,
              const double mu,
              const double h_x)
  {
    using dealii::numbers::PI;
    const double C = body == Body::thick ? 1.9 : 1.3, T = 6, shortest = C * PI / h_x;
    // A surface in space has a third motion, along itself and along the crests of the wave: no
    // pressure acts on it and both sums count.
    const auto worst = [&](const double across, const double along) {
      return body == Body::surface ? across + along : std::max(across, along);
    };
    const auto impedance = [&](const double k, const double tau) {
      if (body == Body::thick)
        return rho / tau + mu * k * k;
      const double a2 = rho / (mu * tau), q = std::sqrt(k * k + a2), angle = std::atan(T * k / q);
      // q - k, and atan T - atan(T k/q), without cancellation.
      const double d      = a2 / (q + k);
      const double gap    = std::atan(T * (d / q) / (1 + T * T * k / q));
      const double across = k * (d / q * angle + gap), along = d * angle - k * gap;
      return PI * mu * a2 / worst(across, along);
    };
    const auto inertia = [&](const double k) {
      return body == Body::thick ? rho : PI * rho / (k * worst(std::atan(T), T - std::atan(T)));
    };
    // Nodes of a body that are few beside the fluid's concentrate their springs on motions that
    // peak there and move little fluid, the most where they lie in nodes of the fluid. Calibrated
    // there by bisection (README of tether).
    const double peak =
      body == Body::thick ? 1 + std::pow(5.3 * scales.node_size / h_x, scales.dim) : 1;
    const auto resists = [&](const double k, const double dt) {
      const double stiffness =
        scales.spatial_kappa * k * k + scales.nodal * peak + scales.bending * k * k * k * k;
      if (midpoint)
        return stiffness * dt * dt < 4 * (inertia(k) + scales.excess_density);
      return stiffness * dt < 2 * (impedance(k, dt / 2) + scales.excess_density / (dt / 2));
    };
    // The stiffness of laws and of bending is worst at the shortest wave that the fluid carries;
    // that of nodes is so at the one that moves least fluid.
    const unsigned int n_waves = scales.nodal > 0 ? 12 : 0;
    const auto stable          = [&](const double dt) {
      bool result = resists(shortest, dt);
      for (unsigned int i = 1; i <= n_waves; ++i)
        result = result && resists(shortest * std::pow(.5, i), dt);
      return result;
    };
    double lower = 1e-12, upper = 1e12;
    if (!(scales.spatial_kappa > 0 || scales.nodal > 0 || scales.bending > 0) || stable(upper))
      return std::numeric_limits<double>::infinity();
    while (upper / lower > 1 + 1e-9)
      {
        const double middle              = std::sqrt(lower * upper);
        (stable(middle) ? lower : upper) = middle;
      }
    return lower;
  }


  template StructureScales structure_scales(const StructureModel<2> &, const Positions<2> &);
  template StructureScales structure_scales(const StructureModel<3> &, const Positions<3> &);
  template Body body_of(const StructureModel<2> &);
  template Body body_of(const StructureModel<3> &);
} // namespace feib
