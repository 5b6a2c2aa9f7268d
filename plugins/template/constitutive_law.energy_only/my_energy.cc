#include <feib/energy_law.h>
#include <feib/plugin.h>

#include "my_energy_schema.h"

namespace my_energy_plugin
{
  /// W = mu/2 I1 + c/4 I1^2 with I1 = tr C: a material that stiffens as it is stretched. C = F^T F
  /// has m rows, m being the dimension of the structure. Stress and tangent follow from W.
  template <int m, int dim>
  class MyEnergy : public feib::EnergyLaw<MyEnergy<m, dim>, m, dim>
  {
  public:
    explicit MyEnergy(const feib::Parameters &parameters)
      : mu(parameters.number("shear_modulus"))
      , c(parameters.number("stiffening"))
    {}

    template <typename Number>
    Number
    density(const feib::SymmetricMatrix<m, Number> &C, const feib::PointBatch &) const
    {
      const Number I1 = trace(C);
      return .5 * mu * I1 + .25 * c * I1 * I1;
    }

  private:
    const double mu, c;
  };
} // namespace my_energy_plugin

FEIB_PLUGIN("my_energy", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, my_energy_plugin::MyEnergy>("my_energy", my_energy_schema);
}
