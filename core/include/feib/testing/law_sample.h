// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_law_sample_h
#define feib_testing_law_sample_h

#include <feib/constitutive_law.h>
#include <feib/error.h>
#include <feib/testing/plugins.h>

#include <deal.II/base/derivative_form.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace feib::testing
{
  /// A law made from an example, with random material points and deformation gradients there.
  template <int structure_dim, int dim>
  struct LawSample
  {
    using Law    = ConstitutiveLaw<structure_dim, dim>;
    using Matrix = typename Law::Matrix;

    LawSample(const std::string &name, const std::string &example)
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
      set_points(points);
      if (!moment.state.empty())
        {
          // The state of another deformation, so that it means something.
          auto before = F;
          for (Matrix &matrix : before)
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int k = 0; k < structure_dim; ++k)
                matrix[i][k] = (i == k) + law->tested_strain() / 2 * random();
          moment.state = updated_state(before);
          law->set_moment(moment);
        }
    }

    /// Other points, with their initial state.
    void
    set_points(const std::vector<typename Law::MaterialPoint> &new_points)
    {
      points = new_points;
      law->set_points(points);
      moment = {};
      for (const auto &variable : law->state_variables())
        moment.state.emplace_back(points.size(), variable.initial);
      law->set_moment(moment);
    }

    /// The state after a step that ends with @p F.
    std::vector<std::vector<double>>
    updated_state(const std::vector<Matrix> &F) const
    {
      auto state = moment.state;
      law->update_state(F, state);
      EXPECT_EQ(state.size(), moment.state.size()) << "one array for each state variable";
      state.resize(moment.state.size());
      for (auto &values : state)
        {
          EXPECT_EQ(values.size(), F.size()) << "one value for each point";
          values.resize(F.size());
        }
      return state;
    }

    std::vector<Matrix>
    viscous_stress(const std::vector<Matrix> &F, const std::vector<Matrix> &rate) const
    {
      std::vector<Matrix> P;
      law->viscous_stress(F, rate, P);
      EXPECT_EQ(P.size(), F.size()) << "one value for each point";
      P.resize(F.size());
      return P;
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
      EXPECT_EQ(W.size(), F.size()) << "one value for each point";
      W.resize(F.size());
      return W;
    }

    std::vector<Matrix>
    stress(const std::vector<Matrix> &F) const
    {
      std::vector<Matrix> P;
      law->stress(F, P);
      EXPECT_EQ(P.size(), F.size()) << "one value for each point";
      P.resize(F.size());
      return P;
    }

    std::vector<Matrix>
    stress_derivative(const std::vector<Matrix> &dF) const
    {
      std::vector<Matrix> dP;
      law->stress_derivative(F, dF, dP);
      EXPECT_EQ(dP.size(), F.size()) << "one value for each point";
      dP.resize(F.size());
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
    typename Law::Moment moment; // what the law is told
    std::vector<typename Law::MaterialPoint> points;
    std::vector<Matrix> F, dF;
  };


  namespace internal
  {
    template <int structure_dim, int dim, typename Check>
    void
    with_law(const std::string &name, const std::string &example, const Check &check)
    {
      if (!registry().offers<ConstitutiveLaw<structure_dim, dim>>(name))
        return;
      SCOPED_TRACE("a structure of dimension " + std::to_string(structure_dim) + " in dimension " +
                   std::to_string(dim) + ", example " + example);
      std::unique_ptr<LawSample<structure_dim, dim>> sample;
      try
        {
          sample = std::make_unique<LawSample<structure_dim, dim>>(name, example);
        }
      catch (const Error &)
        {
          return;
        }
      check(*sample);
    }
  } // namespace internal


  /// Calls @p check with a sample of the law in every pair of dimensions it is offered for. An
  /// example may be refused in some: fibres need as many components as the space has dimensions.
  template <typename Check>
  void
  for_each_law(const std::string &name, const std::string &example, const Check &check)
  {
    internal::with_law<1, 2>(name, example, check);
    internal::with_law<2, 2>(name, example, check);
    internal::with_law<2, 3>(name, example, check);
    internal::with_law<3, 3>(name, example, check);
  }
} // namespace feib::testing

#endif
