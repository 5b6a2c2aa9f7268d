// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_law_check_h
#define feib_law_check_h

#include <feib/parameters.h>
#include <feib/structure_model.h>

namespace feib
{
  /// Tries whether the load of a structure is the derivative of its energy, and what it says of the
  /// load's derivative, by differences about a state near the start; and whether anything resists.
  /// Throws Error at the structure's law: not finite, a wrong stress or derivative (with the
  /// factor, when it is one), an energy that changes with rotations, or that falls however the
  /// structure is stretched, or grows when the state moves on. Takes some twenty evaluations of
  /// energy and load, and leaves the structure as it was. Collective.
  ///
  /// @p slot: the block that holds the component's name as its key.
  template <int dim>
  void check_law(StructureModel<dim> &model, const Parameters &slot);
} // namespace feib

#endif
