// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/boundary_condition.h>

#include <feib/error.h>

namespace feib
{
  template <int dim>
  BoundaryCondition<dim>::BoundaryCondition(const Parameters &parameters, const unsigned int face)
    : face(face)
  {
    const auto [type, block] = parameters.choice();
    pointer                  = block.pointer();
    if (type == "no_slip")
      return;
    if (type == "free_slip")
      {
        kind = Kind::free_slip;
        return;
      }
    if (type == "velocity")
      {
        kind           = Kind::velocity;
        velocity       = parse_expressions<dim>(block, "value", dim, Variables::space_time);
        time_dependent = depends_on_time(block, "value");
        const std::string across = block.expressions("value")[normal()];
        tight                    = across == "0" || across == "0.0" || across == "-0.0";
        return;
      }

    kind  = Kind::open;
    tight = false;
    if (type == "outflow")
      return;
    static_inflow = block.string("inflow") == "static";
    if (type == "traction")
      {
        traction = parse_expressions<dim>(block, "value", dim, Variables::space_time);
        return;
      }
    straight = block.string("direction") == "normal";
    if (type == "pressure")
      pressure = parse_expressions<dim>(block, "value", 1, Variables::space_time);
    else if (type == "flux")
      flux = parse_expressions<dim>(block, "value", 1, Variables::time);
    else
      {
        windkessel.emplace();
        windkessel->resistance        = block.number("resistance");
        windkessel->distal_resistance = block.number("distal_resistance");
        windkessel->capacitance       = block.number("capacitance");
        windkessel->distal_pressure   = block.number("distal_pressure");
        windkessel->initial_pressure =
          block.number(block.has("initial_pressure") ? "initial_pressure" : "distal_pressure");
      }
  }


  template struct BoundaryCondition<2>;
  template struct BoundaryCondition<3>;
} // namespace feib
