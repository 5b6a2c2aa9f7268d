// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_time_integrator_h
#define feib_time_integrator_h

#include <feib/archive.h>
#include <feib/fluid_solver.h>
#include <feib/immersed_structure.h>
#include <feib/timers.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// Orders the calls of one step.
  template <int dim>
  class TimeIntegrator
  {
  public:
    static constexpr const char *kind = "time_integrator";

    /// What a step works on.
    struct System
    {
      EulerianSpace<dim> &space;
      FluidSolver<dim> &fluid;
      std::vector<ImmersedStructure<dim>> &structures;
      Timers &timers;
    };

    /// What the fluid gets, averages over the step.
    struct Impulse
    {
      double power = 0; // the work of the forces on u, per time
      dealii::Tensor<1, dim> force;
      dealii::Tensor<1, 3> torque; // about the origin; the third component in 2D
    };

    /// What the fluid gets from one structure: by elastic, viscous and inertial forces and those of
    /// StructureForce.
    struct Exchange : Impulse
    {
      /// The part that each force of the structure has in that, in their order.
      std::vector<Impulse> forces;
      /// The part of the change of the measure over the step that comes from a flux of the discrete
      /// velocity through the structure: dt A'(X)[J u] at the X where J is taken. The rest is
      /// error of the time scheme. Zero for open curves and surfaces.
      double leak = 0;
      /// Energy of the structure, elastic and kinetic of its excess mass, that the step lost beside
      /// its work on the fluid: by the theory of the scheme, and the rest. The rest is that of
      /// E(X^n) - E(X^{n+1}) which is not the work of the load along the way: none for a law whose
      /// stress is the derivative of its energy.
      double numerical   = 0;
      double unexplained = 0;
      /// Energy that left the structure neither as elastic work nor by the scheme: what viscosity
      /// and the state of its laws dissipated, less what came in where a law or a force depends on
      /// time, or comes from no energy.
      double inelastic = 0;
      /// The work of the load along the way of the step, without sign: the measure of
      /// unexplained energy.
      double elastic_work = 0;
      /// E(X^{n+1}), of laws and forces, which the ledger takes from here. A scheme must set it.
      double elastic_energy = std::numeric_limits<double>::quiet_NaN();
    };

    /// What a step took, and where its energy went: with K and E the kinetic and the elastic
    /// energy,
    ///   K + E at the end - K - E at the beginning + dissipated + convected + numerical
    ///     + unexplained + inelastic = boundary_work + body_work   up to the tolerance of the
    ///     solver,
    /// inelastic being the sum over the exchanges.
    struct Report
    {
      unsigned int linear_iterations    = 0;
      unsigned int nonlinear_iterations = 0;
      unsigned int geometry_iterations  = 0; // solutions with another geometry, for one step
      double dissipated                 = 0; // by viscosity
      double convected                  = 0; // left through open faces
      double boundary_work              = 0;
      double body_work                  = 0;
      double numerical   = 0; // lost (gained when negative) by the time scheme, by its theory
      double unexplained = 0; // lost, and neither scheme nor solver explain it
      /// An estimate of the error that this step adds to displacements [length]; negative: the
      /// scheme has none; infinite: there are not yet enough steps to tell.
      double displacement_error = -1;
      std::vector<Exchange> exchanges; // one per structure
      /// What the fluid gets through the box's faces, averages over the step.
      std::vector<typename FluidSolver<dim>::BoundaryExchange> boundary;
    };

    /// The largest stable step, the structure that sets it and a scheme without such a limit.
    struct StabilityLimit
    {
      double dt = std::numeric_limits<double>::infinity();
      std::string structure, alternative;
    };

    virtual ~TimeIntegrator() = default;

    /// From the time @p time to time + dt: on entry space.old_velocity is u^n and the structures
    /// hold X^n; on return space.velocity and the structures hold the new state. Collective.
    virtual Report step(System &system, double time, double dt) = 0;

    /// What the object carries from step to step. Collective.
    virtual void
    archive(Archive &)
    {}

    /// The estimate of the largest stable step at the present state; infinite for a scheme that has
    /// no limit. Collective.
    virtual StabilityLimit
    stability_limit(const System &system) const
    {
      (void)system;
      return {};
    }

    /// Columns of the ledger that belong to the scheme (for fe_be: eta of each structure), at the
    /// present state. The same names at every call. Collective.
    virtual std::vector<std::pair<std::string, double>>
    diagnostics(const System &system, double dt) const
    {
      (void)system;
      (void)dt;
      return {};
    }
  };
} // namespace feib

#endif
