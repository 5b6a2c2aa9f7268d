// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_time_integrator_structure_step_h
#define feib_source_time_integrator_structure_step_h

#include <feib/time_integrator.h>

namespace feib
{
  /// The step of one structure, and what it means for energy, force and measure.
  template <int dim>
  class StructureStep
  {
  public:
    using Exchange = typename TimeIntegrator<dim>::Exchange;
    using Impulse  = typename TimeIntegrator<dim>::Impulse;

    /// What the solution of the fluid means for the structure.
    struct Motion
    {
      const Positions<dim> &geometry;     // where J is
      const NodalField<dim> &U;           // velocities of the nodes, J u_s
      const Positions<dim> &loaded;       // where the load is taken
      const NodalField<dim> &force;       // the load, that acts at the load points
      const NodalField<dim> &other_force; // viscous and external; empty without
    };

    /// A step from @p time to time + dt. Arguments must outlive the object.
    StructureStep(const EulerianSpace<dim> &space,
                  const ImmersedStructure<dim> &structure,
                  const Motion &motion,
                  double time,
                  double dt,
                  bool midpoint);

    /// Moves the structure by dt U, and the state of its laws; @p energy: that of the structure at
    /// the beginning. Collective.
    Exchange take(double energy);

  private:
    /// What the fluid gets from forces at points @p x, which move with the velocities.
    static Impulse impulse(const NodalField<dim> &forces,
                           const Positions<dim> &x,
                           const NodalField<dim> &velocities);

    /// Adds that to what the fluid gets from the structure.
    void add_forces(const NodalField<dim> &forces,
                    const Positions<dim> &x,
                    const NodalField<dim> &velocities);

    /// The forces that acted at the load points, the work of the load along the way of the step and
    /// the energy it comes from, @p energy at the beginning.
    void add_elastic(double energy);

    /// The work of the load along the way from @p old, with the moment as it is.
    double work_along_the_way(const Positions<dim> &old, const NodalField<dim> &velocity) const;

    /// The inertia of the excess mass; the velocities move to the end of the step.
    void add_inertial();

    /// dt A'(geometry)[U] of the measure A.
    double leak() const;

    const EulerianSpace<dim> &space;
    const ImmersedStructure<dim> &structure;
    StructureModel<dim> &model;
    const Motion motion;
    const NodalField<dim> &U;
    const double time, dt;
    const bool midpoint;
    Exchange exchange;
  };
} // namespace feib

#endif
