// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_closed_parts_h
#define feib_source_closed_parts_h

#include <feib/lagrangian_mesh.h>

#include <vector>

namespace feib
{
  /// Which parts of a closed curve or surface, whose nodes are at @p X, must be turned for their
  /// normals to point out of what lies inside an odd number of them. @p part_of:
  /// LagrangianMesh::parts(). Remarks on parts that cross each other are added.
  template <int dim>
  std::vector<bool> parts_to_turn(const LagrangianMesh<dim> &mesh,
                                  const std::vector<unsigned int> &part_of,
                                  const Positions<dim> &X,
                                  std::vector<typename LagrangianMesh<dim>::Remark> &remarks);
} // namespace feib

#endif
