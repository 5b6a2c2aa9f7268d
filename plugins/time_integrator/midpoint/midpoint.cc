// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/time_integrator/coupled_scheme.h>

#include "midpoint_schema.h"

namespace feib
{
  /// Geometry and force at a predicted half step, see the README.
  template <int dim>
  class Midpoint : public CoupledScheme<dim>
  {
  public:
    explicit Midpoint(const Parameters &)
      : CoupledScheme<dim>({true, false})
    {}
  };
} // namespace feib


FEIB_PLUGIN("midpoint", "1.0", registry)
{
  registry.add<feib::TimeIntegrator, feib::Midpoint>("midpoint", midpoint_schema);
}
