// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_body_force_h
#define feib_plugins_navier_stokes_body_force_h

#include <feib/eulerian_space.h>
#include <feib/expression.h>

#include <memory>

namespace feib
{
  /// The body force f [force/volume] of a case, if any, and its load: (f, v) for all v, or (f, R v)
  /// with the reconstruction R.
  template <int dim>
  class BodyForce
  {
  public:
    /// From "body_force" and "reconstruction" of the fluid.
    explicit BodyForce(const Parameters &parameters);

    bool
    exists() const
    {
      return force != nullptr;
    }

    /// What is wrong with f at the first of these times when something is. Collective.
    Issues check(const EulerianSpace<dim> &space, const std::vector<double> &times);

    /// The load at a time on the present mesh, not condensed; it stays until the next call.
    /// Collective. Throws RunFailure when f is not finite somewhere.
    const VelocityVector &load(const EulerianSpace<dim> &space, double time);

    /// What load() returned last.
    const VelocityVector &
    last_load() const
    {
      return present;
    }

  private:
    std::unique_ptr<Expressions<dim>> force;
    bool varies = false; // in time
    const bool reconstructs;
    VelocityVector present;
    unsigned int revision = 0; // of the mesh that it is for
  };
} // namespace feib

#endif
