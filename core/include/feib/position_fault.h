// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_position_fault_h
#define feib_position_fault_h

#include <feib/lagrangian_mesh.h>

#include <string>

namespace feib
{
  /// Why nodes at @p X make no structure: elements without length, area or volume; in a body also
  /// elements turned over against the others, or one whose centre lies in another (so that most of
  /// a doubly filled part of the space is found). "" when nothing is wrong. What is said follows
  /// "initial_position".
  template <int dim>
  std::string position_fault(const LagrangianMesh<dim> &mesh, const Positions<dim> &X);
} // namespace feib

#endif
