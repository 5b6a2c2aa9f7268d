// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_structure_model_initial_state_h
#define feib_source_structure_model_initial_state_h

#include <feib/lagrangian_mesh.h>
#include <feib/parameters.h>

// What the block of a structure says of its mesh and its state at the start. All throw Error.
namespace feib
{
  /// The mesh with its materials, oriented at the @p positions, which are set to those at the
  /// start.
  template <int dim>
  LagrangianMesh<dim> make_structure_mesh(const Parameters &parameters,
                                          unsigned int structure_dim,
                                          Positions<dim> &positions);

  /// @p heavy: whether there is an excess mass, that has a velocity of its own. At rest when not
  /// given.
  template <int dim>
  NodalField<dim>
  initial_velocities(const Parameters &parameters, const LagrangianMesh<dim> &mesh, bool heavy);

  /// The excess density lumped to the nodes; empty when it is 0.
  template <int dim>
  std::vector<double> lumped_masses(const Parameters &parameters, const LagrangianMesh<dim> &mesh);
} // namespace feib

#endif
