// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/energy_law.h>
#include <feib/plugin.h>

#include "saint_venant_kirchhoff_schema.h"

namespace feib
{
  /// W = lambda/2 (tr E)^2 + mu tr E^2 with E = (F^T F - I)/2: linear elasticity in the strain of
  /// Green.
  template <int m, int dim>
  class SaintVenantKirchhoff : public EnergyLaw<SaintVenantKirchhoff<m, dim>, m, dim>
  {
  public:
    explicit SaintVenantKirchhoff(const Parameters &parameters)
      : mu(parameters.number("mu"))
      , lambda(parameters.number("lambda"))
    {}

    template <typename Number>
    Number
    density(const SymmetricMatrix<m, Number> &C, const PointBatch &) const
    {
      const Number I1 = trace(C), I2 = second_invariant(C);
      const Number of_trace = .5 * (I1 - m); // tr E
      return (.5 * lambda) * of_trace * of_trace + (.25 * mu) * (I1 * I1 - 2. * I2 - 2. * I1 + m);
    }

  private:
    const double mu, lambda;
  };
} // namespace feib

FEIB_PLUGIN("saint_venant_kirchhoff", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::SaintVenantKirchhoff>("saint_venant_kirchhoff",
                                                                  saint_venant_kirchhoff_schema);
}
