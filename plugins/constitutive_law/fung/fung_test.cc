// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("fung");

using namespace feib::testing;

namespace
{
  const char *const parameters =
    R"({"c": 0.6, "b_f": 2, "b_t": 0.7, "b_fs": 1.1, "fibres": [[1, 0, 0]]})";
}

TEST(Fung, StretchesAlongAndAcrossFibres)
{
  for (const double x : {.8, 1., 1.3})
    {
      const double y = 1.1, z = .9, e = (x * x - 1) / 2, f = (y * y - 1) / 2, g = (z * z - 1) / 2;
      const double Q    = 2 * e * e + .7 * (f * f + g * g);
      const auto [W, P] = stretched<3, 3>("fung", parameters, {x, y, z});
      EXPECT_NEAR(W, .3 * (std::exp(Q) - 1), 1e-12);
      EXPECT_NEAR(P[0][0], .6 * std::exp(Q) * 2 * e * x, 1e-12);
      EXPECT_NEAR(P[1][1], .6 * std::exp(Q) * .7 * f * y, 1e-12);
      EXPECT_NEAR(P[2][2], .6 * std::exp(Q) * .7 * g * z, 1e-12);
    }
}

// E_fs = g/2, E_ss = g^2/2.
TEST(Fung, ShearOfFibres)
{
  const double g = .7, Q = .7 * std::pow(g * g / 2, 2) + 2.2 * g * g / 4;
  const auto [W, P] = sheared<3>("fung", parameters, g);
  EXPECT_NEAR(W, .3 * (std::exp(Q) - 1), 1e-12);
  EXPECT_NEAR(P[0][1], .3 * std::exp(Q) * (.7 * g * g * g + 1.1 * g), 1e-12);
}

TEST(Fung, HasOneDirection)
{
  EXPECT_THROW((registry().create<feib::ConstitutiveLaw<2, 2>>(
                 "fung", R"({"c": 1, "b_f": 2, "b_t": 1, "b_fs": 1, "fibres": [[1, 0], [0, 1]]})")),
               feib::Error);
}
