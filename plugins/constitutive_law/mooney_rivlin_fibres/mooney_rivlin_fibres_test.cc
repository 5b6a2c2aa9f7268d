// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>

FEIB_TEST_CONSTITUTIVE_LAW("mooney_rivlin_fibres");

using feib::testing::registry;

namespace
{
  template <int structure_dim, int dim>
  double
  energy_at_rest()
  {
    using Law      = feib::ConstitutiveLaw<structure_dim, dim>;
    const auto law = registry().create<Law>(
      "mooney_rivlin_fibres",
      dim == 2 ? R"({"c1": 1, "c2": 2, "fibre_modulus": 3, "fibres": [[2, 1]]})"
               : R"({"c1": 1, "c2": 2, "fibre_modulus": 3, "fibres": [[2, 1, 0]]})");
    std::vector<typename Law::MaterialPoint> points(1);
    std::vector<typename Law::Matrix> F(1);
    std::vector<double> W;
    for (unsigned int k = 0; k < structure_dim; ++k)
      points[0].frame[k][k] = F[0][k][k] = 1;
    law->set_points(points);
    law->energy(F, W);
    return W[0];
  }
} // namespace

TEST(MooneyRivlinFibres, NoEnergyAtRest)
{
  EXPECT_NEAR((energy_at_rest<1, 2>()), 0, 1e-14);
  EXPECT_NEAR((energy_at_rest<2, 2>()), 0, 1e-14);
  EXPECT_NEAR((energy_at_rest<2, 3>()), 0, 1e-14);
  EXPECT_NEAR((energy_at_rest<3, 3>()), 0, 1e-14);
}

// In two dimensions I2 = J^2: c2 adds the pressure P = 2 c2 J^2 F^-T and nothing else.
TEST(MooneyRivlinFibres, SecondInvariantIsAPressureIn2D)
{
  using Law      = feib::ConstitutiveLaw<2, 2>;
  const auto law = registry().create<Law>("mooney_rivlin_fibres", R"({"c1": 0, "c2": 0.5})");
  std::vector<Law::Matrix> F(1), P;
  F[0][0][0]     = 1.5;
  F[0][0][1]     = .5;
  F[0][1][0]     = -.25;
  F[0][1][1]     = 2;
  const double J = 1.5 * 2 + .5 * .25;
  law->stress(F, P);
  EXPECT_NEAR(P[0][0][0], J * 2, 1e-13);
  EXPECT_NEAR(P[0][0][1], J * .25, 1e-13);
  EXPECT_NEAR(P[0][1][0], J * -.5, 1e-13);
  EXPECT_NEAR(P[0][1][1], J * 1.5, 1e-13);
}

TEST(MooneyRivlinFibres, ShortenedFibresMayCarryNothing)
{
  using Law = feib::ConstitutiveLaw<1, 2>;
  for (const bool tension_only : {false, true})
    {
      const auto law =
        registry().create<Law>("mooney_rivlin_fibres",
                               tension_only
                                 ? R"({"c1": 0, "fibre_modulus": 1, "tension_only": true})"
                                 : R"({"c1": 0, "fibre_modulus": 1})");
      std::vector<Law::MaterialPoint> points(2);
      points[0].frame[0][0] = points[1].frame[0][0] = 1;
      law->set_points(points);
      std::vector<Law::Matrix> F(2), P;
      F[0][0][0] = .5;
      F[1][0][0] = 2;
      law->stress(F, P);
      EXPECT_DOUBLE_EQ(P[0][0][0], tension_only ? 0. : 2 * (.25 - 1) * .5);
      EXPECT_DOUBLE_EQ(P[1][0][0], 2 * (4 - 1) * 2.);
    }
}

TEST(MooneyRivlinFibres, FibreModulusNeedsFibres)
{
  EXPECT_THROW((registry().create<feib::ConstitutiveLaw<3, 3>>("mooney_rivlin_fibres",
                                                               R"({"c1": 1, "fibre_modulus": 1})")),
               feib::Error);
}
