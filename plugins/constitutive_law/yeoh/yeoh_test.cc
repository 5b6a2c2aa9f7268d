// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("yeoh");

using namespace feib::testing;

namespace
{
  const char *const parameters = R"({"c1": 0.5, "c2": -0.1, "c3": 0.04})";

  double
  slope(const double x)
  {
    return .5 - .2 * x + .12 * x * x;
  }
} // namespace

TEST(Yeoh, Stretches)
{
  for (const double x : {.7, 1., 2.})
    {
      // An incompressible bar: y = z = 1/sqrt(x).
      const double y = 1 / std::sqrt(x), I = x * x + 2 / x - 3;
      const auto [W, P] = stretched<3, 3>("yeoh", parameters, {x, y, y});
      EXPECT_NEAR(W, .5 * I - .1 * I * I + .04 * I * I * I, 1e-12);
      EXPECT_NEAR(P[0][0], 2 * x * slope(I), 1e-12);
      EXPECT_NEAR(P[1][1], 2 * y * slope(I), 1e-12);
      // The tension of the bar, pressure taken away: 2 (x - 1/x^2) W'.
      EXPECT_NEAR(P[0][0] - P[1][1] * y / x, 2 * (x - 1 / (x * x)) * slope(I), 1e-12);
    }
}

TEST(Yeoh, Shear)
{
  const double g    = 1.2;
  const auto [W, P] = sheared<2>("yeoh", parameters, g);
  EXPECT_NEAR(P[0][1], 2 * g * slope(g * g), 1e-12);
  EXPECT_NEAR(W, g * g * (.5 + g * g * (-.1 + .04 * g * g)), 1e-12);
}
