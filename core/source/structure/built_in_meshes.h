// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_built_in_meshes_h
#define feib_built_in_meshes_h

#include <feib/lagrangian_mesh.h>
#include <feib/parameters.h>

#include <string>
#include <vector>

namespace feib
{
  /// A mesh that Feib builds itself. The keys of its block are in the schemas of the structure
  /// models.
  template <int dim>
  struct BuiltInMesh
  {
    std::string name;
    unsigned int structure_dim;
    LagrangianMesh<dim> (*make)(const Parameters &block);
  };

  template <int dim>
  const std::vector<BuiltInMesh<dim>> &built_in_meshes();
  template <>
  const std::vector<BuiltInMesh<2>> &built_in_meshes();
  template <>
  const std::vector<BuiltInMesh<3>> &built_in_meshes();

  /// Why there are no curves in three dimensions.
  inline std::string
  no_curves_in_space()
  {
    return "curves in dimension 3 are not supported: beside a force on a line the velocity has no "
           "bound, so that a filament would move the faster the finer the fluid's cells are; its "
           "thickness decides, so make it a thin body (cylinder, tube) or a strip (rectangle)";
  }

  /// A disc of concentric rings of triangles.
  LagrangianMesh<2> disc_mesh(const dealii::Point<2> &centre,
                              double radius,
                              unsigned int rings,
                              MPI_Comm communicator);

  /// A ring of n[0] cells around and n[1] across, two triangles each. Throws Error at a key of
  /// @p block, which has "inner_radius", "outer_radius" and "cells".
  LagrangianMesh<2>
  ring_mesh(const Parameters &block, const dealii::Point<2> &centre, const std::vector<int> &n);
} // namespace feib

#endif
