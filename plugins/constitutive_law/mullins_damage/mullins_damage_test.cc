// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

FEIB_TEST_CONSTITUTIVE_LAW("mullins_damage");

using namespace feib::testing;

namespace
{
  using Law = feib::ConstitutiveLaw<1, 2>;

  // W_0 = |F|^2/2, so w = (x^2 - 1)/2 for a stretch x, P_0 = x.
  const char *const parameters =
    R"({"r": 2, "m": 0.3, "beta": 0.1, "law": {"neo_hookean": {"shear_modulus": 1}}})";

  Law::Matrix
  stretch(const double x)
  {
    Law::Matrix F;
    F[0][0] = x;
    return F;
  }

  double
  energy(const double x)
  {
    return (x * x - 1) / 2;
  }

  /// The law with a largest energy so far.
  struct Loaded
  {
    explicit Loaded(const double largest)
      : law(registry().create<Law>("mullins_damage", parameters))
    {
      law->set_points(std::vector<Law::MaterialPoint>(1));
      moment.state = {{largest}};
      law->set_moment(moment);
    }

    double
    stress(const double x) const
    {
      std::vector<Law::Matrix> P;
      law->stress({stretch(x)}, P);
      return P[0][0][0];
    }

    double
    energy(const double x) const
    {
      std::vector<double> W;
      law->energy({stretch(x)}, W);
      return W[0];
    }

    std::unique_ptr<Law> law;
    Law::Moment moment;
  };
} // namespace

TEST(MullinsDamage, FirstLoadingThenSofter)
{
  const Loaded virgin(0), loaded(energy(2));
  for (const double x : {1., 1.3, 1.7})
    {
      EXPECT_NEAR(virgin.stress(x), x, 1e-14);
      const double M = energy(2);
      EXPECT_NEAR(loaded.stress(x),
                  x * (1 - .5 * std::erf((M - energy(x)) / (.3 + .1 * M))),
                  1e-14);
    }
  EXPECT_NEAR(loaded.stress(2.), 2, 1e-14);
  EXPECT_NEAR(loaded.stress(2.5), 2.5, 1e-14);
}

TEST(MullinsDamage, TheLargestEnergyIsKept)
{
  const Loaded loaded(energy(1.5));
  std::vector<std::vector<double>> state = loaded.moment.state;
  loaded.law->update_state({stretch(1.2)}, state);
  EXPECT_DOUBLE_EQ(state[0][0], energy(1.5));
  loaded.law->update_state({stretch(1.9)}, state);
  EXPECT_NEAR(state[0][0], energy(1.9), 1e-15);
}

/// The work of loading to x = 2 and back is what the energy loses as the state moves on: by
/// quadrature of the closed form.
TEST(MullinsDamage, TheLoopIsWhatIsDissipated)
{
  double loop          = 0;
  const double M       = energy(2);
  const unsigned int n = 4000;
  for (unsigned int i = 0; i < n; ++i)
    {
      const double w = (i + .5) / n * M;
      loop += .5 * std::erf((M - w) / (.3 + .1 * M)) * M / n;
    }
  const Loaded virgin(0), loaded(M);
  EXPECT_NEAR(virgin.energy(2) - loaded.energy(2), loop, 1e-6 * loop);
  EXPECT_NEAR(loaded.energy(1), 0, 1e-14);
}
