// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/energy_law.h>
#include <feib/plugin.h>

#include "yeoh_schema.h"

namespace feib
{
  /// W = c1 (I1 - m) + c2 (I1 - m)^2 + c3 (I1 - m)^3 with I1 = |F|^2 and m the dimension of the
  /// structure.
  template <int m, int dim>
  class Yeoh : public EnergyLaw<Yeoh<m, dim>, m, dim>
  {
  public:
    explicit Yeoh(const Parameters &parameters)
      : c1(parameters.number("c1"))
      , c2(parameters.number("c2"))
      , c3(parameters.number("c3"))
    {}

    template <typename Number>
    Number
    density(const SymmetricMatrix<m, Number> &C, const PointBatch &) const
    {
      const Number x = trace(C) - m;
      return x * (c1 + x * (c2 + x * c3));
    }

  private:
    const double c1, c2, c3;
  };
} // namespace feib

FEIB_PLUGIN("yeoh", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::Yeoh>("yeoh", yeoh_schema);
}
