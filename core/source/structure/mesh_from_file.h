// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_mesh_from_file_h
#define feib_mesh_from_file_h

#include "mesh_file.h"

#include <feib/lagrangian_mesh.h>

namespace feib
{
  /// The structure that a file describes: its elements of dimension @p structure_dim and the nodes
  /// they use, as remarks tell. @p merge: nodes at one place become one. @p path: of the file, for
  /// messages. Throws Error where the file holds no such structure.
  template <int dim>
  LagrangianMesh<dim> mesh_from_file(const MeshFile &file,
                                     const std::string &path,
                                     unsigned int structure_dim,
                                     bool merge,
                                     MPI_Comm communicator);
} // namespace feib

#endif
