// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_checks_h
#define feib_structure_checks_h

#include "components.h"
#include "verdict.h"

namespace feib
{
  /// Warns of what is doubtful about the structures' meshes, whatever their state.
  template <int dim>
  void check_meshes(const Components<dim> &components, double time, Verdict &verdict);

  /// Warns of what makes the structures' geometry doubtful at the present state: elements longer
  /// than the fluid's cells, of bad shape, folded; structures near a wall. The same
  /// on all ranks.
  template <int dim>
  void check_structures(const Components<dim> &components, double time, Verdict &verdict);

  /// Warns of bodies that overlap. Takes the number of nodes times that of elements where they do.
  template <int dim>
  void check_overlap(const Components<dim> &components, double time, Verdict &verdict);
} // namespace feib

#endif
