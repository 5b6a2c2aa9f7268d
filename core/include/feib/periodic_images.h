// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_periodic_images_h
#define feib_periodic_images_h

#include <feib/domain.h>
#include <feib/lagrangian_mesh.h>

#include <vector>

namespace feib
{
  /// For each node of a structure at @p X itself or, where the structure reaches across a periodic
  /// box and begins anew, the first node that is whole periods away: both are one point of it.
  template <int dim>
  std::vector<unsigned int> periodic_images(const Domain<dim> &domain,
                                            const LagrangianMesh<dim> &mesh,
                                            const Positions<dim> &X);
} // namespace feib

#endif
