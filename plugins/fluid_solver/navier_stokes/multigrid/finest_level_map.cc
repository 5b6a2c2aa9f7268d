// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/finest_level_map.h"

namespace feib
{
  template <int dim>
  FinestLevelMap<dim>::FinestLevelMap(const EulerianSpace<dim> &space,
                                      const LevelSpace<dim> &finest)
  {
    constexpr unsigned int n = LevelSpace<dim>::n, n_pressure = LevelSpace<dim>::n_pressure;
    LevelVector<float> u, p;
    finest.reinit_velocity(u);
    finest.reinit_pressure(p);
    const auto &partitioner = *space.velocity.get_partitioner();
    const auto &constraints = space.constraints();
    space_velocity.assign(u.locally_owned_size(), none);
    level_velocity.assign(space.velocity.locally_owned_size(), none);
    space_pressure.assign(p.locally_owned_size(), none);
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const unsigned int slot = finest.slots()[c];
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int a = 0; a < dim; ++a)
            {
              const unsigned int unknown = finest.node(slot, i) + a;
              const unsigned int dof     = space.velocity_dofs(c)[a * n + i];
              if (dof < level_velocity.size() && !finest.inactive(unknown))
                level_velocity[dof] = unknown;
              if (unknown >= space_velocity.size() || finest.inactive(unknown) ||
                  space_velocity[unknown] != none)
                continue;
              // Across a periodic boundary, two unknowns of the space are one here.
              unsigned int master = dof;
              const auto global   = partitioner.local_to_global(dof);
              if (constraints.is_constrained(global))
                master = partitioner.global_to_local(
                  constraints.get_constraint_entries(global)->front().first);
              space_velocity[unknown] = master;
            }
        for (unsigned int k = 0; k < n_pressure; ++k)
          space_pressure[finest.pressure(slot, k)] = space.pressure_dofs(c)[k];
      }
    for (unsigned int dof = 0; dof < level_velocity.size(); ++dof)
      if (constraints.is_constrained(partitioner.local_to_global(dof)))
        level_velocity[dof] = none;
  }


  template <int dim>
  void
  FinestLevelMap<dim>::import_velocity(const VelocityVector &from, LevelVector<float> &to) const
  {
    from.update_ghost_values();
    for (unsigned int i = 0; i < space_velocity.size(); ++i)
      to.begin()[i] = space_velocity[i] == none ? 0. : from.begin()[space_velocity[i]];
    from.zero_out_ghost_values();
  }


  template <int dim>
  void
  FinestLevelMap<dim>::export_velocity(const LevelVector<float> &from, VelocityVector &to) const
  {
    from.update_ghost_values();
    to.zero_out_ghost_values();
    for (unsigned int i = 0; i < level_velocity.size(); ++i)
      to.begin()[i] = level_velocity[i] == none ? 0. : from.begin()[level_velocity[i]];
  }


  template <int dim>
  void
  FinestLevelMap<dim>::import_pressure(const PressureVector &from,
                                       const float factor,
                                       LevelVector<float> &to) const
  {
    for (unsigned int i = 0; i < space_pressure.size(); ++i)
      to.begin()[i] = space_pressure[i] == none ? 0. : factor * from.begin()[space_pressure[i]];
  }


  template <int dim>
  void
  FinestLevelMap<dim>::export_pressure(const LevelVector<float> &from, PressureVector &to) const
  {
    to.zero_out_ghost_values();
    for (unsigned int i = 0; i < space_pressure.size(); ++i)
      if (space_pressure[i] != none)
        to.begin()[space_pressure[i]] = from.begin()[i];
  }


  template class FinestLevelMap<2>;
  template class FinestLevelMap<3>;
} // namespace feib
