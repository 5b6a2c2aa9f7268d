// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/time_integrator/coupled_scheme.h>

#include "fe_be_schema.h"

namespace feib
{
  /// Geometry and force at X^n, see the README.
  template <int dim>
  class ForwardEulerBackwardEuler : public CoupledScheme<dim>
  {
  public:
    explicit ForwardEulerBackwardEuler(const Parameters &)
      : CoupledScheme<dim>({false, false})
    {}
  };
} // namespace feib


FEIB_PLUGIN("fe_be", "1.0", registry)
{
  registry.add<feib::TimeIntegrator, feib::ForwardEulerBackwardEuler>("fe_be", fe_be_schema);
}
