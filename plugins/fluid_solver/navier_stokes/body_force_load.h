// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_body_force_load_h
#define feib_plugins_navier_stokes_body_force_load_h

#include "cell_operators.h"

#include <deal.II/base/function.h>

namespace feib
{
  /// (f, v) for all v, not condensed; with a @p reconstruction (f, R v). Gauss rules of 4 points
  /// per direction, with R of 8, so that a smooth gradient f does no work on R v beside round-off.
  /// @p force: f [force/volume], at its time. Collective.
  template <int dim>
  VelocityVector load_of_body_force(const EulerianSpace<dim> &space,
                                    const dealii::Function<dim> &force,
                                    const Reconstruction<dim> *reconstruction);
} // namespace feib

#endif
