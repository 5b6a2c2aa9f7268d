// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/constitutive_law.h>
#include <feib/fibre_directions.h>
#include <feib/plugin.h>

#include "anisotropic_linear_schema.h"

namespace feib
{
  /// W = kappa/2 sum_k |F l_k|^2. The law is linear: P = F A with A = kappa sum_k l_k (x) l_k.
  template <int structure_dim, int dim>
  class AnisotropicLinear : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Law           = ConstitutiveLaw<structure_dim, dim>;
    using Matrix        = typename Law::Matrix;
    using MaterialPoint = typename Law::MaterialPoint;

    explicit AnisotropicLinear(const Parameters &parameters)
      : kappa(parameters.number("stiffness"))
      , fibres(parameters)
    {}

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      fibres.set_points(points);
      A.assign(points.size(), {});
      for (unsigned int q = 0; q < points.size(); ++q)
        for (unsigned int k = 0; k < fibres.n_families(); ++k)
          A[q] += kappa * outer_product(fibres(q, k), fibres(q, k));
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      W.assign(F.size(), 0.);
      for (unsigned int q = 0; q < F.size(); ++q)
        for (unsigned int i = 0; i < dim; ++i)
          W[q] += .5 * (F[q][i] * A[q]) * F[q][i];
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      P.resize(F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        for (unsigned int i = 0; i < dim; ++i)
          P[q][i] = F[q][i] * A[q];
    }

    void
    stress_derivative(const std::vector<Matrix> & /*F*/,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      stress(dF, dP);
    }

    bool
    linear() const override
    {
      return true;
    }

  private:
    double kappa;
    FibreDirections<structure_dim, dim> fibres;
    std::vector<dealii::Tensor<2, structure_dim>> A;
  };
} // namespace feib

FEIB_PLUGIN("anisotropic_linear", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::AnisotropicLinear>("anisotropic_linear",
                                                               anisotropic_linear_schema);
}
