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

    /// @p geometry: where J is. @p U: velocities of the nodes, J u_s. @p force: the elastic force
    /// that acts at the load points. Arguments must outlive the object.
    StructureStep(const EulerianSpace<dim> &space,
                  const ImmersedStructure<dim> &structure,
                  const Positions<dim> &geometry,
                  const NodalField<dim> &U,
                  const NodalField<dim> &force,
                  double dt,
                  bool midpoint);

    /// Moves the structure by dt U. Collective.
    Exchange take();

  private:
    /// Adds a force on the fluid at @p x, which moves with the velocity.
    void add_force(const dealii::Tensor<1, dim> &force,
                   const dealii::Point<dim> &x,
                   const dealii::Tensor<1, dim> &velocity);

    /// The elastic force that acted, the work of the load along the way of the step and the energy
    /// it comes from.
    void add_elastic();

    /// The inertia of the excess mass; the velocities move to the end of the step.
    void add_inertial();

    /// dt A'(geometry)[U] of the measure A.
    double leak() const;

    const EulerianSpace<dim> &space;
    const ImmersedStructure<dim> &structure;
    StructureModel<dim> &model;
    const Positions<dim> &geometry;
    const NodalField<dim> &U, &force;
    const double dt;
    const bool midpoint;
    Exchange exchange;
  };
} // namespace feib

#endif
