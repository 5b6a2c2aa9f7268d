// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/energy_law.h>
#include <feib/plugin.h>

#include "gent_schema.h"

namespace feib
{
  /// W = -mu J_m/2 ln(1 - (I1 - m)/J_m) with I1 = |F|^2 and m the dimension of the structure:
  /// chains of finite length.
  template <int m, int dim>
  class Gent : public EnergyLaw<Gent<m, dim>, m, dim>
  {
  public:
    explicit Gent(const Parameters &parameters)
      : mu(parameters.number("shear_modulus"))
      , limit(parameters.number("limit"))
    {}

    template <typename Number>
    Number
    density(const SymmetricMatrix<m, Number> &C, const PointBatch &) const
    {
      return (-.5 * mu * limit) * log(1. - (trace(C) - m) / limit);
    }

    double
    tested_strain() const override
    {
      // Well within the limit, of entries of F by that much from I: I1 - m <= m (2 e + dim e^2).
      double strain = .9;
      while (m * (2 * strain + dim * strain * strain) > .7 * limit)
        strain *= .9;
      return strain;
    }

  private:
    const double mu, limit;
  };
} // namespace feib

FEIB_PLUGIN("gent", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::Gent>("gent", gent_schema);
}
