#include <feib/plugin.h>
#include <feib/time_integrator/coupled_scheme.h>

#include "my_scheme_schema.h"

namespace my_scheme_plugin
{
  /// Backward Euler, implicit in the elastic force, with the geometry found by a fixed number of
  /// corrections: the coupling J is taken at X_0 = X^n, then at X_k = X^n + dt J(X_{k-1}) u_{k-1}.
  ///
  /// CoupledScheme has the step, its energies and the estimate of the stable step. A scheme of
  /// another kind derives from feib::TimeIntegrator and writes step() itself.
  template <int dim>
  class MyScheme : public feib::CoupledScheme<dim>
  {
  public:
    explicit MyScheme(const feib::Parameters &parameters)
      : feib::CoupledScheme<dim>(choices(parameters))
    {}

  private:
    static feib::SchemeChoices
    choices(const feib::Parameters &parameters)
    {
      feib::SchemeChoices choices;
      choices.midpoint       = false;
      choices.implicit_force = true;
      choices.corrections    = parameters.integer("corrections");
      return choices;
    }
  };
} // namespace my_scheme_plugin

FEIB_PLUGIN("my_scheme", "1.0", registry)
{
  registry.add<feib::TimeIntegrator, my_scheme_plugin::MyScheme>("my_scheme", my_scheme_schema);
}
