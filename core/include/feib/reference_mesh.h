// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_reference_mesh_h
#define feib_reference_mesh_h

#include <feib/lagrangian_mesh.h>
#include <feib/parameters.h>

namespace feib
{
  /// Builds the reference mesh that the block names: an object with one key, one of
  /// closed_curve, open_curve, rectangle, periodic_strip, disc, ring, sphere, cylinder, ball, box,
  /// tube, gmsh, vtk.
  /// The keys each one takes are in the schemas of the structure models. Throws Error at the block
  /// when the mesh does not exist for this (structure_dim, dim), or the file is missing or of the
  /// wrong dimension. Collective on the ranks of the block.
  template <int dim>
  LagrangianMesh<dim> make_reference_mesh(const Parameters &mesh, unsigned int structure_dim);
} // namespace feib

#endif
