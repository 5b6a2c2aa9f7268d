// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>

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

// A curve stretched by 2: W = mu/2 4 - mu ln 2, P = mu (2 - 1/2).
TEST(NeoHookean, StretchedCurve)
{
  const auto law =
    registry().create<feib::ConstitutiveLaw<1, 2>>("neo_hookean",
                                                   R"({"shear_modulus": 1, "stress_free": true})");
  std::vector<feib::ConstitutiveLaw<1, 2>::Matrix> F(1), P;
  std::vector<double> W;
  F[0][1][0] = -2;
  law->energy(F, W);
  law->stress(F, P);
  EXPECT_DOUBLE_EQ(W[0], 2 - std::log(2.));
  EXPECT_DOUBLE_EQ(P[0][0][0], 0.);
  EXPECT_DOUBLE_EQ(P[0][1][0], -1.5);
}
