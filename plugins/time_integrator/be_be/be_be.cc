// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/time_integrator/coupled_scheme.h>

#include "be_be_schema.h"

namespace feib
{
  /// Geometry and force at X^{n+1}, see the README.
  template <int dim>
  class BackwardEulerBackwardEuler : public CoupledScheme<dim>
  {
  public:
    explicit BackwardEulerBackwardEuler(const Parameters &parameters)
      : CoupledScheme<dim>({false, true, parameters.number("geometry_tolerance")})
    {}
  };
} // namespace feib


FEIB_PLUGIN("be_be", "1.0", registry)
{
  registry.add<feib::TimeIntegrator, feib::BackwardEulerBackwardEuler>("be_be", be_be_schema);
}
