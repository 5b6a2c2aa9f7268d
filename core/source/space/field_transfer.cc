// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field_transfer.h"

namespace feib
{
  template <int dim>
  FieldTransfer<dim>::FieldTransfer(EulerianSpace<dim> &space)
    : space(space)
    , velocity_transfer(space.velocity_handler())
    , pressure_transfer(space.pressure_handler())
  {
    // The next step extrapolates from these two; what is older is not needed again.
    for (VelocityVector *v : {&space.velocity, &space.old_velocity})
      v->update_ghost_values();
    pressures = {&space.pressure};
    for (auto &earlier : space.earlier_pressures)
      pressures.push_back(&earlier.values);
    for (PressureVector *p : pressures)
      p->update_ghost_values();
    velocity_transfer.prepare_for_coarsening_and_refinement(
      std::vector<const VelocityVector *>{&space.velocity, &space.old_velocity});
    pressure_transfer.prepare_for_coarsening_and_refinement(
      std::vector<const PressureVector *>(pressures.begin(), pressures.end()));
  }


  template <int dim>
  void
  FieldTransfer<dim>::finish()
  {
    VelocityVector moved[2] = {space.make_velocity(), space.make_velocity()};
    std::vector<PressureVector> moved_pressures(pressures.size(), space.make_pressure());
    std::vector<PressureVector *> all_pressures;
    for (PressureVector &p : moved_pressures)
      all_pressures.push_back(&p);
    std::vector<VelocityVector *> all = {&moved[0], &moved[1]};
    velocity_transfer.interpolate(all);
    pressure_transfer.interpolate(all_pressures);
    space.velocity.swap(moved[0]);
    space.old_velocity.swap(moved[1]);
    for (unsigned int i = 0; i < pressures.size(); ++i)
      {
        pressures[i]->swap(moved_pressures[i]);
        pressures[i]->update_ghost_values();
      }
  }


  template class FieldTransfer<2>;
  template class FieldTransfer<3>;
} // namespace feib
