// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_time_integrator_coupled_scheme_h
#define feib_time_integrator_coupled_scheme_h

#include <feib/time_integrator.h>
#include <feib/time_integrator/error_estimate.h>

namespace feib
{
  /// The schemes of Feib are one step with three choices. With tau = dt for the Euler schemes and
  /// dt/2 for the midpoint schemes, the fluid makes a backward Euler step of length tau to u_s
  /// under the load
  ///   J^T [ F(Y) + F_v(X_g, J u_s) + F_e(X_g) - M/tau (J u_s - V^n) ],
  /// J taken at the geometry X_g; the structures move by X^{n+1} = X^n + dt J u_s. F is that of the
  /// time of Y; the state of laws is held, and moves on at the end. Midpoint schemes
  /// extrapolate to the end of the step, u^{n+1} = 2 u_s - u^n, V^{n+1} = 2 J u_s - V^n: with tau =
  /// dt/2 this is the midpoint rule (Crank-Nicolson) for the fluid. M is the excess mass, F_v the
  /// viscous load of laws and forces that have one, linear in J u_s: implicit in every scheme. F_e
  /// is the load of forces that come from no energy.
  ///
  /// | scheme          | X_g                     | Y                    |
  /// |-----------------|-------------------------|----------------------|
  /// | fe_be           | X^n                     | X_g                  |
  /// | lagged_be       | X^n                     | X^n + tau J u_s      |
  /// | be_be           | X^{n+1}                 | X^n + tau J u_s      |
  /// | midpoint        | X^n + dt/2 J(X^n) u^n   | X_g                  |
  /// | lagged_midpoint | X^n + dt/2 J(X^n) u^n   | X^n + tau J u_s      |
  struct SchemeChoices
  {
    bool midpoint;
    bool implicit_force;
    /// Solutions with the geometry of the last one, until it moves less than this part of the
    /// fluid's smallest edge; 0: as many as corrections says.
    double geometry_tolerance = 0;
    unsigned int corrections  = 0;
  };


  template <int dim>
  class CoupledScheme : public TimeIntegrator<dim>
  {
  public:
    using System         = typename TimeIntegrator<dim>::System;
    using Report         = typename TimeIntegrator<dim>::Report;
    using StabilityLimit = typename TimeIntegrator<dim>::StabilityLimit;

    explicit CoupledScheme(const SchemeChoices &choices);

    Report step(System &system, double time, double dt) override;

    StabilityLimit stability_limit(const System &system) const override;

    void archive(Archive &archive) override;

    /// Of explicit schemes: what stability depends on.
    std::vector<std::pair<std::string, double>> diagnostics(const System &system,
                                                            double dt) const override;

  private:
    using Configuration = std::vector<Positions<dim>>; // of all structures

    /// A solution of the fluid with J at a geometry, and what the structures do under it.
    struct Solution
    {
      Configuration geometry;
      Configuration loaded;                      // Y
      std::vector<NodalField<dim>> velocities;   // of their nodes, J u_s
      std::vector<NodalField<dim>> forces;       // F(Y), that acted at their load points
      std::vector<NodalField<dim>> other_forces; // viscous and external; empty without
    };

    /// X^n + dt/2 J(X^n) u^n, or X^n.
    Configuration first_geometry(System &system, double dt) const;

    /// One solution with J at the geometry; space.velocity becomes u_s. The structures' positions
    /// and velocities are left alone.
    Solution solve(System &system,
                   double time,
                   double tau,
                   const Configuration &geometry,
                   Report &report) const;

    /// As many solutions as it takes until J is where it should be.
    Solution find_geometry(System &system, double time, double dt, Report &report) const;

    /// The energies before the step of the structures, which are then asked for the time of the
    /// load.
    std::vector<double> begin_structures(System &system, double time, double dt) const;

    const SchemeChoices choices;
    ErrorEstimate<dim> error_estimate;
  };
} // namespace feib

#endif
