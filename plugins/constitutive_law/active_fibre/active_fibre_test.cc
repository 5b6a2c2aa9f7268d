// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("active_fibre");

using namespace feib::testing;

/// The tension of the time and place, along the fibre, whatever the stretch.
TEST(ActiveFibre, PullsAlongTheFibre)
{
  using Law      = feib::ConstitutiveLaw<2, 2>;
  const auto law = registry().create<Law>("active_fibre",
                                          R"j({"tension": "t*(1 + s1)", "fibres": [[0, 1]],
                                               "law": {"neo_hookean": {"shear_modulus": 2}}})j");
  std::vector<Law::MaterialPoint> points(2);
  for (unsigned int q = 0; q < 2; ++q)
    {
      points[q].place[0]    = q;
      points[q].frame[0][0] = points[q].frame[1][1] = 1;
    }
  law->set_points(points);
  Law::Moment moment;
  moment.time = .4;
  law->set_moment(moment);
  EXPECT_TRUE(law->time_dependent());
  Law::Matrix F;
  F[0][0] = 1;
  F[0][1] = .3 * 1.5;
  F[1][1] = .4 * 1.5; // the fibre becomes 0.75 (3, 4)/5
  std::vector<Law::Matrix> P;
  std::vector<double> W;
  law->energy({F, F}, W);
  law->stress({F, F}, P);
  for (unsigned int q = 0; q < 2; ++q)
    {
      const double T = .4 * (1 + q);
      EXPECT_NEAR(W[q], 1 + .75 * .75 + T * (.75 - 1), 1e-14);
      EXPECT_NEAR(P[q][0][0], 2, 1e-14);
      EXPECT_NEAR(P[q][0][1], 2 * F[0][1] + T * .6, 1e-14);
      EXPECT_NEAR(P[q][1][1], 2 * F[1][1] + T * .8, 1e-14);
    }
}

TEST(ActiveFibre, TensionsThatAreNoneAreRefused)
{
  using Law = feib::ConstitutiveLaw<1, 2>;
  const auto law =
    registry().create<Law>("active_fibre",
                           R"({"tension": "1/s1", "law": {"neo_hookean": {"shear_modulus": 2}}})");
  std::vector<Law::MaterialPoint> points(1);
  points[0].frame[0][0] = 1;
  EXPECT_THROW(law->set_points(points), feib::Error);
}
