// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_time_integrator_stability_estimate_h
#define feib_time_integrator_stability_estimate_h

#include <feib/structure_model.h>

namespace feib
{
  /// What the stability of an explicit scheme depends on, for one structure at positions X.
  struct StructureScales
  {
    double longest_edge;   // L^n, of a deformed element [length]
    double kappa;          // largest eigenvalue of d2W/dF2
    double spatial_kappa;  // the same per present measure and length
    double excess_density; // excess mass per present measure
    double nodal     = 0;  // of forces, see StructureForce::Stiffness, per present measure
    double bending   = 0;
    double node_size = 0; // edge of a square or cube of the largest measure that a node stands for
    int dim          = 2;
  };

  /// Collective.
  template <int dim>
  StructureScales structure_scales(const StructureModel<dim> &model, const Positions<dim> &X);

  enum class Body
  {
    thick,  // of the dimension of the space
    curve,  // in two dimensions
    surface // in three
  };

  template <int dim>
  Body body_of(const StructureModel<dim> &model);

  /// The largest stable step of a scheme that takes the elastic force explicitly.
  ///
  /// Linear analysis, for displacements of wave number k of a flat structure in a resting fluid,
  /// with K = kappa k^2 + nodal + bending k^4. In terms of the impedance Z(k, tau), the force per
  /// measure that gives the structure unit velocity in one backward Euler step tau of the fluid,
  ///   fe_be:     stable while K dt < 2 Z(k, dt/2),
  ///   midpoint:  stable while K dt < 4 Z(k, dt) with the inertial part of Z alone (mu =
  ///   0).
  /// A thick body moves all fluid it occupies, Z = rho/tau + mu k^2. A curve or surface moves the
  /// fluid beside it, a Fourier sum over wave numbers l normal to it, with a^2 = rho/(mu tau):
  ///   1/Z = 1/(2 pi mu) int [k^2 or l^2]/(k^2 + l^2) 1/(k^2 + l^2 + a^2) dl
  /// across (k^2) or along it (l^2); the larger counts. An excess density adds delta_rho/tau. Q2
  /// velocities on cells of size h_x carry k up to C pi/h_x and l up to T k; C and T are calibrated
  /// by bisection (docs/choosing.md).
  double stable_step(const StructureScales &scales,
                     Body body,
                     bool midpoint,
                     double rho,
                     double mu,
                     double h_x);
} // namespace feib

#endif
