// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("kelvin_voigt");

using namespace feib::testing;

namespace
{
  const char *const parameters =
    R"({"viscosity": 0.3, "law": {"neo_hookean": {"shear_modulus": 2}}})";

  template <int structure_dim, int dim>
  typename feib::ConstitutiveLaw<structure_dim, dim>::Matrix
  viscous_stress(const typename feib::ConstitutiveLaw<structure_dim, dim>::Matrix &F,
                 const typename feib::ConstitutiveLaw<structure_dim, dim>::Matrix &rate)
  {
    const auto law =
      registry().create<feib::ConstitutiveLaw<structure_dim, dim>>("kelvin_voigt", parameters);
    std::vector<typename feib::ConstitutiveLaw<structure_dim, dim>::Matrix> P;
    law->set_points(
      std::vector<typename feib::ConstitutiveLaw<structure_dim, dim>::MaterialPoint>(1));
    law->viscous_stress({F}, {rate}, P);
    return P.at(0);
  }
} // namespace

TEST(KelvinVoigt, TheElasticPartIsThatOfTheLaw)
{
  const auto [W, P] = stretched<2, 2>("kelvin_voigt", parameters, {1.2, .9});
  EXPECT_NEAR(W, 1.44 + .81, 1e-14);
  EXPECT_NEAR(P[0][0], 2.4, 1e-14);
}

/// E = (x^2 - 1)/2, dE/dt = x dx/dt, P = eta x^2 dx/dt.
TEST(KelvinVoigt, Stretching)
{
  feib::ConstitutiveLaw<1, 2>::Matrix F, rate;
  F[1][0]    = 1.3;
  rate[1][0] = .7;
  EXPECT_NEAR((viscous_stress<1, 2>(F, rate)[1][0]), .3 * 1.69 * .7, 1e-14);
}

/// F = I + g e1 (x) e2: dE/dt = g'/2 (e1 (x) e2 + e2 (x) e1) + g g' e2 (x) e2.
TEST(KelvinVoigt, Shearing)
{
  const double g = .6, rate_of_g = 1.1;
  feib::ConstitutiveLaw<2, 2>::Matrix F, rate;
  F[0][0] = F[1][1] = 1;
  F[0][1]           = g;
  rate[0][1]        = rate_of_g;
  const auto P      = viscous_stress<2, 2>(F, rate);
  EXPECT_NEAR(P[0][0], .3 * rate_of_g * g / 2, 1e-14);
  EXPECT_NEAR(P[0][1], .3 * rate_of_g * (.5 + g * g), 1e-14);
  EXPECT_NEAR(P[1][0], .3 * rate_of_g / 2, 1e-14);
  EXPECT_NEAR(P[1][1], .3 * rate_of_g * g, 1e-14);
}
