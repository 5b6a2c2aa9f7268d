// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_fluid_solver_h
#define feib_fluid_solver_h

#include <feib/archive.h>
#include <feib/check_context.h>
#include <feib/eulerian_space.h>
#include <feib/implicit_load.h>
#include <feib/parameters.h>

#include <vector>

namespace feib
{
  /// Advances the fluid by one step.
  template <int dim>
  class FluidSolver
  {
  public:
    static constexpr const char *kind = "fluid_solver";

    /// One backward Euler step to the time @p time, of length @p dt. A scheme may go on from there
    /// in the same direction, by the time @p beyond: velocities and fluxes that are prescribed then
    /// are so at the end of that.
    struct Step
    {
      double time;
      double dt;
      const VelocityVector &load; // <F, v> on all degrees of freedom, before condensing
      ImplicitLoad<dim> *implicit_load = nullptr; // joins the load, at the velocity computed
      double beyond                    = 0;
    };

    /// What the fluid gets through a boundary condition: by the reaction where the velocity is
    /// prescribed, and by the traction where fluid crosses.
    struct BoundaryExchange
    {
      double flux  = 0; // out of the box [volume/time]
      double power = 0;
      dealii::Tensor<1, dim> force;
      dealii::Tensor<1, 3> torque; // about the origin; the third component in 2D
      double pressure = 0;         // the mean one on the face [force/area]
    };

    /// What a step took, and where its power went: the momentum equation tested with the velocity
    /// u computed. With rho/dt (u - u^n, u) the rate of the kinetic energy,
    ///   rho/dt (u - u^n, u) + dissipation + convection_power
    ///     = boundary_power + body_force_power + <F, u>      up to the solver's tolerance.
    struct Report
    {
      unsigned int linear_iterations    = 0;
      unsigned int nonlinear_iterations = 0;
      double dissipation                = 0; // a(u,u) with the viscous form chosen
      double convection_power           = 0; // leaves through open faces, >= 0 unless static_inflow
      double boundary_power             = 0; // of reactions where u is prescribed, and tractions
      double body_force_power           = 0; // (f, u)
      double increment_energy           = 0; // rho/2 |u - u^n|^2
      /// Of each of the domain's conditions; empty: the solver does not say.
      std::vector<BoundaryExchange> boundary;
    };

    /// Integrals over the fluid at the state of the space.
    struct Balance
    {
      double kinetic_energy = 0;
      dealii::Tensor<1, dim> momentum;
      dealii::Tensor<1, 3> angular_momentum; // about the origin; the third component in 2D
      double largest_velocity = 0;           // at the nodes
      double divergence       = 0;           // |div u_h|_0
      double cfl_rate         = 0;           // max over cells of sum_a |u_a|/h_a; times dt = CFL
    };

    virtual ~FluidSolver() = default;

    /// Before a run, when nothing has been written: throws Error with all that the case asks for
    /// and that cannot be. Collective.
    virtual void
    check(const CheckContext<dim> &)
    {}

    /// Sets space.velocity to the initial velocity, projected as project() does, and space.pressure
    /// to zero.
    virtual void initialize(EulerianSpace<dim> &space, ImplicitLoad<dim> *inertia = nullptr) = 0;

    /// From space.old_velocity (and, for extrapolation, space.older_velocity and space.old_dt) to
    /// space.velocity and space.pressure, which hold a first guess on entry. Collective. Throws
    /// RunFailure when a solve does not reach its tolerance; space.old_velocity is untouched.
    virtual Report advance(EulerianSpace<dim> &space, const Step &step) = 0;

    /// The step is accepted: what advance() found last is the past from now on. Until then a
    /// further call of advance() is for the same step, with another load or another geometry.
    virtual void
    commit()
    {}

    /// What the solver carries from step to step, beside the state of the space. Collective.
    virtual void
    archive(Archive &)
    {}

    /// Makes space.velocity u discretely divergence-free by the least change of the fluid's
    /// velocity in L2, rho/2 |u - given u|^2. With @p inertia, the load J^T [ -M (J u - V) ] of
    /// masses that move with the fluid and had the velocity V, plus M/2 |J u - V|^2: the momentum
    /// given is kept. Collective.
    virtual void project(EulerianSpace<dim> &space, ImplicitLoad<dim> *inertia = nullptr) = 0;

    /// Sets space.pressure to that of the state at step.time: with it the acceleration under all
    /// forces is divergence-free, and on the boundary that of the values prescribed between
    /// step.time and step.time + step.dt. Of step.implicit_load, here J^T [ -M J du/dt ], the
    /// derivative alone is used. Without an implementation the pressure is left as it is.
    /// Collective.
    virtual void
    find_pressure(EulerianSpace<dim> &space, const Step &step)
    {
      (void)space;
      (void)step;
    }

    /// rho [mass/volume] and mu [force time/area].
    virtual double density() const   = 0;
    virtual double viscosity() const = 0;

    /// Collective; the same on all ranks.
    virtual Balance balance(const EulerianSpace<dim> &space) = 0;
  };
} // namespace feib

#endif
