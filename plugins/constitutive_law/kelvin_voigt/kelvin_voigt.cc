// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/modified_law.h>
#include <feib/plugin.h>
#include <feib/registry.h>

#include "kelvin_voigt_schema.h"

namespace feib
{
  /// Adds to a law the viscous stress P_v = eta F dE/dt, dE/dt = (F^T dF/dt + dF/dt^T F)/2: a
  /// dashpot beside the spring. It dissipates eta |dE/dt|^2.
  template <int structure_dim, int dim>
  class KelvinVoigt : public ModifiedLaw<structure_dim, dim>
  {
  public:
    using Law    = ConstitutiveLaw<structure_dim, dim>;
    using Matrix = typename Law::Matrix;

    explicit KelvinVoigt(const Parameters &parameters)
      : ModifiedLaw<structure_dim, dim>(parameters.child("law").create<Law>())
      , eta(parameters.number("viscosity"))
    {}

    bool
    viscous() const override
    {
      return true;
    }

    void
    viscous_stress(const std::vector<Matrix> &F,
                   const std::vector<Matrix> &rate,
                   std::vector<Matrix> &P) const override
    {
      this->law->viscous_stress(F, rate, P);
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          dealii::Tensor<2, structure_dim> product; // F^T dF/dt
          for (unsigned int i = 0; i < dim; ++i)
            product += outer_product(F[q][i], rate[q][i]);
          const dealii::Tensor<2, structure_dim> E_rate = .5 * (product + transpose(product));
          for (unsigned int i = 0; i < dim; ++i)
            P[q][i] += eta * (F[q][i] * E_rate);
        }
    }

  private:
    const double eta;
  };
} // namespace feib

FEIB_PLUGIN("kelvin_voigt", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::KelvinVoigt>("kelvin_voigt", kelvin_voigt_schema);
}
