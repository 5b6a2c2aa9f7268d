// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/time_integrator/coupled_scheme.h>

#include "lagged_be_schema.h"

namespace feib
{
  /// Geometry at X^n, force at X^{n+1}, see the README.
  template <int dim>
  class LaggedBackwardEuler : public CoupledScheme<dim>
  {
  public:
    explicit LaggedBackwardEuler(const Parameters &)
      : CoupledScheme<dim>({false, true})
    {}
  };
} // namespace feib


FEIB_PLUGIN("lagged_be", "1.0", registry)
{
  registry.add<feib::TimeIntegrator, feib::LaggedBackwardEuler>("lagged_be", lagged_be_schema);
}
