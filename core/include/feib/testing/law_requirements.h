// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_law_requirements_h
#define feib_testing_law_requirements_h

#include <feib/schema.h>
#include <feib/testing/derivative.h>
#include <feib/testing/law_sample.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <set>
#include <sstream>

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
  inline Findings
  check_stress(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](const auto &sample) {
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
      std::ostringstream text;
      text.precision(4);
      text << "P is not dW/dF: over all points P : dF is " << product / square
           << " times the change of W; 2 or 0.5 is often forgotten in P = 2 F dW/dC, -1 is a sign, "
              "others mean a term that is missing, or transposed";
      for (unsigned int q = 0; q < P.size(); ++q)
        {
          const double power = sample.product(P[q], sample.dF[q]);
          sample.findings.below(
            error_of_derivative([&](const double h) { return sample.energy(sample.moved(h))[q]; },
                                [&](const double expected) {
                                  return std::abs(power - expected) / (1 + std::abs(expected));
                                }),
            1e-7,
            text.str());
        }
    });
  }


  /// dP = dP/dF [dF].
  inline Findings
  check_stress_derivative(const Registry &registry,
                          const std::string &law,
                          const std::string &block)
  {
    return for_each_law(registry, law, block, [](const auto &sample) {
      const auto dP = sample.stress_derivative(sample.dF);
      for (unsigned int q = 0; q < dP.size(); ++q)
        for (unsigned int i = 0; i < dP[q].dimension; ++i)
          sample.findings.below(
            error_of_derivative([&](
                                  const double h) { return sample.stress(sample.moved(h))[q][i]; },
                                [&](const auto &expected) {
                                  return (dP[q][i] - expected).norm() / (1 + expected.norm());
                                }),
            1e-7,
            "dP is not the derivative of P along dF");
    });
  }


  /// A law that says it is linear has one derivative everywhere.
  inline Findings
  check_linear(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      if (!sample.law->linear())
        return;
      const auto before = sample.stress_derivative(sample.dF);
      sample.F          = sample.moved(.1);
      const auto after  = sample.stress_derivative(sample.dF);
      for (unsigned int q = 0; q < before.size(); ++q)
        for (unsigned int i = 0; i < before[q].dimension; ++i)
          sample.findings.below((before[q][i] - after[q][i]).norm(),
                                1e-13 * (1 + before[q][i].norm()),
                                "linear() is true, but dP depends on F");
    });
  }


  /// dP is a second derivative.
  inline Findings
  check_symmetry(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      auto other = sample.dF;
      for (auto &matrix : other)
        for (unsigned int i = 0; i < matrix.dimension; ++i)
          for (unsigned int k = 0; k < matrix[i].dimension; ++k)
            matrix[i][k] = sample.random();
      const auto dP = sample.stress_derivative(sample.dF), dQ = sample.stress_derivative(other);
      for (unsigned int q = 0; q < dP.size(); ++q)
        {
          const double expected = sample.product(dQ[q], sample.dF[q]);
          sample.findings.below(std::abs(sample.product(dP[q], other[q]) - expected),
                                1e-12 * (1 + std::abs(expected)),
                                "dP(F)[dF] : dG is not dP(F)[dG] : dF: no second derivative of an "
                                "energy");
        }
    });
  }


  /// W(Q F) = W(F), P(Q F) = Q P(F) for rotations Q; then the stress of Cauchy is symmetric.
  inline Findings
  check_frame_indifference(const Registry &registry,
                           const std::string &law,
                           const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      const auto Q = sample.rotation();
      auto rotated = sample.F;
      for (auto &F : rotated)
        F = sample.rotated(Q, F);
      const auto W = sample.energy(sample.F), W_rotated = sample.energy(rotated);
      const auto P = sample.stress(sample.F), P_rotated = sample.stress(rotated);
      for (unsigned int q = 0; q < W.size(); ++q)
        {
          sample.findings.below(std::abs(W_rotated[q] - W[q]),
                                1e-12 * (1 + std::abs(W[q])),
                                "W(Q F) is not W(F): the energy depends on how the observer "
                                "stands; write it in terms of C = F^T F");
          sample.findings.below(sample.distance(P_rotated[q], sample.rotated(Q, P[q])),
                                1e-12 * (1 + std::sqrt(sample.product(P[q], P[q]))),
                                "P(Q F) is not Q P(F): the stress depends on how the observer "
                                "stands");
        }
    });
  }


  /// What a point gives depends neither on the other points nor on its place among them.
  inline Findings
  check_arrays(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
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
          sample.findings.below(std::abs(sample.energy(sample.F)[0] - W[q]),
                                1e-14 * (1 + std::abs(W[q])),
                                "the energy of a point depends on the points around it");
          sample.findings.below(sample.distance(sample.stress(sample.F)[0], P[q]),
                                1e-14,
                                "the stress of a point depends on the points around it");
          sample.findings.below(sample.distance(sample.stress_derivative(sample.dF)[0], dP[q]),
                                1e-14,
                                "dP of a point depends on the points around it");
        }
    });
  }


  /// All is finite at rest, and what was computed there is computed again.
  inline Findings
  check_rest(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      for (auto &F : sample.F)
        for (unsigned int i = 0; i < F.dimension; ++i)
          for (unsigned int k = 0; k < F[i].dimension; ++k)
            F[i][k] = i == k;
      const auto W  = sample.energy(sample.F);
      const auto P  = sample.stress(sample.F);
      const auto dP = sample.stress_derivative(sample.dF);
      for (unsigned int q = 0; q < W.size(); ++q)
        {
          sample.findings.expect(std::isfinite(W[q]), "W is not finite at F = I");
          sample.findings.expect(std::isfinite(sample.product(P[q], P[q])),
                                 "P is not finite at F = I");
          sample.findings.expect(std::isfinite(sample.product(dP[q], dP[q])),
                                 "dP is not finite at F = I");
          sample.findings.expect(sample.energy(sample.F)[q] == W[q],
                                 "W is another when it is asked for again");
          sample.findings.expect(sample.distance(sample.stress(sample.F)[q], P[q]) == 0,
                                 "P is another when it is asked for again");
        }
    });
  }


  /// A law that is defined where J > 0 alone says so, and the structure model asks; one that says
  /// nothing must have an energy everywhere.
  inline Findings
  check_domain(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      auto inverted = sample.F;
      for (auto &F : inverted)
        F[0] *= F.dimension == F[0].dimension ? -1. : 0.;
      if (sample.law->needs_positive_determinant())
        return;
      for (const double W : sample.energy(inverted))
        if (!std::isfinite(W))
          sample.findings.add(
            "W is not finite where det F <= 0; say so by needs_positive_determinant()");
    });
  }


  /// Energy and stress change with time only where the law says so.
  inline Findings
  check_time(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      if (sample.law->time_dependent())
        return;
      const auto W          = sample.energy(sample.F);
      sample.moment.time    = .37;
      sample.moment.elapsed = .11;
      sample.law->set_moment(sample.moment);
      const auto later = sample.energy(sample.F);
      for (unsigned int q = 0; q < W.size(); ++q)
        sample.findings.expect(later[q] == W[q], "W changes with time; say so by time_dependent()");
    });
  }


  /// The state moves on once for each step, to what F makes it, and energy falls by that.
  inline Findings
  check_state(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      Findings &findings = sample.findings;
      const auto W       = sample.energy(sample.F);
      const auto next    = sample.updated_state(sample.F);
      const auto again   = sample.updated_state(sample.F);
      for (unsigned int v = 0; v < next.size(); ++v)
        for (unsigned int q = 0; q < W.size(); ++q)
          {
            findings.expect(std::isfinite(next[v][q]), "the state is not finite");
            findings.expect(again[v][q] == next[v][q],
                            "the state is another when it is asked for again: update_state() must "
                            "not change the law");
            findings.expect(sample.energy(sample.F)[q] == W[q],
                            "W is another after update_state(), though the state held is the same");
          }
      sample.moment.state = next;
      sample.law->set_moment(sample.moment);
      const auto less = sample.energy(sample.F);
      for (unsigned int q = 0; q < W.size(); ++q)
        findings.below(less[q] - W[q],
                       1e-12 * (1 + std::abs(W[q])),
                       "the energy grows when the state moves on: W(F) must be what is stored and "
                       "what is dissipated on the way from the state held");
      const auto after = sample.updated_state(sample.F);
      for (unsigned int v = 0; v < next.size(); ++v)
        for (unsigned int q = 0; q < W.size(); ++q)
          findings.below(std::abs(after[v][q] - next[v][q]),
                         1e-12 * (1 + std::abs(next[v][q])),
                         "the state moves on though neither F nor time does: is it counted twice?");
    });
  }


  /// The viscous stress is linear in the rate, has a potential, dissipates, and does not see
  /// rotations.
  inline Findings
  check_viscous_stress(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      Findings &findings = sample.findings;
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
          findings.expect(sample.law->viscous() || sample.product(P[q], P[q]) == 0,
                          "there is a viscous stress; say so by viscous()");
          auto expected = P[q];
          expected *= 2.;
          expected += O[q];
          findings.below(sample.distance(S[q], expected),
                         1e-11 * size,
                         "the viscous stress is not linear in dF/dt");
          findings.below(-sample.product(P[q], sample.dF[q]),
                         1e-12 * size,
                         "the viscous stress drives instead of damping: P : dF/dt < 0");
          findings.below(
            std::abs(sample.product(P[q], other[q]) - sample.product(O[q], sample.dF[q])),
            1e-11 * size,
            "the viscous stress has no dissipation potential: P(A) : B is not P(B) : A");
          findings.below(std::sqrt(sample.product(T[q], T[q])),
                         1e-11 * size,
                         "the viscous stress resists a rotation of the whole");
          findings.below(sample.distance(R[q], sample.rotated(Q, P[q])),
                         1e-11 * size,
                         "the viscous stress depends on how the observer stands");
        }
    });
  }


  /// Something resists: along some axis the energy of some point grows when it is stretched, and
  /// squeezed across by as much as keeps the measure.
  inline Findings
  check_resistance(const Registry &registry, const std::string &law, const std::string &block)
  {
    return for_each_law(registry, law, block, [](auto &sample) {
      constexpr unsigned int m  = std::decay_t<decltype(sample.F[0][0])>::dimension;
      const double stretch      = 1 + sample.law->tested_strain() / 2;
      const auto with_stretches = [&](const double along, const double across, unsigned int axis) {
        for (auto &F : sample.F)
          for (unsigned int i = 0; i < F.dimension; ++i)
            for (unsigned int k = 0; k < m; ++k)
              F[i][k] = i != k ? 0. : k == axis ? along : across;
        return sample.energy(sample.F);
      };
      const auto rest = with_stretches(1, 1, 0);
      for (unsigned int axis = 0; axis < m; ++axis)
        {
          const auto W =
            with_stretches(stretch, m == 1 ? 1. : std::pow(stretch, -1. / (m - 1)), axis);
          for (unsigned int q = 0; q < W.size(); ++q)
            if (W[q] > rest[q])
              return;
        }
      sample.findings.add("W falls, or stays, when the material is stretched, at every point and "
                          "along every axis; are energy and stress negative?");
    });
  }


  /// What every constitutive law must keep, for each example of its schema, in each pair of
  /// dimensions that accepts the example.
  struct LawRequirement
  {
    const char *name;     // as the name of a test
    const char *sentence; // in words
    Findings (*check)(const Registry &registry, const std::string &law, const std::string &block);

    friend std::ostream &
    operator<<(std::ostream &stream, const LawRequirement &requirement)
    {
      return stream << requirement.sentence;
    }
  };

  inline const std::vector<LawRequirement> law_requirements = {
    {"StressIsTheDerivativeOfTheEnergy", "P = dW/dF", check_stress},
    {"StressDerivativeIsTheDerivativeOfTheStress", "dP = dP/dF [dF]", check_stress_derivative},
    {"LinearLawsHaveOneDerivative", "dP is constant where the law says it is", check_linear},
    {"StressDerivativeIsSymmetric", "dP is a second derivative", check_symmetry},
    {"IsFrameIndifferent", "W and P do not depend on the observer", check_frame_indifference},
    {"ArraysGiveWhatPointsGive", "arrays give what single points give", check_arrays},
    {"IsFiniteAtRest", "all is finite and repeatable at rest", check_rest},
    {"SaysWhetherItDependsOnTime", "W changes with time where the law says so", check_time},
    {"StateMovesOnAndDissipates", "the state moves on once and dissipates", check_state},
    {"ViscousStressDissipates", "the viscous stress dissipates", check_viscous_stress},
    {"SaysWhereItIsNotDefined", "W is finite where it is said to be", check_domain},
    {"ResistsStretching", "W grows when stretched", check_resistance}};


  /// The examples of the schema of a law; that there are none is a finding.
  inline std::vector<std::string>
  examples_of_law(const Registry &registry, const std::string &law, Findings &findings)
  {
    for (const Registry::Entry &entry : registry.entries())
      if (entry.kind == ConstitutiveLaw<2, 2>::kind && entry.name == law)
        return Schema(entry.schema).examples();
    findings.add("there is no " + std::string(ConstitutiveLaw<2, 2>::kind) + " " + law);
    return {};
  }


  /// A requirement, for all examples.
  inline Findings
  findings_of(const LawRequirement &requirement, const Registry &registry, const std::string &law)
  {
    Findings findings;
    for (const std::string &example : examples_of_law(registry, law, findings))
      findings.append(requirement.check(registry, law, example));
    return findings;
  }


  /// Every pair of dimensions that the law is offered for has an example.
  inline Findings
  check_examples(const Registry &registry, const std::string &law)
  {
    Findings findings;
    std::set<std::pair<int, int>> accepted;
    for (const std::string &example : examples_of_law(registry, law, findings))
      findings.append(for_each_law(registry, law, example, [&](const auto &sample) {
        accepted.insert({sample.F[0][0].dimension, sample.F[0].dimension});
      }));
    const auto expect = [&](const bool offered, const int structure_dim, const int dim) {
      findings.place = "a structure of dimension " + std::to_string(structure_dim) +
                       " in dimension " + std::to_string(dim) + ": ";
      if (offered && accepted.count({structure_dim, dim}) == 0)
        findings.add("every example is refused");
    };
    expect(registry.offers<ConstitutiveLaw<1, 2>>(law), 1, 2);
    expect(registry.offers<ConstitutiveLaw<2, 2>>(law), 2, 2);
    expect(registry.offers<ConstitutiveLaw<2, 3>>(law), 2, 3);
    expect(registry.offers<ConstitutiveLaw<3, 3>>(law), 3, 3);
    return findings;
  }
} // namespace feib::testing

#endif
