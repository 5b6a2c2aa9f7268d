// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_domain_h
#define feib_domain_h

#include <feib/expression.h>
#include <feib/parameters.h>

#include <deal.II/base/point.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

namespace feib
{
  /// In the order in which they win where faces meet: where a moving lid meets a wall at rest, the
  /// wall does, so that no fluid passes through the corner. What they mean is said by Domain::Face
  /// alone.
  enum class BoundaryCondition
  {
    no_slip,
    free_slip,
    velocity,
    outflow,
    periodic
  };

  /// Within this distance of a face of the box, which goes from @p lower to @p upper across the
  /// face, a point counts as on it: coordinates come from sums, expressions and files.
  inline double
  round_off(const double lower, const double upper)
  {
    return 1e-10 * (upper - lower) +
           16 * std::numeric_limits<double>::epsilon() * std::max(std::abs(lower), std::abs(upper));
  }

  /// The box, its base cells and what holds on its faces, from the block "domain" of a case.
  template <int dim>
  struct Domain
  {
    /// Throws Error (lower >= upper, a face of a periodic direction with a condition, more cells
    /// along a direction than a Lattice has room for, ...).
    explicit Domain(const Parameters &parameters);

    struct Face
    {
      BoundaryCondition condition = BoundaryCondition::no_slip;
      unsigned int normal         = 0;            // the direction across the face
      std::unique_ptr<Expressions<dim>> velocity; // of x and t, for condition velocity
      bool time_dependent = false;

      /// Whether nothing can cross the face: no_slip, free_slip, or a velocity whose component
      /// across the face is the number 0.
      bool tight = true;

      /// Whether the face prescribes a component of the velocity: that of `velocity` where there is
      /// one, else zero.
      bool
      prescribes(const unsigned int component) const
      {
        return condition == BoundaryCondition::no_slip ||
               condition == BoundaryCondition::velocity ||
               (condition == BoundaryCondition::free_slip && component == normal);
      }

      /// Whether fluid crosses the face as it likes: nothing is prescribed, and the traction on the
      /// face is given.
      bool
      open() const
      {
        return condition == BoundaryCondition::outflow;
      }

      /// Whether the other side of the box is beyond the face.
      bool
      periodic() const
      {
        return condition == BoundaryCondition::periodic;
      }
    };

    /// Whether no fluid can cross the boundary freely, so that the pressure is known up to a
    /// constant.
    bool enclosed() const;

    /// Whether a velocity on a face changes with time.
    bool time_dependent() const;

    bool
    periodic(const unsigned int direction) const
    {
      return faces[2 * direction].periodic();
    }

    /// The directions that a point cannot leave its place in, as it lies in a tight face across
    /// them (within round_off()).
    std::array<bool, dim> held(const dealii::Point<dim> &x) const;

    /// The most cells a mesh may have, refined ones included.
    static constexpr double most_cells = 1e8;

    std::string pointer; // of the block in the case
    dealii::Point<dim> lower, upper;
    std::array<unsigned int, dim> cells;
    std::array<Face, 2 * dim> faces; // x_min, x_max, y_min, ...
  };
} // namespace feib

#endif
