// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/time_integrator/coupled_scheme.h>

#include "lagged_midpoint_schema.h"

namespace feib
{
  /// Geometry at a predicted half step, force at the half step, see the README.
  template <int dim>
  class LaggedMidpoint : public CoupledScheme<dim>
  {
  public:
    explicit LaggedMidpoint(const Parameters &parameters)
      : CoupledScheme<dim>(
          {true, true, 0., static_cast<unsigned int>(parameters.integer("corrections"))})
    {}
  };
} // namespace feib


FEIB_PLUGIN("lagged_midpoint", "1.0", registry)
{
  registry.add<feib::TimeIntegrator, feib::LaggedMidpoint>("lagged_midpoint",
                                                           lagged_midpoint_schema);
}
