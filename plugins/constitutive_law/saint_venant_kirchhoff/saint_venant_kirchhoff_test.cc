// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("saint_venant_kirchhoff");

using namespace feib::testing;

namespace
{
  const char *const parameters = R"({"mu": 0.7, "lambda": 1.3})";
}

// A stretch by x and y along two directions: E = ((x^2 - 1)/2, (y^2 - 1)/2).
TEST(SaintVenantKirchhoff, Stretches)
{
  for (const double x : {.7, 1., 1.6})
    for (const double y : {.9, 1.3})
      {
        const double e = (x * x - 1) / 2, f = (y * y - 1) / 2;
        const auto [W, P] = stretched<2, 2>("saint_venant_kirchhoff", parameters, {x, y});
        EXPECT_NEAR(W, .65 * (e + f) * (e + f) + .7 * (e * e + f * f), 1e-12);
        EXPECT_NEAR(P[0][0], x * (1.3 * (e + f) + 1.4 * e), 1e-12);
        EXPECT_NEAR(P[1][1], y * (1.3 * (e + f) + 1.4 * f), 1e-12);
      }
}

// F = I + g e1 (x) e2: E11 = 0, E12 = g/2, E22 = g^2/2.
TEST(SaintVenantKirchhoff, Shear)
{
  const double g = .8, a = g / 2, b = g * g / 2;
  const auto [W, P] = sheared<3>("saint_venant_kirchhoff", parameters, g);
  EXPECT_NEAR(W, .65 * b * b + .7 * (2 * a * a + b * b), 1e-12);
  // P = F S with S = lambda tr E I + 2 mu E
  const double S11 = 1.3 * b, S12 = 1.4 * a, S22 = 1.3 * b + 1.4 * b;
  EXPECT_NEAR(P[0][0], S11 + g * S12, 1e-12);
  EXPECT_NEAR(P[0][1], S12 + g * S22, 1e-12);
  EXPECT_NEAR(P[1][0], S12, 1e-12);
  EXPECT_NEAR(P[1][1], S22, 1e-12);
  EXPECT_NEAR(P[2][2], 1.3 * b, 1e-12);
}
