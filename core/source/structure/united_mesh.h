// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_united_mesh_h
#define feib_united_mesh_h

#include <feib/lagrangian_mesh.h>

#include <string>
#include <vector>

namespace feib
{
  /// The reference place of a corner of an element: that of its node but across a seam, where it
  /// follows from the shape functions, which are 1 at one corner and 0 at the others.
  template <int dim>
  dealii::Point<dim> element_corner(const LagrangianMesh<dim> &mesh,
                                    const typename LagrangianMesh<dim>::Element &element,
                                    unsigned int k);

  /// One mesh of several, whose nodes and elements come one after another: all of the k-th are of
  /// material k, by the name @p names[k]. Their remarks and element data are kept, their numbers
  /// and materials are not.
  template <int dim>
  LagrangianMesh<dim> united_mesh(const std::vector<LagrangianMesh<dim>> &meshes,
                                  const std::vector<std::string> &names);
} // namespace feib

#endif
