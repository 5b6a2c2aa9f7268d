// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/constitutive_law.h>
#include <feib/plugin.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace
{
  using feib::Parameters;

  /// W = |F|^2/2 + |C|^2/8 with C = F^T F, P = F + F C/2: right, unless the parameter names a
  /// fault.
  template <int structure_dim, int dim>
  class WrongLaw : public feib::ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Base          = feib::ConstitutiveLaw<structure_dim, dim>;
    using Matrix        = typename Base::Matrix;
    using MaterialPoint = typename Base::MaterialPoint;
    using Small         = dealii::Tensor<2, structure_dim>;

    explicit WrongLaw(const Parameters &parameters)
      : fault(parameters.string("fault"))
      , modulus(fault == "declared, but loses convexity" ? -.5 : 1.)
    {}

    void
    set_points(const std::vector<MaterialPoint> &material_points) override
    {
      points = material_points;
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      W.resize(F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const double square = trace(C(F[q], F[q]));
          W[q]                = modulus * square / 2 +
                 (fault == "energy lacks a term" ? 0. : C(F[q], F[q]).norm_square() / 8);
          if (fault == "both negative")
            W[q] *= -1;
          else if (fault == "no energy")
            W[q] = 0;
          else if (fault == "not a number at rest")
            W[q] += 0 / (std::abs(square - structure_dim) < 1e-9 ? 0. : 1.);
          else if (fault == "not objective")
            W[q] = square / 2 - F[q][0][0];
          else if (fault == "state, energy grows" && !this->moment().state.empty())
            W[q] += this->moment().state[0][q];
        }
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      P.resize(F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          P[q] = F[q];
          P[q] *= modulus;
          for (unsigned int i = 0; i < dim; ++i)
            P[q][i] += F[q][i] * C(F[q], F[q]) / 2;
          if (fault == "sign" || fault == "both negative")
            P[q] *= -1.;
          else if (fault == "twice")
            P[q] *= 2.;
          else if (fault == "somewhere" && points[q].place[0] > .5)
            P[q] *= 1.1;
          else if (fault == "transposed")
            for (unsigned int i = 0; i < structure_dim; ++i)
              for (unsigned int k = 0; k < i; ++k)
                std::swap(P[q][i][k], P[q][k][i]);
          else if (fault == "other order")
            std::swap(P[q][0], P[q][1]);
          else if (fault == "constant")
            {
              P[q] = Matrix();
              for (unsigned int i = 0; i < structure_dim; ++i)
                P[q][i][i] = 1;
            }
          else if (fault == "infinite")
            P[q] *= std::numeric_limits<double>::infinity();
          else if (fault == "not objective")
            {
              P[q] = F[q];
              P[q][0][0] -= 1;
            }
        }
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      dP = dF;
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          if (fault == "not objective")
            continue;
          dP[q] *= modulus;
          if (fault != "derivative lacks a term")
            for (unsigned int i = 0; i < dim; ++i)
              dP[q][i] +=
                (dF[q][i] * C(F[q], F[q]) + F[q][i] * (C(dF[q], F[q]) + C(F[q], dF[q]))) / 2;
          if (fault == "both negative")
            dP[q] *= -1.;
          else if (fault == "half the derivative")
            dP[q] *= .5;
          else if (fault == "no derivative")
            dP[q] = Matrix();
          else if (fault == "derivative not a number")
            dP[q] *= std::numeric_limits<double>::quiet_NaN();
        }
    }

    bool
    viscous() const override
    {
      return fault.rfind("viscous", 0) == 0;
    }

    void
    viscous_stress(const std::vector<Matrix> &F,
                   const std::vector<Matrix> &rate,
                   std::vector<Matrix> &P) const override
    {
      P.assign(F.size(), Matrix());
      for (unsigned int q = 0; q < F.size() && viscous(); ++q)
        {
          for (unsigned int i = 0; i < dim; ++i)
            P[q][i] = F[q][i] * (C(F[q], rate[q]) + C(rate[q], F[q]));
          if (fault == "viscous, sign")
            P[q] *= -1.;
          else if (fault == "viscous, square")
            P[q] *= rate[q][0].norm();
          else if (fault == "viscous, no potential")
            P[q][0] += .5 * rate[q][1];
          else if (fault == "viscous, rotation")
            P[q] = rate[q];
        }
    }

    std::vector<typename Base::StateVariable>
    state_variables() const override
    {
      if (fault.rfind("state", 0) != 0)
        return {};
      return {{"reached", 0.}};
    }

    void
    update_state(const std::vector<Matrix> &F,
                 std::vector<std::vector<double>> &state) const override
    {
      if (fault == "state, another variable")
        state.push_back(state[0]);
      else if (fault == "state, a value too many")
        state[0].push_back(0);
      else if (fault == "state, not a number")
        state[0].assign(F.size(), std::numeric_limits<double>::quiet_NaN());
      else if (fault.rfind("state", 0) == 0)
        for (unsigned int q = 0; q < F.size(); ++q)
          state[0][q] = std::max(state[0][q], trace(C(F[q], F[q])));
    }

    bool
    linear() const override
    {
      return fault == "not linear";
    }

  private:
    static Small
    C(const Matrix &A, const Matrix &B)
    {
      Small result;
      for (unsigned int i = 0; i < dim; ++i)
        result += outer_product(A[i], B[i]);
      return result;
    }

    const std::string fault;
    const double modulus; // less than 0: W = |C - I|^2/8, free of stress, and not convex
    std::vector<MaterialPoint> points;
  };

  std::string
  schema(const std::string &fault,
         const std::string &declared =
           R"("stress_free": "never", "resists_collapse": "never", "rank_one_convex": "always")")
  {
    return R"({
    "type": "object", "additionalProperties": false, "description": "A law with a fault.",
    "required": ["fault"],
    "properties": { "fault": { "type": "string", "description": "What is wrong." } },
    "declares": { )" +
           declared + R"( },
    "examples": [ { "fault": ")" +
           fault + R"(" } ] })";
  }
} // namespace

FEIB_PLUGIN("wrong_law", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, WrongLaw>("wrong_law", schema("none"));
#ifdef FEIB_TEST_FAULTY_EXAMPLES
  const auto add = [&](std::string fault, const std::string &text) {
    std::replace(fault.begin(), fault.end(), ' ', '_');
    std::replace(fault.begin(), fault.end(), ',', '_');
    registry.add<feib::ConstitutiveLaw, WrongLaw>(fault, text);
  };
  for (const auto &[fault, declared] :
       {std::pair<const char *, const char *>{"declared, stress free",
                                              R"("stress_free": "always")"},
        {"declared, resists collapse", R"("resists_collapse": "always")"},
        {"declared, not convex", R"("rank_one_convex": "never")"},
        {"declared, both found", R"("rank_one_convex": "sometimes")"},
        {"declared, unknown", R"("polyconvex": "always")"}})
    add(fault, schema(fault, declared));
  for (std::string fault : {"sign",
                            "twice",
                            "somewhere",
                            "both negative",
                            "transposed",
                            "other order",
                            "constant",
                            "infinite",
                            "energy lacks a term",
                            "no energy",
                            "not a number at rest",
                            "derivative lacks a term",
                            "no derivative",
                            "half the derivative",
                            "derivative not a number",
                            "not linear",
                            "state, another variable",
                            "state, a value too many",
                            "state, not a number",
                            "state, energy grows",
                            "viscous, sign",
                            "viscous, square",
                            "viscous, no potential",
                            "viscous, rotation",
                            "not objective"})
    add(fault, schema(fault));
  add("declared, but loses convexity", schema("declared, but loses convexity"));
  add(
    "refused",
    R"({ "type": "object", "additionalProperties": false, "description": "A law.", "required": ["law"],
    "properties": { "law": { "slot": "constitutive_law", "description": "The law of what is inside." } },
    "examples": [ { "law": { "no_such_law": {} } } ] })");
#endif
}
