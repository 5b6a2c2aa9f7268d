// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_force_try_times_h
#define feib_structure_force_try_times_h

#include <feib/expression.h>
#include <feib/failure.h>
#include <feib/structure_force.h>

#include <functional>
#include <initializer_list>

namespace feib
{
  /// Has a force take its expressions (null: not given) at the times of its body, then at the
  /// start. Throws Error where one was not finite.
  template <int dim>
  void
  try_times(const std::function<void(double time)> &take,
            const typename StructureForce<dim>::Body &body,
            const std::initializer_list<Expressions<dim> *> &expressions)
  {
    for (const double time : body.times)
      take(time);
    for (Expressions<dim> *expression : expressions)
      if (expression)
        if (const Issues issues = expression->not_finite(MPI_COMM_SELF); !issues.empty())
          throw Error(issues);
    take(0.);
  }


  /// The same in a run, at one time. Throws Incurable: a shorter step would jump over the place.
  template <int dim>
  void
  take_at(const std::function<void(double time)> &take,
          const double time,
          const std::initializer_list<Expressions<dim> *> &expressions)
  {
    take(time);
    for (Expressions<dim> *expression : expressions)
      if (expression)
        if (const Issues issues = expression->not_finite(MPI_COMM_SELF); !issues.empty())
          throw Incurable(Error(issues).what());
  }
} // namespace feib

#endif
