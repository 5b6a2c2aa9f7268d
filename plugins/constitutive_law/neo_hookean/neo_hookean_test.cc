// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("neo_hookean");

using feib::testing::registry;

namespace
{
  template <int structure_dim, int dim>
  void
  stress_at_rest(const bool stress_free)
  {
    using Law = feib::ConstitutiveLaw<structure_dim, dim>;
    const auto law =
      registry().create<Law>("neo_hookean",
                             stress_free ? R"({"shear_modulus": 3, "stress_free": true})"
                                         : R"({"shear_modulus": 3})");
    law->set_points(std::vector<typename Law::MaterialPoint>(1));
    EXPECT_EQ(law->needs_positive_determinant(), stress_free);
    std::vector<typename Law::Matrix> F(1), P;
    for (unsigned int k = 0; k < structure_dim; ++k)
      F[0][k][k] = 1;
    law->stress(F, P);
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int k = 0; k < structure_dim; ++k)
        EXPECT_DOUBLE_EQ(P[0][i][k], !stress_free && i == k ? 3. : 0.);
  }
} // namespace

TEST(NeoHookean, StressAtRest)
{
  for (const bool stress_free : {false, true})
    {
      stress_at_rest<1, 2>(stress_free);
      stress_at_rest<2, 2>(stress_free);
      stress_at_rest<2, 3>(stress_free);
      stress_at_rest<3, 3>(stress_free);
    }
}

// Stretches x, y and 1/(x y) of a sheet whose tension across vanishes: P1 = mu (x - 1/(x^3 y^2)).
TEST(NeoHookean, IncompressibleSheet)
{
  const char *const parameters = R"({"shear_modulus": 0.6, "incompressible": true})";
  for (const double x : {.7, 1., 1.6})
    for (const double y : {.9, 1.2})
      {
        const auto [W, P] = feib::testing::stretched<2, 3>("neo_hookean", parameters, {x, y});
        EXPECT_NEAR(W, .3 * (x * x + y * y + 1 / (x * x * y * y) - 3), 1e-12);
        EXPECT_NEAR(P[0][0], .6 * (x - 1 / (x * x * x * y * y)), 1e-12);
        EXPECT_NEAR(P[1][1], .6 * (y - 1 / (x * x * y * y * y)), 1e-12);
      }
  const auto [W, P] = feib::testing::stretched<1, 2>("neo_hookean", parameters, {2.});
  EXPECT_NEAR(W, .3 * (4 + .25 - 2), 1e-12);
  EXPECT_NEAR(P[0][0], .6 * (2 - .125), 1e-12);
  EXPECT_THROW((registry().create<feib::ConstitutiveLaw<2, 2>>("neo_hookean", parameters)),
               feib::Error);
  EXPECT_THROW((registry().create<feib::ConstitutiveLaw<2, 3>>(
                 "neo_hookean",
                 R"({"shear_modulus": 1, "incompressible": true, "stress_free": true})")),
               feib::Error);
}

// A curve stretched by 2: W = mu/2 4 - mu ln 2, P = mu (2 - 1/2).
TEST(NeoHookean, StretchedCurve)
{
  const auto law =
    registry().create<feib::ConstitutiveLaw<1, 2>>("neo_hookean",
                                                   R"({"shear_modulus": 1, "stress_free": true})");
  law->set_points(std::vector<feib::ConstitutiveLaw<1, 2>::MaterialPoint>(1));
  std::vector<feib::ConstitutiveLaw<1, 2>::Matrix> F(1), P;
  std::vector<double> W;
  F[0][1][0] = -2;
  law->energy(F, W);
  law->stress(F, P);
  EXPECT_DOUBLE_EQ(W[0], 2 - std::log(2.));
  EXPECT_DOUBLE_EQ(P[0][0][0], 0.);
  EXPECT_DOUBLE_EQ(P[0][1][0], -1.5);
}

namespace
{
  using Law = feib::ConstitutiveLaw<2, 2>;

  /// The stresses at F = I at the places (0.6, 0.5) and (0, 1): mu_e there.
  std::vector<Law::Matrix>
  stress_at_two_places(const std::string &parameters)
  {
    const auto law = registry().create<Law>("neo_hookean", parameters);
    std::vector<Law::MaterialPoint> points(2);
    points[0].place = dealii::Point<2>(.6, .5);
    points[1].place = dealii::Point<2>(0, 1);
    law->set_points(points);
    EXPECT_TRUE(law->linear());
    std::vector<Law::Matrix> F(2), P;
    for (Law::Matrix &A : F)
      A[0][0] = A[1][1] = 1;
    law->stress(F, P);
    return P;
  }

  std::string
  error_of(const std::string &parameters)
  {
    try
      {
        stress_at_two_places(parameters);
      }
    catch (const feib::Error &error)
      {
        return error.issues().front().pointer + ": " + error.issues().front().message;
      }
    return "";
  }
} // namespace

TEST(NeoHookean, ModulusIsAnExpressionOfTheReferencePlace)
{
  const auto P =
    stress_at_two_places(R"({"shear_modulus": "(s1-0.6)^2+(s2-0.5)^2 < 0.01 ? 5 : 1"})");
  EXPECT_EQ(P[0][0][0], 5);
  EXPECT_EQ(P[0][1][1], 5);
  EXPECT_EQ(P[1][0][0], 1);
  EXPECT_EQ(P[1][1][1], 1);
  EXPECT_EQ(stress_at_two_places(R"({"shear_modulus": "0 * s1 + 0.1"})"),
            stress_at_two_places(R"({"shear_modulus": 0.1})"));
}

TEST(NeoHookean, SaysWhereTheModulusIsWrong)
{
  EXPECT_EQ(error_of(R"({"shear_modulus": "s1 - 0.25"})"),
            "/shear_modulus: is -0.25 at the reference place (0, 1); it must be finite and "
            "positive there");
  EXPECT_EQ(error_of(R"({"shear_modulus": "0.6 - s1"})"),
            "/shear_modulus: is 0 at the reference place (0.6, 0.5); it must be finite and "
            "positive there");
  EXPECT_EQ(error_of(R"({"shear_modulus": "1 / s1"})"),
            "/shear_modulus: is inf at the reference place (0, 1); it must be finite and positive "
            "there");
  EXPECT_NE(
    error_of(R"j({"shear_modulus": "sqrt(0.75 - s2)"})j").find("nan at the reference place"),
    std::string::npos);
  EXPECT_EQ(error_of(R"({"shear_modulus": 0})").substr(0, 14), "/shear_modulus");
  EXPECT_EQ(error_of(R"({"shear_modulus": "mu"})").substr(0, 14), "/shear_modulus");
}
