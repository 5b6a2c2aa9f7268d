// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("gent");

using namespace feib::testing;

namespace
{
  const char *const parameters = R"({"shear_modulus": 0.8, "limit": 4})";
}

TEST(Gent, Stretches)
{
  for (const double x : {.7, 1., 1.9})
    {
      const double y = 1 / std::sqrt(x), I = x * x + 2 / x - 3, factor = .8 / (1 - I / 4);
      const auto [W, P] = stretched<3, 3>("gent", parameters, {x, y, y});
      EXPECT_NEAR(W, -1.6 * std::log(1 - I / 4), 1e-12);
      EXPECT_NEAR(P[0][0], factor * x, 1e-12);
      EXPECT_NEAR(P[2][2], factor * y, 1e-12);
    }
}

TEST(Gent, Shear)
{
  const double g    = 1.1;
  const auto [W, P] = sheared<2>("gent", parameters, g);
  EXPECT_NEAR(W, -1.6 * std::log(1 - g * g / 4), 1e-12);
  EXPECT_NEAR(P[0][1], .8 * g / (1 - g * g / 4), 1e-12);
}

TEST(Gent, TheLimitIsNotReached)
{
  const auto [before, P] = stretched<1, 2>("gent", parameters, {std::sqrt(4.999)});
  EXPECT_GT(P[0][0], 1e3);
  EXPECT_FALSE(std::isfinite((stretched<1, 2>("gent", parameters, {std::sqrt(5.001)}).first)));
}
