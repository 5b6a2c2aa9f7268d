// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_constitutive_law_kit_h
#define feib_testing_constitutive_law_kit_h

#include <feib/testing/derivative.h>
#include <feib/testing/examples.h>
#include <feib/testing/law_sample.h>

#include <algorithm>
#include <iomanip>
#include <limits>
#include <map>

namespace feib::testing
{
  /// The relative error of a derivative beside differences; of several steps the least, as a law
  /// may have a kink nearby, where its fibres become slack.
  template <typename Function, typename Distance>
  double
  error_of_derivative(const Function &function, const Distance &distance)
  {
    double least = std::numeric_limits<double>::infinity();
    for (const double step : {1e-2, 1e-3, 1e-4})
      least = std::min(least, distance(derivative(function, step)));
    return least;
  }


  /// P = dW/dF.
  inline void
  check_stress(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](const auto &sample) {
      const auto P = sample.stress(sample.F);
      // By the factor people see which term they have forgotten.
      double product = 0, square = 0;
      for (unsigned int q = 0; q < P.size(); ++q)
        {
          const double expected =
            derivative([&](const double h) { return sample.energy(sample.moved(h))[q]; });
          product += sample.product(P[q], sample.dF[q]) * expected;
          square += expected * expected;
        }
      for (unsigned int q = 0; q < P.size(); ++q)
        {
          const double power = sample.product(P[q], sample.dF[q]);
          EXPECT_LT(
            error_of_derivative([&](const double h) { return sample.energy(sample.moved(h))[q]; },
                                [&](const double expected) {
                                  return std::abs(power - expected) / (1 + std::abs(expected));
                                }),
            1e-7)
            << "P is not dW/dF: over all points P : dF is " << std::setprecision(4)
            << product / square
            << " times the change of W; 2 or 0.5 is often forgotten in P = 2 F dW/dC, -1 is a "
               "sign, "
               "others mean a term that is missing, or transposed";
        }
    });
  }


  /// dP = dP/dF [dF].
  inline void
  check_stress_derivative(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](const auto &sample) {
      const auto dP = sample.stress_derivative(sample.dF);
      for (unsigned int q = 0; q < dP.size(); ++q)
        for (unsigned int i = 0; i < dP[q].dimension; ++i)
          EXPECT_LT(error_of_derivative(
                      [&](const double h) { return sample.stress(sample.moved(h))[q][i]; },
                      [&](const auto &expected) {
                        return (dP[q][i] - expected).norm() / (1 + expected.norm());
                      }),
                    1e-7)
            << "dP is not the derivative of P along dF: row " << i << " is " << dP[q][i];
    });
  }


  /// A law that says it is linear has one derivative everywhere.
  inline void
  check_linear(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      if (!sample.law->linear())
        return;
      const auto before = sample.stress_derivative(sample.dF);
      sample.F          = sample.moved(.1);
      const auto after  = sample.stress_derivative(sample.dF);
      for (unsigned int q = 0; q < before.size(); ++q)
        for (unsigned int i = 0; i < before[q].dimension; ++i)
          EXPECT_LT((before[q][i] - after[q][i]).norm(), 1e-13 * (1 + before[q][i].norm()))
            << "linear() is true, but dP depends on F";
    });
  }


  /// dP is a second derivative.
  inline void
  check_symmetry(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      auto other = sample.dF;
      for (auto &matrix : other)
        for (unsigned int i = 0; i < matrix.dimension; ++i)
          for (unsigned int k = 0; k < matrix[i].dimension; ++k)
            matrix[i][k] = sample.random();
      const auto dP = sample.stress_derivative(sample.dF), dQ = sample.stress_derivative(other);
      for (unsigned int q = 0; q < dP.size(); ++q)
        {
          const double expected = sample.product(dQ[q], sample.dF[q]);
          EXPECT_NEAR(sample.product(dP[q], other[q]), expected, 1e-12 * (1 + std::abs(expected)))
            << "dP(F)[dF] : dG is not dP(F)[dG] : dF: no second derivative of an energy";
        }
    });
  }


  /// W(Q F) = W(F), P(Q F) = Q P(F) for rotations Q; then the stress of Cauchy is symmetric.
  inline void
  check_frame_indifference(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      const auto Q = sample.rotation();
      auto rotated = sample.F;
      for (auto &F : rotated)
        F = sample.rotated(Q, F);
      const auto W = sample.energy(sample.F), W_rotated = sample.energy(rotated);
      const auto P = sample.stress(sample.F), P_rotated = sample.stress(rotated);
      for (unsigned int q = 0; q < W.size(); ++q)
        {
          EXPECT_NEAR(W_rotated[q], W[q], 1e-12 * (1 + std::abs(W[q])))
            << "W(Q F) is not W(F): the energy depends on how the observer stands; write it in "
               "terms of C = F^T F";
          EXPECT_LT(sample.distance(P_rotated[q], sample.rotated(Q, P[q])),
                    1e-12 * (1 + std::sqrt(sample.product(P[q], P[q]))))
            << "P(Q F) is not Q P(F): the stress depends on how the observer stands";
        }
    });
  }


  /// What a point gives depends neither on the other points nor on its place among them.
  inline void
  check_arrays(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      const auto W      = sample.energy(sample.F);
      const auto P      = sample.stress(sample.F);
      const auto dP     = sample.stress_derivative(sample.dF);
      const auto points = sample.points;
      const auto state  = sample.moment.state;
      const auto F = sample.F, dF = sample.dF;
      for (unsigned int q = 0; q < points.size(); ++q)
        {
          sample.F  = {F[q]};
          sample.dF = {dF[q]};
          sample.set_points({points[q]});
          for (unsigned int v = 0; v < state.size(); ++v)
            sample.moment.state[v] = {state[v][q]};
          sample.law->set_moment(sample.moment);
          const double energy = sample.energy(sample.F)[0];
          EXPECT_NEAR(energy, W[q], 1e-14 * (1 + std::abs(W[q])))
            << "the energy of a point depends on the points around it";
          EXPECT_LT(sample.distance(sample.stress(sample.F)[0], P[q]), 1e-14)
            << "the stress of a point depends on the points around it";
          EXPECT_LT(sample.distance(sample.stress_derivative(sample.dF)[0], dP[q]), 1e-14)
            << "dP of a point depends on the points around it";
        }
    });
  }


  /// All is finite at rest, and what was computed there is computed again.
  inline void
  check_rest(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      for (auto &F : sample.F)
        for (unsigned int i = 0; i < F.dimension; ++i)
          for (unsigned int k = 0; k < F[i].dimension; ++k)
            F[i][k] = i == k;
      const auto W  = sample.energy(sample.F);
      const auto P  = sample.stress(sample.F);
      const auto dP = sample.stress_derivative(sample.dF);
      for (unsigned int q = 0; q < W.size(); ++q)
        {
          EXPECT_TRUE(std::isfinite(W[q])) << "W is not finite at F = I";
          EXPECT_TRUE(std::isfinite(sample.product(P[q], P[q]))) << "P is not finite at F = I";
          EXPECT_TRUE(std::isfinite(sample.product(dP[q], dP[q]))) << "dP is not finite at F = I";
          EXPECT_EQ(sample.energy(sample.F)[q], W[q]) << "W is another when it is asked for again";
          EXPECT_EQ(sample.distance(sample.stress(sample.F)[q], P[q]), 0)
            << "P is another when it is asked for again";
        }
    });
  }


  /// A law that is defined where J > 0 alone says so, and the structure model asks; one that says
  /// nothing must have an energy everywhere.
  inline void
  check_domain(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      auto inverted = sample.F;
      for (auto &F : inverted)
        F[0] *= F.dimension == F[0].dimension ? -1. : 0.;
      if (sample.law->needs_positive_determinant())
        return;
      for (const double W : sample.energy(inverted))
        EXPECT_TRUE(std::isfinite(W))
          << "W is not finite where det F <= 0; say so by needs_positive_determinant()";
    });
  }


  /// Energy and stress change with time only where the law says so.
  inline void
  check_time(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      if (sample.law->time_dependent())
        return;
      const auto W          = sample.energy(sample.F);
      sample.moment.time    = .37;
      sample.moment.elapsed = .11;
      sample.law->set_moment(sample.moment);
      const auto later = sample.energy(sample.F);
      for (unsigned int q = 0; q < W.size(); ++q)
        EXPECT_EQ(later[q], W[q]) << "W changes with time; say so by time_dependent()";
    });
  }


  /// The state moves on once for each step, to what F makes it, and energy falls by that.
  inline void
  check_state(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      const auto W     = sample.energy(sample.F);
      const auto next  = sample.updated_state(sample.F);
      const auto again = sample.updated_state(sample.F);
      for (unsigned int v = 0; v < next.size(); ++v)
        for (unsigned int q = 0; q < W.size(); ++q)
          {
            EXPECT_TRUE(std::isfinite(next[v][q])) << "the state is not finite";
            EXPECT_EQ(again[v][q], next[v][q])
              << "the state is another when it is asked for again: update_state() must not change "
                 "the law";
            EXPECT_EQ(sample.energy(sample.F)[q], W[q])
              << "W is another after update_state(), though the state held is the same";
          }
      sample.moment.state = next;
      sample.law->set_moment(sample.moment);
      const auto less = sample.energy(sample.F);
      for (unsigned int q = 0; q < W.size(); ++q)
        EXPECT_LE(less[q], W[q] + 1e-12 * (1 + std::abs(W[q])))
          << "the energy grows when the state moves on: W(F) must be what is stored and what is "
             "dissipated on the way from the state held";
      const auto after = sample.updated_state(sample.F);
      for (unsigned int v = 0; v < next.size(); ++v)
        for (unsigned int q = 0; q < W.size(); ++q)
          EXPECT_NEAR(after[v][q], next[v][q], 1e-12 * (1 + std::abs(next[v][q])))
            << "the state moves on though neither F nor time does: is it counted twice?";
    });
  }


  /// The viscous stress is linear in the rate, has a potential, dissipates, and does not see
  /// rotations.
  inline void
  check_viscous_stress(const std::string &law, const std::string &block)
  {
    for_each_law(law, block, [](auto &sample) {
      auto other = sample.dF, sum = sample.dF, turning = sample.F;
      const auto Q = sample.rotation();
      auto skew    = Q - transpose(Q);
      auto turned = sample.F, turned_rate = sample.dF;
      for (unsigned int q = 0; q < other.size(); ++q)
        {
          for (unsigned int i = 0; i < other[q].dimension; ++i)
            for (unsigned int k = 0; k < other[q][i].dimension; ++k)
              other[q][i][k] = sample.random();
          for (unsigned int i = 0; i < other[q].dimension; ++i)
            sum[q][i] = 2. * sample.dF[q][i] + other[q][i];
          turning[q]     = sample.rotated(skew, sample.F[q]);
          turned[q]      = sample.rotated(Q, sample.F[q]);
          turned_rate[q] = sample.rotated(Q, sample.dF[q]);
        }
      const auto P = sample.viscous_stress(sample.F, sample.dF),
                 O = sample.viscous_stress(sample.F, other),
                 S = sample.viscous_stress(sample.F, sum),
                 T = sample.viscous_stress(sample.F, turning),
                 R = sample.viscous_stress(turned, turned_rate);
      for (unsigned int q = 0; q < P.size(); ++q)
        {
          const double size = 1 + std::sqrt(sample.product(P[q], P[q]));
          if (!sample.law->viscous())
            {
              EXPECT_EQ(sample.product(P[q], P[q]), 0)
                << "there is a viscous stress; say so by viscous()";
            }
          auto expected = P[q];
          expected *= 2.;
          expected += O[q];
          EXPECT_LT(sample.distance(S[q], expected), 1e-11 * size)
            << "the viscous stress is not linear in dF/dt";
          EXPECT_GE(sample.product(P[q], sample.dF[q]), -1e-12 * size)
            << "the viscous stress drives instead of damping: P : dF/dt < 0";
          EXPECT_NEAR(sample.product(P[q], other[q]),
                      sample.product(O[q], sample.dF[q]),
                      1e-11 * size)
            << "the viscous stress has no dissipation potential: P(A) : B is not P(B) : A";
          EXPECT_LT(std::sqrt(sample.product(T[q], T[q])), 1e-11 * size)
            << "the viscous stress resists a rotation of the whole";
          EXPECT_LT(sample.distance(R[q], sample.rotated(Q, P[q])), 1e-11 * size)
            << "the viscous stress depends on how the observer stands";
        }
    });
  }


  /// Every pair of dimensions that the law is offered for has an example.
  inline void
  check_examples(const std::string &law)
  {
    std::map<std::pair<int, int>, unsigned int> accepted;
    for_each_example<ConstitutiveLaw<2, 2>>(law, [&](const std::string &example) {
      for_each_law(law, example, [&](const auto &sample) {
        ++accepted[{sample.F[0][0].dimension, sample.F[0].dimension}];
      });
    });
    const auto expect = [&](const bool offered, const int structure_dim, const int dim) {
      EXPECT_TRUE(!offered || accepted.count({structure_dim, dim}) > 0)
        << "no example suits a structure of dimension " << structure_dim << " in dimension " << dim;
    };
    expect(registry().offers<ConstitutiveLaw<1, 2>>(law), 1, 2);
    expect(registry().offers<ConstitutiveLaw<2, 2>>(law), 2, 2);
    expect(registry().offers<ConstitutiveLaw<2, 3>>(law), 2, 3);
    expect(registry().offers<ConstitutiveLaw<3, 3>>(law), 3, 3);
  }


  /// What every constitutive law must keep, tried for each example of its schema, in each pair of
  /// dimensions that accepts the example. Include it in one source of a test program.
  class ConstitutiveLawKit : public ::testing::TestWithParam<std::string>
  {
  protected:
    template <typename Requirement>
    void
    for_examples(const Requirement &requirement) const
    {
      for_each_example<ConstitutiveLaw<2, 2>>(GetParam(), [&](const std::string &example) {
        requirement(GetParam(), example);
      });
    }
  };

  TEST_P(ConstitutiveLawKit, EveryDimensionHasAnExample)
  {
    check_examples(GetParam());
  }

  TEST_P(ConstitutiveLawKit, StressIsTheDerivativeOfTheEnergy)
  {
    for_examples(check_stress);
  }

  TEST_P(ConstitutiveLawKit, StressDerivativeIsTheDerivativeOfTheStress)
  {
    for_examples(check_stress_derivative);
  }

  TEST_P(ConstitutiveLawKit, LinearLawsHaveOneDerivative)
  {
    for_examples(check_linear);
  }

  TEST_P(ConstitutiveLawKit, StressDerivativeIsSymmetric)
  {
    for_examples(check_symmetry);
  }

  TEST_P(ConstitutiveLawKit, IsFrameIndifferent)
  {
    for_examples(check_frame_indifference);
  }

  TEST_P(ConstitutiveLawKit, ArraysGiveWhatPointsGive)
  {
    for_examples(check_arrays);
  }

  TEST_P(ConstitutiveLawKit, IsFiniteAtRest)
  {
    for_examples(check_rest);
  }

  TEST_P(ConstitutiveLawKit, SaysWhetherItDependsOnTime)
  {
    for_examples(check_time);
  }

  TEST_P(ConstitutiveLawKit, StateMovesOnAndDissipates)
  {
    for_examples(check_state);
  }

  TEST_P(ConstitutiveLawKit, ViscousStressDissipates)
  {
    for_examples(check_viscous_stress);
  }

  TEST_P(ConstitutiveLawKit, SaysWhereItIsNotDefined)
  {
    for_examples(check_domain);
  }
} // namespace feib::testing

/// Runs the conformance kit for the law of that name.
#define FEIB_TEST_CONSTITUTIVE_LAW(name) FEIB_TEST_CONSTITUTIVE_LAW_(name, __LINE__)
#define FEIB_TEST_CONSTITUTIVE_LAW_(name, line) FEIB_TEST_CONSTITUTIVE_LAW__(name, line)
#define FEIB_TEST_CONSTITUTIVE_LAW__(name, line)                           \
  namespace feib::testing                                                  \
  {                                                                        \
    INSTANTIATE_TEST_SUITE_P(Line##line,                                   \
                             ConstitutiveLawKit,                           \
                             ::testing::Values(std::string(name)),         \
                             [](const auto &info) { return info.param; }); \
  }                                                                        \
  static_assert(true, "")

#endif
