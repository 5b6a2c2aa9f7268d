// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_law_declarations_h
#define feib_testing_law_declarations_h

#include <feib/schema.h>
#include <feib/testing/law_requirements.h>

#include <array>
#include <cmath>
#include <set>
#include <sstream>

namespace feib::testing
{
  /// What the schema of a law may declare of it, for those who choose a law: "declares":
  /// {"stress_free": "always", ...}, each of them true for all parameters, for none, or
  /// "sometimes".
  inline const char *const law_declaration_rules = R"({"type": "object", "properties": {
    "declares": { "type": "object", "additionalProperties": false, "properties": {
      "stress_free":      { "enum": ["always", "sometimes", "never"] },
      "resists_collapse": { "enum": ["always", "sometimes", "never"] },
      "rank_one_convex":  { "enum": ["always", "sometimes", "never"] } } } } })";


  /// P(I) = 0 at the start.
  struct StressFree
  {
    static constexpr const char *name = "stress_free";

    /// What speaks against it, nothing where it is true.
    template <typename Sample>
    static std::string
    objection(Sample &sample)
    {
      sample.set_points(sample.points);
      for (auto &F : sample.F)
        for (unsigned int i = 0; i < F.dimension; ++i)
          for (unsigned int k = 0; k < F[i].dimension; ++k)
            F[i][k] = i == k;
      const auto P = sample.stress(sample.F), dP = sample.stress_derivative(sample.F);
      for (unsigned int q = 0; q < P.size(); ++q)
        {
          const double size = std::sqrt(sample.product(P[q], P[q]));
          if (!(size <= 1e-10 * std::sqrt(sample.product(dP[q], dP[q]))))
            return "|P| = " + std::to_string(size) + " at F = I";
        }
      return "";
    }
  };


  /// W has no bound as det F falls to 0, in whichever direction the material is squeezed.
  struct ResistsCollapse
  {
    static constexpr const char *name = "resists_collapse";

    template <typename Sample>
    static std::string
    objection(Sample &sample)
    {
      constexpr unsigned int m = std::decay_t<decltype(sample.F[0][0])>::dimension;
      sample.set_points(sample.points);
      std::vector<dealii::Tensor<1, m>> directions(sample.F.size());
      for (auto &n : directions)
        {
          for (unsigned int k = 0; k < m; ++k)
            n[k] = sample.random();
          n /= n.norm();
        }
      const auto squeezed = [&](const double by) {
        auto F = sample.F;
        for (unsigned int q = 0; q < F.size(); ++q)
          for (unsigned int i = 0; i < F[q].dimension; ++i)
            F[q][i] -= (1 - by) * (F[q][i] * directions[q]) * directions[q];
        return sample.energy(F);
      };
      const auto W = squeezed(1e-2), nearer = squeezed(1e-4), nearest = squeezed(1e-6);
      for (unsigned int q = 0; q < W.size(); ++q)
        {
          // The slowest growth there is, that of -ln J, is the same from each to the next.
          const double growth = nearer[q] - W[q], more = nearest[q] - nearer[q];
          if (nearest[q] == std::numeric_limits<double>::infinity() ||
              (growth > 0 && more > growth / 2))
            continue;
          std::ostringstream text;
          text << "W = " << W[q] << ", " << nearer[q] << ", " << nearest[q]
               << " where det F is 1e-2, 1e-4, 1e-6 times that of a random F";
          return text.str();
        }
      return "";
    }
  };


  /// d2W/dF2 [F b x n, F b x n] >= 0 for all b and n: waves have real speeds (Legendre, Hadamard).
  /// Of curves and surfaces it is asked for motions within them; across them there is only the
  /// sign of the stress, whatever the law.
  struct RankOneConvex
  {
    static constexpr const char *name = "rank_one_convex";

    template <typename Sample>
    static std::string
    objection(Sample &sample)
    {
      constexpr unsigned int m = std::decay_t<decltype(sample.F[0][0])>::dimension;
      for (unsigned int round = 0; round < 400; ++round)
        {
          if (round % 4 == 0)
            sample.set_gradients();
          for (unsigned int q = 0; q < sample.F.size(); ++q)
            {
              dealii::Tensor<1, m> b, n;
              for (unsigned int k = 0; k < m; ++k)
                {
                  b[k] = sample.random();
                  n[k] = sample.random();
                }
              for (unsigned int i = 0; i < sample.F[q].dimension; ++i)
                sample.dF[q][i] = (sample.F[q][i] * b) * n;
            }
          const auto dP = sample.stress_derivative(sample.dF);
          for (unsigned int q = 0; q < dP.size(); ++q)
            {
              const double curvature = sample.product(dP[q], sample.dF[q]),
                           scale     = std::sqrt(sample.product(dP[q], dP[q]) *
                                             sample.product(sample.dF[q], sample.dF[q]));
              if (curvature >= -1e-10 * scale)
                continue;
              std::ostringstream text;
              text << "d2W/dF2 [a x n, a x n] is " << curvature / scale
                   << " times |dP| |a x n| at a random F, the rows of which are";
              for (unsigned int i = 0; i < sample.F[q].dimension; ++i)
                text << (i ? ", (" : " (") << sample.F[q][i] << ")";
              return text.str();
            }
        }
      return "";
    }
  };


  /// Whether one of these holds where the schema says so, for each example and dimension.
  template <typename Behaviour>
  Findings
  check_declaration(const Registry &registry, const std::string &law, const std::string &schema)
  {
    const auto declared = [&](const std::string &when) {
      return Schema(R"({"required": ["declares"], "properties": {"declares": {"required": [")" +
                    std::string(Behaviour::name) + R"("], "properties": {")" + Behaviour::name +
                    R"(": {"const": ")" + when + R"("}}}}})")
        .accepts(schema);
    };
    const bool always = declared("always"), never = declared("never");
    Findings findings;
    if (!always && !never && !declared("sometimes"))
      return findings;
    const std::string words = std::string("the schema declares \"") + Behaviour::name + "\": \"" +
                              (always  ? "always"
                               : never ? "never"
                                       : "sometimes") +
                              "\", but ";
    unsigned int n_true = 0, n_false = 0;
    for (const std::string &example : Schema(schema).examples())
      findings.append(for_each_law(registry, law, example, [&](auto &sample) {
        const std::string objection = Behaviour::objection(sample);
        ++(objection.empty() ? n_true : n_false);
        if (always && !objection.empty())
          sample.findings.add(words + objection);
        if (never && objection.empty())
          sample.findings.add(words + "here it is");
      }));
    if (!always && !never && (n_true == 0 || n_false == 0))
      findings.add(words + (n_true == 0 ? "it is for no example" : "it is for every example") +
                   ": give one for each, or declare what is found");
    return findings;
  }


  /// What the schema of a law declares is what is found at random points.
  inline Findings
  check_declarations(const Registry &registry, const std::string &law)
  {
    Findings findings;
    for (const Registry::Entry &entry : registry.entries())
      if (entry.kind == ConstitutiveLaw<2, 2>::kind && entry.name == law)
        {
          for (const Issue &issue : Schema(law_declaration_rules).explain(entry.schema))
            findings.add("the schema, " + issue.pointer + ": " + issue.message);
          findings.append(check_declaration<StressFree>(registry, law, entry.schema));
          findings.append(check_declaration<ResistsCollapse>(registry, law, entry.schema));
          findings.append(check_declaration<RankOneConvex>(registry, law, entry.schema));
          break;
        }
    return findings;
  }
} // namespace feib::testing

#endif
