// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/modified_law.h>
#include <feib/plugin.h>
#include <feib/registry.h>

#include "mullins_damage_schema.h"

#include <algorithm>
#include <cmath>

namespace feib
{
  /// Softens a law after loading: P = phi'(w) P_0, w = W_0(F) - W_0(I), with the largest w so far
  /// as the state M. On the first loading, w > M, phi' = 1; after it
  ///   phi'(w) = 1 - 1/r erf((M - w)/c),   c = m + beta M
  /// (Ogden, Roxburgh, Proc. R. Soc. Lond. A 455 (1999) 2861, in the form of Mooney, 2006).
  ///
  /// With G(x) = x erf(x) + exp(-x^2)/sqrt(pi), the integral of erf, and phi(0) = 0,
  ///   phi(w) = w - c/r (G(M/c) - G((M - w)/c))   for w <= M,
  ///   phi(w) = phi(M) + w - M                    beyond: what is stored and dissipated on the way.
  /// The derivative of phi jumps nowhere, phi'' does at w = M.
  template <int structure_dim, int dim>
  class MullinsDamage : public ModifiedLaw<structure_dim, dim>
  {
  public:
    using Base          = ModifiedLaw<structure_dim, dim>;
    using Law           = typename Base::Law;
    using Matrix        = typename Law::Matrix;
    using MaterialPoint = typename Law::MaterialPoint;
    using State         = std::vector<std::vector<double>>;

    explicit MullinsDamage(const Parameters &parameters)
      : Base(parameters.child("law").create<Law>())
      , r(parameters.number("r"))
      , m(parameters.number("m"))
      , beta(parameters.number("beta"))
    {}

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      this->law->set_points(points);
      Matrix identity;
      for (unsigned int k = 0; k < structure_dim; ++k)
        identity[k][k] = 1;
      this->law->energy(std::vector<Matrix>(points.size(), identity), rest);
    }

    std::vector<typename Law::StateVariable>
    state_variables() const override
    {
      auto result = this->law->state_variables();
      result.push_back({"largest_energy", 0.});
      return result;
    }

    bool
    linear() const override
    {
      return false;
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      this->law->energy(F, W);
      for (unsigned int q = 0; q < F.size(); ++q)
        W[q] = phi(W[q] - rest[q], largest()[q]);
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      std::vector<double> W;
      this->law->energy(F, W);
      this->law->stress(F, P);
      for (unsigned int q = 0; q < F.size(); ++q)
        P[q] *= slope(W[q] - rest[q], largest()[q]);
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      std::vector<double> W;
      std::vector<Matrix> P;
      this->law->energy(F, W);
      this->law->stress(F, P);
      this->law->stress_derivative(F, dF, dP);
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          double dw = 0;
          for (unsigned int i = 0; i < dim; ++i)
            dw += P[q][i] * dF[q][i];
          const double w = W[q] - rest[q], M = largest()[q];
          dP[q] *= slope(w, M);
          P[q] *= curvature(w, M) * dw;
          dP[q] += P[q];
        }
    }

    void
    update_state(const std::vector<Matrix> &F, State &state) const override
    {
      this->law->update_state(F, state);
      std::vector<double> W;
      this->law->energy(F, W);
      for (unsigned int q = 0; q < F.size(); ++q)
        state.back()[q] = std::max(state.back()[q], W[q] - rest[q]);
    }

  private:
    const std::vector<double> &
    largest() const
    {
      return this->moment().state.back();
    }

    double
    scale(const double M) const
    {
      return m + beta * M;
    }

    static double
    integral_of_erf(const double x)
    {
      return x * std::erf(x) + std::exp(-x * x) / std::sqrt(M_PI);
    }

    double
    phi(const double w, const double M) const
    {
      const double c = scale(M), within = std::min(w, M);
      return w - c / r * (integral_of_erf(M / c) - integral_of_erf((M - within) / c));
    }

    double
    slope(const double w, const double M) const
    {
      return w < M ? 1 - std::erf((M - w) / scale(M)) / r : 1;
    }

    double
    curvature(const double w, const double M) const
    {
      const double c = scale(M), x = (M - w) / c;
      return w < M ? 2 / (r * c * std::sqrt(M_PI)) * std::exp(-x * x) : 0;
    }

    const double r, m, beta;
    std::vector<double> rest; // W_0(I) at each point
  };
} // namespace feib

FEIB_PLUGIN("mullins_damage", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::MullinsDamage>("mullins_damage", mullins_damage_schema);
}
