// SPDX-License-Identifier: LGPL-2.1-or-later
// The laws that are written by hand, given by their energies alone.
#ifndef feib_tests_support_energy_twins_h
#define feib_tests_support_energy_twins_h

#include <feib/energy_law.h>

namespace feib::testing
{
  /// neo_hookean: mu/2 (I1 - s ln det C), or of a sheet of an incompressible material.
  template <int m, int dim>
  class NeoHookeanTwin : public EnergyLaw<NeoHookeanTwin<m, dim>, m, dim>
  {
  public:
    NeoHookeanTwin(std::vector<double> mu, const bool stress_free, const bool incompressible)
      : mu(std::move(mu))
      , stress_free(stress_free)
      , incompressible(incompressible)
    {}

    template <typename Number>
    Number
    density(const SymmetricMatrix<m, Number> &C, const PointBatch &points) const
    {
      Number W = trace(C);
      if (stress_free)
        W -= log(determinant(C));
      if (incompressible)
        W += reciprocal(determinant(C)) - (m + 1);
      return (.5 * points(mu)) * W;
    }

  private:
    const std::vector<double> mu; // one value per point
    const bool stress_free, incompressible;
  };


  /// mooney_rivlin_fibres
  template <int m, int dim>
  class MooneyRivlinTwin : public EnergyLaw<MooneyRivlinTwin<m, dim>, m, dim>
  {
  public:
    using MaterialPoint = typename ConstitutiveLaw<m, dim>::MaterialPoint;

    explicit MooneyRivlinTwin(const Parameters &parameters)
      : c1(parameters.number("c1"))
      , c2(parameters.number("c2"))
      , k_f(parameters.number("fibre_modulus"))
      , tension_only(parameters.boolean("tension_only"))
      , fibres(parameters)
    {}

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      fibres.set_points(points);
    }

    template <typename Number>
    Number
    density(const SymmetricMatrix<m, Number> &C, const PointBatch &points) const
    {
      Number W = c1 * (trace(C) - m) + c2 * (second_invariant(C) - m * (m - 1) / 2);
      for (unsigned int family = 0; family < fibres.n_families(); ++family)
        {
          Number excess = stretch_square(C, points(fibres, family)) - 1.;
          if (tension_only)
            excess = positive_part(excess);
          W += (.5 * k_f) * excess * excess;
        }
      return W;
    }

  private:
    const double c1, c2, k_f;
    const bool tension_only;
    FibreDirections<m, dim> fibres;
  };
} // namespace feib::testing

#endif
