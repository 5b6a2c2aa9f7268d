// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/energy_law.h>
#include <feib/plugin.h>

#include "fung_schema.h"

namespace feib
{
  /// W = c/2 (exp Q - 1), Q = b_f E_ff^2 + b_t (E_ss^2 + E_nn^2 + 2 E_sn^2) + 2 b_fs (E_fs^2 +
  /// E_fn^2) with E = (F^T F - I)/2, f along the fibres and s, n across them.
  template <int m, int dim>
  class Fung : public EnergyLaw<Fung<m, dim>, m, dim>
  {
  public:
    explicit Fung(const Parameters &parameters)
      : c(parameters.number("c"))
      , b_f(parameters.number("b_f"))
      , b_t(parameters.number("b_t"))
      , b_fs(parameters.number("b_fs"))
      , fibres(parameters)
    {
      if (fibres.n_families() > 1)
        parameters.fail("fibres",
                        "has " + std::to_string(fibres.n_families()) +
                          " families; this law has one direction of fibres");
    }

    void
    set_points(
      const std::vector<typename EnergyLaw<Fung<m, dim>, m, dim>::MaterialPoint> &points) override
    {
      fibres.set_points(points);
    }

    template <typename Number>
    Number
    density(const SymmetricMatrix<m, Number> &C, const PointBatch &points) const
    {
      const auto a         = points(fibres, 0);
      const Number stretch = stretch_square(C, a), along = .5 * (stretch - 1.); // E_ff
      const Number image = .25 * (image_square(C, a) - 2. * stretch + 1.);      // |E f|^2
      const Number I1 = trace(C), square = .25 * (I1 * I1 - 2. * second_invariant(C) - 2. * I1 + m);
      const Number Q = b_f * along * along + b_t * (square - 2. * image + along * along) +
                       (2 * b_fs) * (image - along * along);
      return (.5 * c) * (exp(Q) - 1.);
    }

    double
    tested_strain() const override
    {
      return .4;
    }

  private:
    const double c, b_f, b_t, b_fs;
    FibreDirections<m, dim> fibres;
  };
} // namespace feib

FEIB_PLUGIN("fung", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::Fung>("fung", fung_schema);
}
