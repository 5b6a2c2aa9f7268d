// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("exponential_fibre");

using namespace feib::testing;

namespace
{
  // The parameters of Gasser, Ogden and Holzapfel (2006) for a media, in kPa, fibres at 43.39
  // degrees.
  const char *const media =
    R"j({"c": 7.64, "k1": 996.6, "k2": 524.6, "dispersion": 0.226,
         "fibres": [["cos(0.757298362)", "sin(0.757298362)", 0],
                    ["cos(0.757298362)", "-sin(0.757298362)", 0]]})j";
} // namespace

// Stretches x and y with a shear of 0.02, of the published formula in its own words, differentiated
// by steps of 1e-30 along the imaginary axis.
TEST(ExponentialFibre, PublishedParameters)
{
  struct
  {
    double x, y, W, P11, P12, P22, P33;
  } const values[] = {{1.0,
                       1.0,
                       0.0233562882015268,
                       12.9975350707785,
                       2.41123692392881,
                       12.7116940122883,
                       10.6726306447231},
                      {1.05,
                       0.98,
                       0.271660199109809,
                       34.0229384001632,
                       6.68117187472486,
                       30.5437012304021,
                       21.0962554025146},
                      {1.1,
                       0.97,
                       1.83536058235161,
                       125.367823453383,
                       22.6417022438819,
                       105.528183544603,
                       63.8463235021369},
                      {0.95, 1.0, 0.0417649806094179, 7.258, 0.1528, 7.64, 8.04210526315789}};
  for (const auto &value : values)
    {
      feib::ConstitutiveLaw<3, 3>::Matrix F;
      F[0][0]           = value.x;
      F[0][1]           = .02;
      F[1][1]           = value.y;
      F[2][2]           = 1 / (value.x * value.y);
      const auto [W, P] = energy_and_stress<3, 3>("exponential_fibre", media, F);
      EXPECT_NEAR(W, value.W, 1e-8 * value.W);
      EXPECT_NEAR(P[0][0], value.P11, 1e-8 * value.P11);
      EXPECT_NEAR(P[0][1], value.P12, 1e-8 * value.P11);
      EXPECT_NEAR(P[1][1], value.P22, 1e-8 * value.P11);
      EXPECT_NEAR(P[2][2], value.P33, 1e-8 * value.P11);
    }
}

TEST(ExponentialFibre, FibresCarryTensionAlone)
{
  const char *const along    = R"({"c": 2, "k1": 3, "k2": 0.5, "fibres": [[1, 0]]})";
  const auto [compressed, P] = stretched<2, 2>("exponential_fibre", along, {.8, 1.25});
  EXPECT_NEAR(compressed, .64 + 1.5625 - 2, 1e-14);
  EXPECT_NEAR(P[0][0], 2 * .8, 1e-14);
  const double E    = 1.25 * 1.25 - 1;
  const auto [W, Q] = stretched<2, 2>("exponential_fibre", along, {1.25, .8});
  EXPECT_NEAR(W, .64 + 1.5625 - 2 + 3 * (std::exp(.5 * E * E) - 1), 1e-13);
  EXPECT_NEAR(Q[0][0], 2 * 1.25 + 6 * E * std::exp(.5 * E * E) * 1.25, 1e-13);
}

TEST(ExponentialFibre, WithoutDirectionItIsIsotropic)
{
  for (const double angle : {0., .7})
    {
      const std::string fibres =
        "[[" + std::to_string(std::cos(angle)) + ", " + std::to_string(std::sin(angle)) + "]]";
      const auto [W, P] =
        stretched<2, 2>("exponential_fibre",
                        R"({"c": 0, "k1": 2, "k2": 1, "dispersion": 0.5, "fibres": )" + fibres +
                          "}",
                        {1.4, .9});
      const double E = .5 * (1.4 * 1.4 + .81 - 2);
      EXPECT_NEAR(W, std::exp(E * E) - 1, 1e-12);
    }
}

TEST(ExponentialFibre, DispersionBeyondNoDirectionIsRefused)
{
  const auto create = [](const std::string &dispersion, const std::string &fibre) {
    return R"({"c": 1, "k1": 2, "k2": 1, "fibres": [)" + fibre + R"(], "dispersion": )" +
           dispersion + "}";
  };
  EXPECT_THROW((registry().create<feib::ConstitutiveLaw<3, 3>>("exponential_fibre",
                                                               create("0.34", "[1, 0, 0]"))),
               feib::Error);
  EXPECT_NO_THROW((registry().create<feib::ConstitutiveLaw<3, 3>>("exponential_fibre",
                                                                  create("0.33", "[1, 0, 0]"))));
  EXPECT_NO_THROW(
    (registry().create<feib::ConstitutiveLaw<2, 2>>("exponential_fibre", create("0.5", "[1, 0]"))));
}
