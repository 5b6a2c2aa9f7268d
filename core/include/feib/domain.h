// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_domain_h
#define feib_domain_h

#include <feib/parameters.h>

#include <deal.II/base/function.h>
#include <deal.II/base/point.h>

#include <array>
#include <memory>

namespace feib
{
  enum class BoundaryCondition
  {
    no_slip,
    velocity,
    free_slip,
    outflow,
    periodic
  };

  /// The box, its base cells and what holds on its faces, from the block "domain" of a case.
  template <int dim>
  struct Domain
  {
    /// Throws Error (lower >= upper, a face of a periodic direction with a condition, ...).
    explicit Domain(const Parameters &parameters);

    struct Face
    {
      BoundaryCondition condition = BoundaryCondition::no_slip;
      std::unique_ptr<dealii::Function<dim>> velocity; // of x and t, for condition velocity
      bool time_dependent = false;
    };

    /// Whether no fluid can cross the boundary freely, so that the pressure is known up to a
    /// constant.
    bool enclosed() const;

    bool
    periodic(const unsigned int direction) const
    {
      return faces[2 * direction].condition == BoundaryCondition::periodic;
    }

    dealii::Point<dim> lower, upper;
    std::array<unsigned int, dim> cells;
    std::array<Face, 2 * dim> faces; // x_min, x_max, y_min, ...
  };
} // namespace feib

#endif
