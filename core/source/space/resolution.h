// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_resolution_h
#define feib_resolution_h

#include <feib/eulerian_space.h>

namespace feib
{
  /// How rough a velocity is for its mesh: of what it varies within cells (the square of its
  /// distance from each cell's mean), the part that is not linear there. Of the order of (k h)^2/15
  /// for waves of number k on cells of size h, and about one half for what has no scale but the
  /// cells'. A stream that carries all adds nothing. Collective.
  template <int dim>
  double roughness(const EulerianSpace<dim> &space);
} // namespace feib

#endif
