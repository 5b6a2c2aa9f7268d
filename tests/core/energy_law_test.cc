// SPDX-License-Identifier: LGPL-2.1-or-later
// Laws given by their energies alone beside the same laws written by hand.
#include "support/energy_twins.h"

#include <feib/testing/plugins.h>

#include <deal.II/base/derivative_form.h>

#include <gtest/gtest.h>

#include <random>

using namespace feib;
using feib::testing::registry;

namespace
{
  /// Points with random frames, deformations of them and changes of these; not a whole number of
  /// batches.
  template <int m, int dim>
  struct Sample
  {
    using Law    = ConstitutiveLaw<m, dim>;
    using Matrix = typename Law::Matrix;

    Sample()
      : points(2 * Lanes::n + 3)
      , F(points.size())
      , dF(points.size())
    {
      std::mt19937 generator;
      std::uniform_real_distribution<double> random(-.5, .5);
      for (unsigned int q = 0; q < points.size(); ++q)
        {
          for (unsigned int k = 0; k < m; ++k)
            points[q].frame[k][k] = 1;
          for (unsigned int i = 0; i < dim; ++i)
            points[q].place[i] = random(generator);
          do
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int k = 0; k < m; ++k)
                {
                  F[q][i][k]  = (i == k) + random(generator);
                  dF[q][i][k] = random(generator);
                }
          while (dealii::DerivativeForm<1, m, dim>(F[q]).determinant() < .2);
        }
    }

    void
    expect_the_same(Law &law, Law &twin) const
    {
      law.set_points(points);
      twin.set_points(points);
      std::vector<double> W, V;
      std::vector<Matrix> P, Q, dP, dQ;
      law.energy(F, W);
      twin.energy(F, V);
      law.stress(F, P);
      twin.stress(F, Q);
      law.stress_derivative(F, dF, dP);
      twin.stress_derivative(F, dF, dQ);
      ASSERT_EQ(V.size(), F.size());
      ASSERT_EQ(Q.size(), F.size());
      ASSERT_EQ(dQ.size(), F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          EXPECT_NEAR(V[q], W[q], 1e-10);
          for (unsigned int i = 0; i < dim; ++i)
            {
              EXPECT_LT((Q[q][i] - P[q][i]).norm(), 1e-10);
              EXPECT_LT((dQ[q][i] - dP[q][i]).norm(), 1e-10);
            }
        }
    }

    std::vector<typename Law::MaterialPoint> points;
    std::vector<Matrix> F, dF;
  };


  template <int m, int dim>
  void
  compare_neo_hookean()
  {
    const Sample<m, dim> sample;
    std::vector<double> mu;
    for (const auto &point : sample.points)
      mu.push_back(2 + point.place[0]);
    for (const std::string form : {"", ", \"stress_free\": true", ", \"incompressible\": true"})
      if (m < dim || form.find("incompressible") == std::string::npos)
        {
          SCOPED_TRACE(std::to_string(m) + " in " + std::to_string(dim) + form);
          const auto law = registry().create<ConstitutiveLaw<m, dim>>(
            "neo_hookean", R"({"shear_modulus": "2 + s1")" + form + "}");
          testing::NeoHookeanTwin<m, dim> twin(mu,
                                               form.find("stress_free") != std::string::npos,
                                               form.find("incompressible") != std::string::npos);
          sample.expect_the_same(*law, twin);
        }
  }
} // namespace


TEST(EnergyLaw, NeoHookeanIsTheSame)
{
  compare_neo_hookean<1, 2>();
  compare_neo_hookean<2, 2>();
  compare_neo_hookean<2, 3>();
  compare_neo_hookean<3, 3>();
}


namespace
{
  /// A twin under a name of its own, whose parameters the schema of the other checks.
  Registry
  registry_with_twin()
  {
    Registry result;
    result.add<ConstitutiveLaw, testing::MooneyRivlinTwin>(
      "twin", registry().find("constitutive_law/mooney_rivlin_fibres").schema);
    return result;
  }


  template <int m, int dim>
  void
  compare_mooney_rivlin(const Registry &twins)
  {
    const Sample<m, dim> sample;
    for (const std::string tension : {"false", "true"})
      {
        const std::string parameters =
          R"({"c1": 1.2, "c2": 0.4, "fibre_modulus": 3, "tension_only": )" + tension +
          R"(, "fibres": [["1", "0.3 + s1^2")" + (dim == 3 ? ", \"s2\"" : "") + R"(], ["1", -0.5)" +
          (dim == 3 ? ", 0" : "") + "]]}";
        const auto law =
          registry().create<ConstitutiveLaw<m, dim>>("mooney_rivlin_fibres", parameters);
        const auto twin = twins.create<ConstitutiveLaw<m, dim>>("twin", parameters);
        sample.expect_the_same(*law, *twin);
      }
  }
} // namespace


TEST(EnergyLaw, MooneyRivlinFibresIsTheSame)
{
  const Registry twins = registry_with_twin();
  compare_mooney_rivlin<1, 2>(twins);
  compare_mooney_rivlin<2, 2>(twins);
  compare_mooney_rivlin<2, 3>(twins);
  compare_mooney_rivlin<3, 3>(twins);
}


// Functions of one number with two derivatives, the second by dual numbers of dual numbers.
TEST(Dual, FunctionsHaveTheirDerivatives)
{
  using Twice    = Dual<1, Dual<1, Lanes>>;
  const double v = .7;
  Twice x(v);
  x.value.slope[0]  = 1.;
  x.slope[0]        = Dual<1, Lanes>(1.);
  const auto expect = [](const Twice &f, const double value, const double d, const double dd) {
    for (unsigned int lane = 0; lane < Lanes::n; ++lane)
      {
        EXPECT_NEAR(f.value.value[lane], value, 1e-14);
        EXPECT_NEAR(f.slope[0].value[lane], d, 1e-14);
        EXPECT_NEAR(f.value.slope[0][lane], d, 1e-14);
        EXPECT_NEAR(f.slope[0].slope[0][lane], dd, 1e-13);
      }
  };
  expect(exp(x), std::exp(v), std::exp(v), std::exp(v));
  expect(log(x), std::log(v), 1 / v, -1 / (v * v));
  expect(sqrt(x), std::sqrt(v), .5 / std::sqrt(v), -.25 * std::pow(v, -1.5));
  expect(pow(x, 3.5), std::pow(v, 3.5), 3.5 * std::pow(v, 2.5), 8.75 * std::pow(v, 1.5));
  expect(sin(x), std::sin(v), std::cos(v), -std::sin(v));
  expect(cos(x), std::cos(v), -std::sin(v), -std::cos(v));
  expect(2. / x - x / 2, 2 / v - v / 2, -2 / (v * v) - .5, 4 / (v * v * v));
  expect((1. + x) * (3. - x) / x, 3 / v + 2 - v, -3 / (v * v) - 1, 6 / (v * v * v));
  expect(positive_part(x) * x, v * v, 2 * v, 2);
  expect(positive_part(-x) * x, 0, 0, 0);
  expect(step(x) * x, v, 1, 0);
}
