// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_error_norms_h
#define feib_error_norms_h

#include <feib/eulerian_space.h>

#include <deal.II/base/function.h>

namespace feib
{
  struct ErrorNorms
  {
    double velocity_l2, velocity_h1, pressure_l2; // |u - u_h|, |grad (u - u_h)|, |p - p_h|
  };

  /// The errors of the state of the space beside exact functions at a time. In an enclosed flow the
  /// pressures are compared after their means are removed. @p pressure may be null. Collective.
  template <int dim>
  ErrorNorms error_norms(const EulerianSpace<dim> &space,
                         double time,
                         dealii::Function<dim> &velocity,
                         dealii::Function<dim> *pressure);

  /// Where expressions are not finite inside of cells at a time. Collective.
  template <int dim>
  Issues issues_inside(const EulerianSpace<dim> &space, Expressions<dim> &expressions, double time);
} // namespace feib

#endif
