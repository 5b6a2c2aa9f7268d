// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/energy_law.h>
#include <feib/message.h>
#include <feib/plugin.h>

#include "exponential_fibre_schema.h"

namespace feib
{
  /// W = c/2 (I1 - m) + k1/(2 k2) sum_a (exp(k2 <E_a>^2) - 1), E_a = kappa (I1 - m) + (1 - m
  /// kappa)(I4_a - 1) with I4_a = |F a|^2, <x> = max(x, 0) and m the dimension of the structure.
  template <int m, int dim>
  class ExponentialFibre : public EnergyLaw<ExponentialFibre<m, dim>, m, dim>
  {
  public:
    explicit ExponentialFibre(const Parameters &parameters)
      : c(parameters.number("c"))
      , k1(parameters.number("k1"))
      , k2(parameters.number("k2"))
      , kappa(parameters.number("dispersion"))
      , fibres(parameters)
    {
      if (m * kappa > 1)
        parameters.fail("dispersion",
                        "must be at most 1/" + std::to_string(m) +
                          ", no direction at all, for a structure of dimension " +
                          std::to_string(m) + "; found " + readable(kappa));
    }

    void
    set_points(
      const std::vector<typename EnergyLaw<ExponentialFibre<m, dim>, m, dim>::MaterialPoint>
        &points) override
    {
      fibres.set_points(points);
    }

    template <typename Number>
    Number
    density(const SymmetricMatrix<m, Number> &C, const PointBatch &points) const
    {
      const Number strain = trace(C) - m;
      Number W            = (.5 * c) * strain;
      for (unsigned int family = 0; family < fibres.n_families(); ++family)
        {
          const Number E = positive_part(
            kappa * strain + (1 - m * kappa) * (stretch_square(C, points(fibres, family)) - 1.));
          W += (.5 * k1 / k2) * (exp(k2 * E * E) - 1.);
        }
      return W;
    }

    double
    tested_strain() const override
    {
      return .4;
    }

  private:
    const double c, k1, k2, kappa;
    FibreDirections<m, dim> fibres;
  };
} // namespace feib

FEIB_PLUGIN("exponential_fibre", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::ExponentialFibre>("exponential_fibre",
                                                              exponential_fibre_schema);
}
