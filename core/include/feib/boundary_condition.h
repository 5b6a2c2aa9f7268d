// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_boundary_condition_h
#define feib_boundary_condition_h

#include <feib/expression.h>
#include <feib/parameters.h>

#include <memory>
#include <optional>
#include <string>

namespace feib
{
  /// What holds on a face of the box, or on a part of it. What a condition means for constraints,
  /// fluxes, operators, loads and results is said here alone; others ask prescribes(), open() and
  /// so on, and know no kinds of conditions.
  template <int dim>
  struct BoundaryCondition
  {
    /// In the order in which they win where faces meet: where a moving lid meets a wall at rest,
    /// the wall does, so that no fluid passes through the corner.
    enum class Kind
    {
      no_slip,
      free_slip,
      velocity,
      open,
      periodic
    };

    /// What a pressure at an outlet hangs on: P = resistance Q + p, with Q the flux out of the box
    /// and capacitance dp/dt = Q - (p - distal_pressure)/distal_resistance.
    struct Windkessel
    {
      double resistance, distal_resistance; // [force/area / (volume/time)]
      double capacitance;                   // [volume / (force/area)]
      double distal_pressure, initial_pressure;
    };

    /// No slip.
    BoundaryCondition() = default;

    /// From one condition of a case, on face @p face (x_min, x_max, y_min, ...). Throws Error.
    BoundaryCondition(const Parameters &parameters, unsigned int face);

    std::string name;    // in results: that of the face, if nothing else was said
    std::string pointer; // of the condition in the case; empty: not from there
    unsigned int face = 0;
    Kind kind         = Kind::no_slip;

    /// Where it holds, above zero, on a face with several: the first that does. Null: on what the
    /// others leave.
    std::unique_ptr<Expressions<dim>> where;

    /// Of x and t; null: zero.
    std::unique_ptr<Expressions<dim>> velocity; // of kind velocity [length/time]
    std::unique_ptr<Expressions<dim>> traction; // of kind open: sigma n [force/area],
    std::unique_ptr<Expressions<dim>> pressure; // or sigma n = - pressure n
    std::unique_ptr<Expressions<dim>> flux;     // or that pressure is what makes this the flux out
    std::optional<Windkessel> windkessel;       // or as that says

    bool time_dependent = false; // the velocity

    /// Whether nothing can cross: no_slip, free_slip, or a velocity whose component across the face
    /// is the number 0.
    bool tight = true;

    /// Of kind open: whether fluid goes straight through, its velocity along the face being zero.
    bool straight = false;

    /// Of kind open: whether the traction is that of the fluid where it flows in, too; else it then
    /// is that of fluid at rest outside, which the dynamic pressure has been taken from.
    bool static_inflow = false;

    /// The direction across the face, and whether the outer normal points along it.
    unsigned int
    normal() const
    {
      return face / 2;
    }
    double
    outward() const
    {
      return face % 2 == 0 ? -1. : 1.;
    }

    /// Whether a component of the velocity is prescribed: that of `velocity` where there is one,
    /// else zero.
    bool
    prescribes(const unsigned int component) const
    {
      return kind == Kind::no_slip || kind == Kind::velocity ||
             (kind == Kind::free_slip && component == normal()) ||
             (kind == Kind::open && straight && component != normal());
    }

    /// Whether fluid crosses as it likes, under the traction given.
    bool
    open() const
    {
      return kind == Kind::open;
    }

    /// Whether the other side of the box is beyond the face.
    bool
    periodic() const
    {
      return kind == Kind::periodic;
    }

    /// Whether the pressure outside is one number that hangs on the flux.
    bool
    regulated() const
    {
      return flux != nullptr || windkessel.has_value();
    }
  };
} // namespace feib

#endif
