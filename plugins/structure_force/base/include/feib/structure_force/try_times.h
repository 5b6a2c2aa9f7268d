// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_force_try_times_h
#define feib_structure_force_try_times_h

#include <feib/expression.h>
#include <feib/structure_force.h>

#include <initializer_list>

namespace feib
{
  /// Asks a force for the times of its body, then for the start. Throws Error where one of the
  /// expressions it is made from (null: not given) was not finite.
  template <int dim>
  void
  try_times(StructureForce<dim> &force,
            const typename StructureForce<dim>::Body &body,
            const std::initializer_list<Expressions<dim> *> &expressions)
  {
    for (const double time : body.times)
      force.set_moment(time, 0.);
    for (Expressions<dim> *expression : expressions)
      if (expression)
        if (const Issues issues = expression->not_finite(MPI_COMM_SELF); !issues.empty())
          throw Error(issues);
    force.set_moment(0., 0.);
  }
} // namespace feib

#endif
