// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_united_mesh_h
#define feib_united_mesh_h

#include <feib/lagrangian_mesh.h>

#include <string>
#include <vector>

namespace feib
{
  /// One mesh of several, whose nodes and elements come one after another: all of the k-th are of
  /// material k, by the name @p names[k]. Their remarks and element data are kept, their numbers
  /// and materials are not.
  template <int dim>
  LagrangianMesh<dim> united_mesh(const std::vector<LagrangianMesh<dim>> &meshes,
                                  const std::vector<std::string> &names);
} // namespace feib

#endif
