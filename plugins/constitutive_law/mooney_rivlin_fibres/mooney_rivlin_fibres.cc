// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/constitutive_law.h>
#include <feib/fibre_directions.h>
#include <feib/plugin.h>

#include "mooney_rivlin_fibres_schema.h"

#include <memory>

namespace feib
{
  /// W = c1 (I1 - m) + c2 (I2 - m(m-1)/2) + k_f/2 sum_k (I4_k - 1)^2.
  template <int structure_dim, int dim>
  class MooneyRivlinFibres : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Law           = ConstitutiveLaw<structure_dim, dim>;
    using Matrix        = typename Law::Matrix;
    using MaterialPoint = typename Law::MaterialPoint;

    explicit MooneyRivlinFibres(const Parameters &parameters)
      : c1(parameters.number("c1"))
      , c2(parameters.number("c2"))
      , k_f(parameters.number("fibre_modulus"))
      , tension_only(parameters.boolean("tension_only"))
    {
      if (k_f > 0)
        fibres = std::make_unique<FibreDirections<structure_dim, dim>>(parameters);
    }

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      if (fibres)
        fibres->set_points(points);
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      constexpr int m = structure_dim;
      W.resize(F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const Small C   = right_cauchy_green(F[q]);
          const double I1 = trace(C);
          const double I2 = (I1 * I1 - C.norm_square()) / 2;
          W[q]            = c1 * (I1 - m) + c2 * (I2 - m * (m - 1) / 2);
          for_each_active_fibre(F[q], q, [&](const Row &, const Vector &, const double excess) {
            W[q] += k_f / 2 * excess * excess;
          });
        }
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      P.resize(F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const Small C = right_cauchy_green(F[q]);
          const Small A = 2 * (c1 + c2 * trace(C)) * identity - 2 * c2 * C;
          for (unsigned int i = 0; i < dim; ++i)
            P[q][i] = F[q][i] * A;
          for_each_active_fibre(F[q], q, [&](const Row &l, const Vector &Fl, const double excess) {
            for (unsigned int i = 0; i < dim; ++i)
              P[q][i] += 2 * k_f * excess * Fl[i] * l;
          });
        }
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      dP.resize(F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const Small C = right_cauchy_green(F[q]);
          Small dC;
          for (unsigned int i = 0; i < dim; ++i)
            dC += outer_product(F[q][i], dF[q][i]) + outer_product(dF[q][i], F[q][i]);
          const Small A  = 2 * (c1 + c2 * trace(C)) * identity - 2 * c2 * C;
          const Small dA = 2 * c2 * (trace(dC) * identity - dC);
          for (unsigned int i = 0; i < dim; ++i)
            dP[q][i] = dF[q][i] * A + F[q][i] * dA;
          for_each_active_fibre(F[q], q, [&](const Row &l, const Vector &Fl, const double excess) {
            Vector dFl;
            for (unsigned int i = 0; i < dim; ++i)
              dFl[i] = dF[q][i] * l;
            for (unsigned int i = 0; i < dim; ++i)
              dP[q][i] += 2 * k_f * (2 * (Fl * dFl) * Fl[i] + excess * dFl[i]) * l;
          });
        }
    }

  private:
    using Small  = dealii::Tensor<2, structure_dim>;
    using Row    = dealii::Tensor<1, structure_dim>;
    using Vector = dealii::Tensor<1, dim>;

    static Small
    right_cauchy_green(const Matrix &F)
    {
      Small C;
      for (unsigned int i = 0; i < dim; ++i)
        C += outer_product(F[i], F[i]);
      return C;
    }

    /// Calls @p action with l, F l and I4 - 1 for the fibres that carry load at point @p q.
    template <typename Action>
    void
    for_each_active_fibre(const Matrix &F, const unsigned int q, const Action &action) const
    {
      for (unsigned int k = 0; fibres && k < fibres->n_families(); ++k)
        {
          const Row &l = (*fibres)(q, k);
          Vector Fl;
          for (unsigned int i = 0; i < dim; ++i)
            Fl[i] = F[i] * l;
          const double excess = Fl.norm_square() - 1;
          if (excess > 0 || !tension_only)
            action(l, Fl, excess);
        }
    }

    const Small identity = dealii::unit_symmetric_tensor<structure_dim>();
    double c1, c2, k_f;
    bool tension_only;
    std::unique_ptr<FibreDirections<structure_dim, dim>> fibres;
  };
} // namespace feib

FEIB_PLUGIN("mooney_rivlin_fibres", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::MooneyRivlinFibres>("mooney_rivlin_fibres",
                                                                mooney_rivlin_fibres_schema);
}
