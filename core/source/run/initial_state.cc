// SPDX-License-Identifier: LGPL-2.1-or-later
#include "initial_state.h"

#include <feib/inertial_load.h>

namespace feib
{
  template <int dim>
  void
  start_together(Components<dim> &components)
  {
    EulerianSpace<dim> &space = *components.space;
    for (const ImmersedStructure<dim> &structure : components.structures)
      structure.set_geometry(space, structure.model->positions);
    // Excess mass has a velocity of its own, which becomes that of the fluid as in an inelastic
    // collision: schemes that damp nothing would have the difference alternate for ever.
    InertialLoad<dim> inertia(space, components.structures, 1.);
    ImplicitLoad<dim> *const masses = inertia.empty() ? nullptr : &inertia;
    components.fluid->initialize(space, masses);
    if (components.earlier_flow)
      {
        components.earlier_flow->interpolate(space);
        components.fluid->project(space, masses);
      }
    space.old_velocity   = space.velocity;
    space.older_velocity = space.velocity;
    for (ImmersedStructure<dim> &structure : components.structures)
      structure.motion->interpolate(space, space.velocity, structure.model->velocities);
  }


  template <int dim>
  void
  find_initial_pressure(Components<dim> &components, const double dt)
  {
    EulerianSpace<dim> &space = *components.space;
    VelocityVector load       = space.make_velocity();
    NodalField<dim> force;
    for (const ImmersedStructure<dim> &structure : components.structures)
      {
        const StructureModel<dim> &model = *structure.model;
        model.load(model.positions, force);
        structure.spreading().spread(space, force, load);
        if (model.external())
          {
            model.external_load(model.positions, force);
            structure.spreading().spread(space, force, load);
          }
      }
    InertialLoad<dim> inertia(space, components.structures, 1.);
    components.fluid->find_pressure(space, {0., dt, load, inertia.empty() ? nullptr : &inertia});
  }


  template void start_together(Components<2> &);
  template void start_together(Components<3> &);
  template void find_initial_pressure(Components<2> &, double);
  template void find_initial_pressure(Components<3> &, double);
} // namespace feib
