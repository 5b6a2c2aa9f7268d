// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_velocity_constraints_h
#define feib_source_velocity_constraints_h

#include <feib/domain.h>
#include <feib/lattice.h>

#include <deal.II/dofs/dof_handler.h>
#include <deal.II/lac/affine_constraints.h>

namespace feib
{
  /// Hanging nodes, periodicity and boundary conditions at time @p t of the Q2 velocity on the
  /// cells of a box, for the locally @p relevant unknowns and those their constraints lead to;
  /// closed.
  /// @p lattice: that of the nodes. Of prescribed velocities, what goes out of the box is less by
  /// the @p share, and what comes in is more by it. Collective.
  ///
  /// Instead of deal.II's functions for hanging nodes and periodicity, whose lines differ between
  /// ranks where a mesh is refined across a periodic boundary, so that
  /// AffineConstraints::make_consistent_in_parallel does not end: nodes are compared by their place
  /// in the box, which is integer arithmetic, and the owner of an unknown decides.
  template <int dim>
  dealii::AffineConstraints<double>
  make_velocity_constraints(const dealii::DoFHandler<dim> &handler,
                            const Domain<dim> &box,
                            const Lattice<dim> &lattice,
                            const dealii::IndexSet &relevant,
                            double t,
                            double share = 0);

  /// Hanging nodes and periodicity alone: what makes a velocity continuous, whatever its time. For
  /// AffineConstraints::distribute, on vectors of owned unknowns. Collective.
  template <int dim>
  dealii::AffineConstraints<double>
  make_continuity_constraints(const dealii::DoFHandler<dim> &handler,
                              const Lattice<dim> &lattice,
                              const dealii::IndexSet &relevant);
} // namespace feib

#endif
