// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_finest_level_map_h
#define feib_plugins_navier_stokes_finest_level_map_h

#include "multigrid/level_space.h"

#include <vector>

namespace feib
{
  /// Between vectors of the space and those of the finest level, which number the same unknowns
  /// otherwise. Sources are owned values; constrained entries are zero.
  template <int dim>
  class FinestLevelMap
  {
  public:
    FinestLevelMap(const EulerianSpace<dim> &space, const LevelSpace<dim> &finest);

    void import_velocity(const VelocityVector &from, LevelVector<float> &to) const;
    void export_velocity(const LevelVector<float> &from, VelocityVector &to) const;
    void import_pressure(const PressureVector &from, float factor, LevelVector<float> &to) const;
    void export_pressure(const LevelVector<float> &from, PressureVector &to) const;

  private:
    static constexpr unsigned int none = static_cast<unsigned int>(-1);

    // The unknowns of the space: for each of the finest level, and back.
    std::vector<unsigned int> space_velocity, level_velocity, space_pressure;
  };
} // namespace feib

#endif
