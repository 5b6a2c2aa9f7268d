// SPDX-License-Identifier: LGPL-2.1-or-later
// A law written by hand beside the same law given by its energy alone: ns for each point.
#include "support/energy_twins.h"

#include <feib/testing/plugins.h>

#include <benchmark/benchmark.h>

#include <random>

namespace
{
  using namespace feib;

  enum class What
  {
    energy,
    stress,
    derivative
  };

  template <int m, int dim>
  void
  evaluate(benchmark::State &state, const bool by_hand, const What what)
  {
    using Law                  = ConstitutiveLaw<m, dim>;
    using Matrix               = typename Law::Matrix;
    constexpr std::size_t size = 4096;
    std::mt19937 generator;
    std::uniform_real_distribution<double> random(-.3, .3);
    std::vector<Matrix> F(size), dF(size), P(size);
    std::vector<double> W(size);
    for (std::size_t q = 0; q < size; ++q)
      for (int i = 0; i < dim; ++i)
        for (int k = 0; k < m; ++k)
          {
            F[q][i][k]  = (i == k) + random(generator);
            dF[q][i][k] = random(generator);
          }
    const std::unique_ptr<Law> law =
      by_hand
        ? feib::testing::registry().create<Law>("neo_hookean",
                                                R"({"shear_modulus": 1, "stress_free": true})")
        : std::make_unique<feib::testing::NeoHookeanTwin<m, dim>>(std::vector<double>(size, 1.),
                                                                  true,
                                                                  false);
    law->set_points(std::vector<typename Law::MaterialPoint>(size));
    for (auto _ : state)
      {
        if (what == What::energy)
          law->energy(F, W);
        else if (what == What::stress)
          law->stress(F, P);
        else
          law->stress_derivative(F, dF, P);
        benchmark::ClobberMemory();
      }
    state.counters["s/piece"] =
      benchmark::Counter(size * state.iterations(),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  }

  template <int m, int dim>
  void
  add()
  {
    const std::pair<const char *, What> parts[] = {{"energy", What::energy},
                                                   {"stress", What::stress},
                                                   {"derivative", What::derivative}};
    for (const auto &[name, what] : parts)
      for (const bool by_hand : {true, false})
        benchmark::RegisterBenchmark(("law<" + std::to_string(m) + ", " + std::to_string(dim) +
                                      ">/" + name + (by_hand ? "/by_hand" : "/by_energy"))
                                       .c_str(),
                                     evaluate<m, dim>,
                                     by_hand,
                                     what);
  }

  const bool added = [] {
    add<1, 2>();
    add<2, 2>();
    add<2, 3>();
    add<3, 3>();
    return true;
  }();
} // namespace
