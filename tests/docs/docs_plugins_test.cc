// SPDX-License-Identifier: LGPL-2.1-or-later
// The plugins whose code stands in the documentation keep what theirs must keep.
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>
#include <feib/testing/structure_model_kit.h>

FEIB_TEST_CONSTITUTIVE_LAW("from_pk1");
FEIB_TEST_CONSTITUTIVE_LAW("from_ufl");
FEIB_TEST_STRUCTURE_MODEL("my_structure");

TEST(ComingFrom, TheyAreOneLaw)
{
  using namespace feib::testing;
  const char *const parameters = R"({"mu": 1.5, "lambda": 4})";
  typename feib::ConstitutiveLaw<3, 3>::Matrix F;
  const double entries[3][3] = {{1.2, .3, -.1}, {-.2, .9, .4}, {.1, 0, 1.1}};
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int k = 0; k < 3; ++k)
      F[i][k] = entries[i][k];
  const auto [W, P]   = energy_and_stress<3, 3>("from_pk1", parameters, F);
  const auto [W2, P2] = energy_and_stress<3, 3>("from_ufl", parameters, F);
  EXPECT_NEAR(W, W2, 1e-13);
  for (unsigned int i = 0; i < 3; ++i)
    EXPECT_LT((P[i] - P2[i]).norm(), 1e-13);
}
