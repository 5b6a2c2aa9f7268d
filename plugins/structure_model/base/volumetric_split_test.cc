// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/structure_model/volumetric_split.h>
#include <feib/testing/constitutive_law_kit.h>

namespace feib::testing
{
  // The laws themselves have their own tests.
  GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ConstitutiveLawKit);
  GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ConstitutiveLawExamples);

  /// The samples of the kit for bodies, with the law split.
  class VolumetricSplitTest : public ::testing::TestWithParam<std::string>
  {
  protected:
    template <typename Check>
    void
    for_each_split(const bool deviatoric, const double k, const Check &check) const
    {
      SCOPED_TRACE("deviatoric: " + std::to_string(deviatoric) + ", k = " + std::to_string(k));
      const auto split = [&](auto &sample) {
        constexpr int dim           = std::decay_t<decltype(sample.F[0])>::dimension;
        constexpr int structure_dim = std::decay_t<decltype(sample.F[0][0])>::dimension;
        if constexpr (structure_dim == dim)
          {
            sample.law =
              std::make_unique<VolumetricSplit<dim>>(std::move(sample.law), deviatoric, k);
            sample.law->set_points(sample.points);
            check(sample);
          }
      };
      for_each_example<ConstitutiveLaw<2, 2>>(GetParam(), [&](const std::string &example) {
        expect_none(for_each_law(registry(), GetParam(), example, split));
      });
    }

    template <typename Check>
    void
    for_each_split(const Check &check) const
    {
      for_each_split(true, 0, check);
      for_each_split(false, 3, check);
      for_each_split(true, 3, check);
    }
  };

  TEST_P(VolumetricSplitTest, StressIsTheDerivativeOfTheEnergy)
  {
    for_each_split([](const auto &sample) {
      EXPECT_TRUE(sample.law->needs_positive_determinant());
      EXPECT_FALSE(sample.law->linear());
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

  TEST_P(VolumetricSplitTest, StressDerivativeIsTheDerivativeOfTheStress)
  {
    for_each_split([](const auto &sample) {
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

  // So the pressure of the body is that of the volumetric part alone: P : F = dim k ln J.
  TEST_P(VolumetricSplitTest, DeviatoricEnergyDoesNotSeeTheVolume)
  {
    for_each_split(true, 0, [](const auto &sample) {
      auto larger = sample.F;
      for (auto &F : larger)
        F *= 1.7;
      const auto W = sample.energy(sample.F), W_larger = sample.energy(larger);
      const auto P = sample.stress(sample.F);
      for (unsigned int q = 0; q < W.size(); ++q)
        {
          EXPECT_NEAR(W_larger[q], W[q], 1e-12 * (1 + std::abs(W[q])));
          EXPECT_NEAR(sample.product(P[q], sample.F[q]),
                      0,
                      1e-12 * (1 + std::sqrt(sample.product(P[q], P[q]))));
        }
    });
  }

  INSTANTIATE_TEST_SUITE_P(Laws,
                           VolumetricSplitTest,
                           ::testing::Values("anisotropic_linear",
                                             "neo_hookean",
                                             "mooney_rivlin_fibres"),
                           [](const auto &info) { return info.param; });

  namespace
  {
    /// A neo-Hookean law of one point, split.
    template <int dim>
    std::unique_ptr<ConstitutiveLaw<dim, dim>>
    make_law(const std::string &parameters, const bool deviatoric, const double k)
    {
      using Law = ConstitutiveLaw<dim, dim>;
      auto law =
        std::make_unique<VolumetricSplit<dim>>(registry().create<Law>("neo_hookean", parameters),
                                               deviatoric,
                                               k);
      law->set_points(std::vector<typename Law::MaterialPoint>(1));
      return law;
    }

    template <int dim>
    dealii::Tensor<2, dim>
    stress(const ConstitutiveLaw<dim, dim> &law, const dealii::Tensor<2, dim> &F)
    {
      std::vector<typename ConstitutiveLaw<dim, dim>::Matrix> F_of_point(1), P;
      for (unsigned int i = 0; i < dim; ++i)
        F_of_point[0][i] = F[i];
      law.stress(F_of_point, P);
      dealii::Tensor<2, dim> result;
      for (unsigned int i = 0; i < dim; ++i)
        result[i] = P[0][i];
      return result;
    }

    /// A rotation in the plane of the first two axes, times @p size.
    template <int dim>
    dealii::Tensor<2, dim>
    turned(const double size, const double angle)
    {
      dealii::Tensor<2, dim> F = dealii::unit_symmetric_tensor<dim>();
      F[0][0] = F[1][1] = std::cos(angle);
      F[0][1]           = -std::sin(angle);
      F[1][0]           = std::sin(angle);
      return size * F;
    }

    template <int dim>
    void
    no_stress_where_the_shape_is_kept()
    {
      for (const char *const parameters :
           {R"({"shear_modulus": 3})", R"({"shear_modulus": 3, "stress_free": true})"})
        {
          const auto law = make_law<dim>(parameters, true, 0);
          EXPECT_EQ(stress(*law, turned<dim>(1, 0)).norm(), 0);
          EXPECT_LT(stress(*law, turned<dim>(.6, 1)).norm(), 1e-14);
          EXPECT_LT(stress(*law, turned<dim>(2.5, -2)).norm(), 1e-14);
          // The volumetric part adds k ln J F^-T.
          const auto both = make_law<dim>(parameters, true, 7);
          const auto F    = turned<dim>(2.5, -2);
          EXPECT_LT((stress(*both, F) - 7 * std::log(determinant(F)) * transpose(invert(F))).norm(),
                    1e-13);
          EXPECT_EQ(stress(*both, turned<dim>(1, 0)).norm(), 0);
        }
    }
  } // namespace

  TEST(VolumetricSplit, NoStressWhereTheShapeIsKept)
  {
    no_stress_where_the_shape_is_kept<2>();
    no_stress_where_the_shape_is_kept<3>();
  }

  // J^(-1/d) F enters W: in the plane |F|^2/J instead of |F|^2.
  TEST(VolumetricSplit, NeoHookeanInThePlane)
  {
    const double mu = 3;
    const dealii::Tensor<2, 2> F({{1.2, .3}, {-.4, .7}}), G = transpose(invert(F));
    const double J                      = determinant(F);
    const dealii::Tensor<2, 2> expected = mu * (F / J - F.norm_square() / (2 * J) * G);
    EXPECT_LT((stress(*make_law<2>(R"({"shear_modulus": 3})", true, 0), F) - expected).norm(),
              1e-14);
    // ln det (J^(-1/d) F) = 0: with the stress-free term, the same.
    EXPECT_LT((stress(*make_law<2>(R"({"shear_modulus": 3, "stress_free": true})", true, 0), F) -
               expected)
                .norm(),
              1e-14);
    // Without the deviatoric part, k ln J F^-T is added to the law as it is.
    EXPECT_LT((stress(*make_law<2>(R"({"shear_modulus": 3})", false, 7), F) -
               (mu * F + 7 * std::log(J) * G))
                .norm(),
              1e-14);
  }
} // namespace feib::testing
