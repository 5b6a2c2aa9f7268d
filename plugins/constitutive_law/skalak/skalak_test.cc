// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("skalak");

using namespace feib::testing;

namespace
{
  const char *const parameters = R"({"shear_modulus": 0.9, "area_ratio": 3})";
}

// Tensions per length of the stretched edge, T1 = G x/y (x^2 - 1 + C y^2 ((x y)^2 - 1)): with
// P = T1 y.
TEST(Skalak, Stretches)
{
  for (const double x : {.8, 1., 1.5})
    for (const double y : {.9, 1.2})
      {
        const double a    = x * x * y * y - 1;
        const auto [W, P] = stretched<2, 3>("skalak", parameters, {x, y});
        EXPECT_NEAR(P[0][0], .9 * x * (x * x - 1 + 3 * y * y * a), 1e-12);
        EXPECT_NEAR(P[1][1], .9 * y * (y * y - 1 + 3 * x * x * a), 1e-12);
        const double i = x * x + y * y - 2;
        EXPECT_NEAR(W, .225 * (i * i + 2 * i - 2 * a + 3 * a * a), 1e-12);
      }
}

TEST(Skalak, IsForSurfacesInSpace)
{
  EXPECT_TRUE((registry().offers<feib::ConstitutiveLaw<2, 3>>("skalak")));
  EXPECT_FALSE((registry().offers<feib::ConstitutiveLaw<2, 2>>("skalak")));
  EXPECT_THROW((registry().create<feib::ConstitutiveLaw<3, 3>>("skalak", parameters)), feib::Error);
}
