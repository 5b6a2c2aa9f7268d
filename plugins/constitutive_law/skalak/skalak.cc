// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/energy_law.h>
#include <feib/plugin.h>

#include "skalak_schema.h"

namespace feib
{
  /// W = G/4 ((i1^2 + 2 i1 - 2 i2) + C i2^2) with i1 = I1 - 2, i2 = J^2 - 1: the membrane of a red
  /// blood cell, which resists changes of its area.
  template <int m, int dim>
  class Skalak : public EnergyLaw<Skalak<m, dim>, m, dim>
  {
  public:
    explicit Skalak(const Parameters &parameters)
      : G(parameters.number("shear_modulus"))
      , ratio(parameters.number("area_ratio"))
    {}

    template <typename Number>
    Number
    density(const SymmetricMatrix<m, Number> &C, const PointBatch &) const
    {
      const Number i1 = trace(C) - 2., i2 = determinant(C) - 1.;
      return (.25 * G) * (i1 * i1 + 2. * i1 - 2. * i2 + ratio * i2 * i2);
    }

  private:
    const double G, ratio;
  };
} // namespace feib

FEIB_PLUGIN("skalak", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::Skalak>("skalak", skalak_schema, {{2, 3}});
}
