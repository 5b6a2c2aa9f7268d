// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_constitutive_law_kit_h
#define feib_testing_constitutive_law_kit_h

#include <feib/constitutive_law.h>
#include <feib/schema.h>
#include <feib/testing/derivative.h>
#include <feib/testing/plugins.h>

#include <deal.II/base/derivative_form.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace feib::testing
{
  /// What every constitutive law must keep, tried for each example of its schema, in each pair of
  /// dimensions that accepts the example. Include it in one source of a test program.
  class ConstitutiveLawKit : public ::testing::TestWithParam<std::string>
  {
  protected:
    /// A law made from an example, with random material points and deformation gradients there.
    template <int structure_dim, int dim>
    struct Sample
    {
      using Law    = ConstitutiveLaw<structure_dim, dim>;
      using Matrix = typename Law::Matrix;

      Sample(const std::string &name, const std::string &example)
        : law(registry().create<Law>(name, example))
        , points(8)
        , F(points.size())
        , dF(points.size())
      {
        for (unsigned int q = 0; q < points.size(); ++q)
          {
            points[q].material_id = q % 2;
            for (unsigned int i = 0; i < dim; ++i)
              points[q].place[i] = random();
            const dealii::Tensor<2, dim> Q = rotation();
            for (unsigned int k = 0; k < structure_dim; ++k)
              for (unsigned int i = 0; i < dim; ++i)
                points[q].frame[k][i] = structure_dim == dim ? i == k : Q[i][k];
            do
              for (unsigned int i = 0; i < dim; ++i)
                for (unsigned int k = 0; k < structure_dim; ++k)
                  {
                    F[q][i][k]  = (i == k) + law->tested_strain() / .9 * random();
                    dF[q][i][k] = law->tested_strain() / .9 * random();
                  }
            while (dealii::DerivativeForm<1, structure_dim, dim>(F[q]).determinant() < .3);
          }
        law->set_points(points);
      }

      double
      random()
      {
        return std::uniform_real_distribution<double>(-.9, .9)(generator);
      }

      dealii::Tensor<2, dim>
      rotation()
      {
        dealii::Tensor<2, dim> Q;
        for (unsigned int k = 0; k < dim; ++k)
          {
            for (unsigned int i = 0; i < dim; ++i)
              Q[k][i] = random();
            for (unsigned int l = 0; l < k; ++l)
              Q[k] -= (Q[k] * Q[l]) * Q[l];
            Q[k] /= Q[k].norm();
          }
        if (determinant(Q) < 0)
          Q[0] *= -1;
        return Q;
      }

      std::vector<Matrix>
      moved(const double h) const
      {
        std::vector<Matrix> result = F;
        for (unsigned int q = 0; q < F.size(); ++q)
          for (unsigned int i = 0; i < dim; ++i)
            result[q][i] += h * dF[q][i];
        return result;
      }

      std::vector<double>
      energy(const std::vector<Matrix> &F) const
      {
        std::vector<double> W;
        law->energy(F, W);
        EXPECT_EQ(W.size(), F.size());
        return W;
      }

      std::vector<Matrix>
      stress(const std::vector<Matrix> &F) const
      {
        std::vector<Matrix> P;
        law->stress(F, P);
        EXPECT_EQ(P.size(), F.size());
        return P;
      }

      std::vector<Matrix>
      stress_derivative(const std::vector<Matrix> &dF) const
      {
        std::vector<Matrix> dP;
        law->stress_derivative(F, dF, dP);
        EXPECT_EQ(dP.size(), F.size());
        return dP;
      }

      static double
      product(const Matrix &A, const Matrix &B)
      {
        double sum = 0;
        for (unsigned int i = 0; i < dim; ++i)
          sum += A[i] * B[i];
        return sum;
      }

      static double
      distance(const Matrix &A, const Matrix &B)
      {
        double sum = 0;
        for (unsigned int i = 0; i < dim; ++i)
          sum += (A[i] - B[i]).norm_square();
        return std::sqrt(sum);
      }

      static Matrix
      rotated(const dealii::Tensor<2, dim> &Q, const Matrix &A)
      {
        Matrix result;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            result[i] += Q[i][j] * A[j];
        return result;
      }

      std::mt19937 generator;
      std::unique_ptr<Law> law;
      std::vector<typename Law::MaterialPoint> points;
      std::vector<Matrix> F, dF;
    };

    /// Calls @p check with a sample of every example in every pair of dimensions.
    template <typename Check>
    void
    for_each_sample(const Check &check) const
    {
      in_dimensions<1, 2>(check);
      in_dimensions<2, 2>(check);
      in_dimensions<2, 3>(check);
      in_dimensions<3, 3>(check);
    }

  private:
    /// An example may be refused (fibres need as many components as the space has dimensions), but
    /// not every one, where the law is offered.
    template <int structure_dim, int dim, typename Check>
    void
    in_dimensions(const Check &check) const
    {
      if (!registry().offers<ConstitutiveLaw<structure_dim, dim>>(GetParam()))
        return;
      unsigned int accepted = 0;
      std::string refusal;
      for (const std::string &example : examples())
        {
          SCOPED_TRACE("a structure of dimension " + std::to_string(structure_dim) +
                       " in dimension " + std::to_string(dim) + ", example " + example);
          std::unique_ptr<Sample<structure_dim, dim>> sample;
          try
            {
              sample = std::make_unique<Sample<structure_dim, dim>>(GetParam(), example);
            }
          catch (const Error &error)
            {
              refusal = error.what();
              continue;
            }
          ++accepted;
          check(*sample);
        }
      EXPECT_GT(accepted, 0u) << "no example suits a structure of dimension " << structure_dim
                              << " in dimension " << dim << ": " << refusal;
    }

    std::vector<std::string>
    examples() const
    {
      for (const Registry::Entry &entry : registry().entries())
        if (entry.kind == ConstitutiveLaw<2, 2>::kind && entry.name == GetParam())
          return Schema(entry.schema).examples();
      ADD_FAILURE() << "there is no constitutive law " << GetParam();
      return {};
    }
  };

  TEST_P(ConstitutiveLawKit, StressIsTheDerivativeOfTheEnergy)
  {
    for_each_sample([](const auto &sample) {
      const auto P = sample.stress(sample.F);
      for (unsigned int q = 0; q < P.size(); ++q)
        {
          const double expected =
            derivative([&](const double h) { return sample.energy(sample.moved(h))[q]; });
          EXPECT_NEAR(sample.product(P[q], sample.dF[q]),
                      expected,
                      1e-7 * (1 + std::abs(expected)));
        }
    });
  }

  TEST_P(ConstitutiveLawKit, StressDerivativeIsTheDerivativeOfTheStress)
  {
    for_each_sample([](const auto &sample) {
      const auto dP = sample.stress_derivative(sample.dF);
      for (unsigned int q = 0; q < dP.size(); ++q)
        for (unsigned int i = 0; i < dP[q].dimension; ++i)
          {
            const auto expected =
              derivative([&](const double h) { return sample.stress(sample.moved(h))[q][i]; });
            EXPECT_LT((dP[q][i] - expected).norm(), 1e-7 * (1 + expected.norm()));
          }
    });
  }

  TEST_P(ConstitutiveLawKit, LinearLawsHaveOneDerivative)
  {
    for_each_sample([](auto &sample) {
      if (!sample.law->linear())
        return;
      const auto before = sample.stress_derivative(sample.dF);
      sample.F          = sample.moved(.1);
      const auto after  = sample.stress_derivative(sample.dF);
      for (unsigned int q = 0; q < before.size(); ++q)
        for (unsigned int i = 0; i < before[q].dimension; ++i)
          EXPECT_LT((before[q][i] - after[q][i]).norm(), 1e-13 * (1 + before[q][i].norm()));
    });
  }

  TEST_P(ConstitutiveLawKit, StressDerivativeIsSymmetric)
  {
    for_each_sample([](auto &sample) {
      auto other = sample.dF;
      for (auto &matrix : other)
        for (unsigned int i = 0; i < matrix.dimension; ++i)
          for (unsigned int k = 0; k < matrix[i].dimension; ++k)
            matrix[i][k] = sample.random();
      const auto dP = sample.stress_derivative(sample.dF), dQ = sample.stress_derivative(other);
      for (unsigned int q = 0; q < dP.size(); ++q)
        {
          const double expected = sample.product(dQ[q], sample.dF[q]);
          EXPECT_NEAR(sample.product(dP[q], other[q]), expected, 1e-12 * (1 + std::abs(expected)));
        }
    });
  }

  TEST_P(ConstitutiveLawKit, IsFrameIndifferent)
  {
    for_each_sample([](auto &sample) {
      const auto Q = sample.rotation();
      auto rotated = sample.F;
      for (auto &F : rotated)
        F = sample.rotated(Q, F);
      const auto W = sample.energy(sample.F), W_rotated = sample.energy(rotated);
      const auto P = sample.stress(sample.F), P_rotated = sample.stress(rotated);
      for (unsigned int q = 0; q < W.size(); ++q)
        {
          EXPECT_NEAR(W_rotated[q], W[q], 1e-12 * (1 + std::abs(W[q])));
          EXPECT_LT(sample.distance(P_rotated[q], sample.rotated(Q, P[q])),
                    1e-12 * (1 + std::sqrt(sample.product(P[q], P[q]))));
        }
    });
  }

  TEST_P(ConstitutiveLawKit, ArraysGiveWhatPointsGive)
  {
    for_each_sample([](auto &sample) {
      const auto W      = sample.energy(sample.F);
      const auto P      = sample.stress(sample.F);
      const auto dP     = sample.stress_derivative(sample.dF);
      const auto points = sample.points, F = sample.F, dF = sample.dF;
      for (unsigned int q = 0; q < points.size(); ++q)
        {
          sample.F  = {F[q]};
          sample.dF = {dF[q]};
          sample.law->set_points({points[q]});
          EXPECT_DOUBLE_EQ(sample.energy(sample.F)[0], W[q]);
          EXPECT_LT(sample.distance(sample.stress(sample.F)[0], P[q]), 1e-14);
          EXPECT_LT(sample.distance(sample.stress_derivative(sample.dF)[0], dP[q]), 1e-14);
        }
    });
  }

  // A law that is defined where J > 0 alone says so, and the structure model asks; one that says
  // nothing must have an energy everywhere.
  TEST_P(ConstitutiveLawKit, SaysWhereItIsNotDefined)
  {
    for_each_sample([](auto &sample) {
      auto inverted = sample.F;
      for (auto &F : inverted)
        F[0] *= F.dimension == F[0].dimension ? -1. : 0.;
      if (sample.law->needs_positive_determinant())
        return;
      for (const double W : sample.energy(inverted))
        EXPECT_TRUE(std::isfinite(W));
    });
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
