// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>

FEIB_TEST_CONSTITUTIVE_LAW("anisotropic_linear");

using feib::testing::registry;

// P = kappa dX/ds, whatever the frame of the curve is.
TEST(AnisotropicLinear, CurveNeedsNoDirection)
{
  using Law      = feib::ConstitutiveLaw<1, 2>;
  const auto law = registry().create<Law>("anisotropic_linear", R"({"stiffness": 5})");
  std::vector<Law::MaterialPoint> points(1);
  points[0].frame[0][0] = 1;
  law->set_points(points);
  std::vector<Law::Matrix> F(1), P;
  F[0][0][0] = 2;
  F[0][1][0] = -3;
  law->stress(F, P);
  EXPECT_DOUBLE_EQ(P[0][0][0], 10);
  EXPECT_DOUBLE_EQ(P[0][1][0], -15);
}

// Circumferential fibres at (0, 2) run along -e1; the radial stretch carries nothing.
TEST(AnisotropicLinear, DirectionIsAnExpressionOfTheReferencePlace)
{
  using Law = feib::ConstitutiveLaw<2, 2>;
  const auto law =
    registry().create<Law>("anisotropic_linear", R"({"stiffness": 5, "fibres": [["-s2", "s1"]]})");
  std::vector<Law::MaterialPoint> points(1);
  points[0].place    = dealii::Point<2>(0, 2);
  points[0].frame[0] = dealii::Point<2>(1, 0);
  points[0].frame[1] = dealii::Point<2>(0, 1);
  law->set_points(points);
  std::vector<Law::Matrix> F(1), P;
  F[0][0][0] = 1;
  F[0][0][1] = 2;
  F[0][1][0] = 3;
  F[0][1][1] = 4;
  law->stress(F, P);
  EXPECT_DOUBLE_EQ(P[0][0][0], 5);
  EXPECT_DOUBLE_EQ(P[0][0][1], 0);
  EXPECT_DOUBLE_EQ(P[0][1][0], 15);
  EXPECT_DOUBLE_EQ(P[0][1][1], 0);
}

namespace
{
  template <int structure_dim, int dim>
  std::string
  error_of(const std::string &json)
  {
    using Law = feib::ConstitutiveLaw<structure_dim, dim>;
    try
      {
        const auto law = registry().create<Law>("anisotropic_linear", json);
        std::vector<typename Law::MaterialPoint> points(1);
        for (unsigned int k = 0; k < structure_dim; ++k)
          points[0].frame[k][k] = 1;
        law->set_points(points);
      }
    catch (const feib::Error &error)
      {
        return error.issues().front().pointer + ": " + error.issues().front().message;
      }
    return "";
  }
} // namespace

TEST(AnisotropicLinear, SaysWhatIsWrongWithFibres)
{
  const auto contains = [](const std::string &message, const std::string &part) {
    return message.find(part) != std::string::npos;
  };
  EXPECT_PRED2(contains, (error_of<2, 2>(R"({"stiffness": 1})")), "/fibres: is empty");
  EXPECT_PRED2(contains,
               (error_of<2, 2>(R"({"stiffness": 1, "fibres": [["s1", "s2"]]})")),
               "/fibres/0: has no direction in the structure at the reference place (0, 0)");
  EXPECT_PRED2(contains,
               (error_of<2, 3>(R"({"stiffness": 1, "fibres": [[1, 0, 0], [0, 0, 1]]})")),
               "/fibres/1: has no direction");
  EXPECT_PRED2(contains, (error_of<3, 3>(R"({"stiffness": 1, "fibres": [[1, 0]]})")), "/fibres/0");
  EXPECT_PRED2(contains,
               (error_of<2, 2>(R"({"stiffness": 1, "fibres": [["q", 0]]})")),
               "/fibres/0");
}
