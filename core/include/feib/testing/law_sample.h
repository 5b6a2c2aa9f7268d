// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_law_sample_h
#define feib_testing_law_sample_h

#include <feib/constitutive_law.h>
#include <feib/error.h>
#include <feib/registry.h>
#include <feib/testing/findings.h>

#include <deal.II/base/derivative_form.h>

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

    LawSample(const Registry &registry,
              const std::string &name,
              const std::string &example,
              Findings &findings)
      : findings(findings)
      , law(registry.create<Law>(name, example))
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
        }
      set_gradients();
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

    /// Other deformation gradients and directions, within what the law says of tests.
    void
    set_gradients()
    {
      for (unsigned int q = 0; q < points.size(); ++q)
        do
          for (unsigned int i = 0; i < dim; ++i)
            for (unsigned int k = 0; k < structure_dim; ++k)
              {
                F[q][i][k]  = (i == k) + law->tested_strain() / .9 * random();
                dF[q][i][k] = law->tested_strain() / .9 * random();
              }
        while (dealii::DerivativeForm<1, structure_dim, dim>(F[q]).determinant() < .3);
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
      if (state.size() != moment.state.size())
        findings.add("the law has " + std::to_string(moment.state.size()) +
                     " state variables and gives " + std::to_string(state.size()));
      state.resize(moment.state.size());
      for (auto &values : state)
        {
          check_size(values.size());
          values.resize(F.size());
        }
      return state;
    }

    std::vector<Matrix>
    viscous_stress(const std::vector<Matrix> &F, const std::vector<Matrix> &rate) const
    {
      std::vector<Matrix> P(F.size());
      law->viscous_stress(F, rate, P);
      check_size(P.size());
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
      std::vector<double> W(F.size());
      law->energy(F, W);
      check_size(W.size());
      W.resize(F.size());
      return W;
    }

    std::vector<Matrix>
    stress(const std::vector<Matrix> &F) const
    {
      std::vector<Matrix> P(F.size());
      law->stress(F, P);
      check_size(P.size());
      P.resize(F.size());
      return P;
    }

    std::vector<Matrix>
    stress_derivative(const std::vector<Matrix> &dF) const
    {
      std::vector<Matrix> dP(F.size());
      law->stress_derivative(F, dF, dP);
      check_size(dP.size());
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

    Findings &findings;
    std::mt19937 generator;
    std::unique_ptr<Law> law;
    typename Law::Moment moment; // what the law is told
    std::vector<typename Law::MaterialPoint> points;
    std::vector<Matrix> F, dF;

  private:
    void
    check_size(const std::size_t size) const
    {
      if (size != F.size())
        findings.add("the law gives " + std::to_string(size) + " values at " +
                     std::to_string(F.size()) + " points: there must be one value for each point");
    }
  };


  namespace internal
  {
    template <int structure_dim, int dim, typename Check>
    void
    with_law(const Registry &registry,
             const std::string &name,
             const std::string &example,
             const Check &check,
             Findings &findings,
             std::string &refusal)
    {
      if (!registry.offers<ConstitutiveLaw<structure_dim, dim>>(name))
        return;
      findings.place = "a structure of dimension " + std::to_string(structure_dim) +
                       " in dimension " + std::to_string(dim) + ", example " + example + ": ";
      findings.run([&] {
        std::unique_ptr<LawSample<structure_dim, dim>> sample;
        try
          {
            sample =
              std::make_unique<LawSample<structure_dim, dim>>(registry, name, example, findings);
          }
        catch (const Error &error)
          {
            refusal = error.issues().front().pointer + ": " + error.issues().front().message;
            return;
          }
        check(*sample);
      });
    }
  } // namespace internal


  /// Calls @p check with a sample of the law in every pair of dimensions it is offered for, and
  /// returns what was found; what is thrown is found too. An example may be refused in some pairs:
  /// fibres need as many components as the space has dimensions. That it is in all is found too.
  template <typename Check>
  Findings
  for_each_law(const Registry &registry,
               const std::string &name,
               const std::string &example,
               const Check &check)
  {
    Findings findings;
    bool accepted = false;
    std::string refusal;
    const auto check_accepted = [&](auto &sample) {
      accepted = true;
      check(sample);
    };
    internal::with_law<1, 2>(registry, name, example, check_accepted, findings, refusal);
    internal::with_law<2, 2>(registry, name, example, check_accepted, findings, refusal);
    internal::with_law<2, 3>(registry, name, example, check_accepted, findings, refusal);
    internal::with_law<3, 3>(registry, name, example, check_accepted, findings, refusal);
    findings.place = "";
    if (!accepted && !refusal.empty())
      findings.add("the example " + example + " is refused in every dimension: " + refusal);
    return findings;
  }
} // namespace feib::testing

#endif
