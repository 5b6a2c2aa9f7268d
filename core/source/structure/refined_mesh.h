// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_refined_mesh_h
#define feib_refined_mesh_h

#include <feib/lagrangian_mesh.h>

namespace feib
{
  /// Each element split in halves, 2^m of them: new nodes in the middle of all edges. Materials,
  /// their names, remarks and element data are kept, numbers of nodes are not.
  template <int dim>
  LagrangianMesh<dim> refined_mesh(const LagrangianMesh<dim> &mesh);
} // namespace feib

#endif
