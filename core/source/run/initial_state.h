// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_initial_state_h
#define feib_initial_state_h

#include "components.h"

namespace feib
{
  /// Makes the velocities that the case gives fluid and structures fit each other. Collective.
  template <int dim>
  void start_together(Components<dim> &components);

  /// The pressure of the initial state. @p dt: the step to follow, over which values on the
  /// boundary change. Collective.
  template <int dim>
  void find_initial_pressure(Components<dim> &components, double dt);
} // namespace feib

#endif
