// SPDX-License-Identifier: LGPL-2.1-or-later
// What a step needs of a law it asks for once: energies and stiffness are those of the end of one
// step and the beginning of the next, loads those the fluid was moved by.
#include "support/run_case.h"

#include <feib/constitutive_law.h>
#include <feib/plugin_loader.h>
#include <feib/simulation.h>

#include <gtest/gtest.h>

namespace
{
  using namespace feib;
  using namespace feib::testing;

  struct Counts
  {
    unsigned int energy = 0, stress = 0, derivative = 0; // calls of the law
  };
  Counts counts;


  /// W = |F|^2/2
  template <int structure_dim, int dim>
  class CountingLaw : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Matrix = typename ConstitutiveLaw<structure_dim, dim>::Matrix;

    explicit CountingLaw(const Parameters &)
    {}

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      ++counts.energy;
      for (std::size_t q = 0; q < F.size(); ++q)
        {
          W[q] = 0;
          for (unsigned int i = 0; i < dim; ++i)
            W[q] += F[q][i] * F[q][i] / 2;
        }
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      ++counts.stress;
      P = F;
    }

    void
    stress_derivative(const std::vector<Matrix> &,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      ++counts.derivative;
      dP = dF;
    }

    bool
    linear() const override
    {
      return true;
    }
  };


  const Registry &
  registry_with_counting_law()
  {
    static Registry *const registry = [] {
      auto *result = new Registry;
      PluginLoader loader(*result);
      for (const std::string &directory : PluginLoader::search_path({}))
        loader.load_directory(directory);
      result->add<ConstitutiveLaw, CountingLaw>(
        "counting",
        R"({"type": "object", "additionalProperties": false, "description": "W = |F|^2/2.",
            "properties": {}, "examples": [{}]})");
      return result;
    }();
    return *registry;
  }


  struct Steps
  {
    std::vector<Counts> counts; // of each step
    Table ledger;               // with a row for the start
  };

  Steps
  run(const std::string &integrator, const std::string &control)
  {
    const TemporaryFolder folder;
    const Case description =
      Case::from_file(FEIB_SOURCE "/cases/elliptic_membrane/case.json",
                      registry_with_counting_law(),
                      {{"/domain/cells", "[8, 8]"},
                       {"/structures/0/membrane/mesh/closed_curve/elements", "32"},
                       {"/structures/0/membrane/law", R"({"counting": {}})"},
                       {"/time/step", "1e-3"},
                       {"/time/end", "5e-3"},
                       {"/time/control", control},
                       {"/time/integrator", integrator},
                       {"/output", R"([{"ledger_csv": {}}])"}});
    Steps steps;
    Counts before;
    Simulation::Options options;
    options.directory   = folder.path.string();
    options.on_progress = [&](const Progress &progress) {
      if (progress.step > 1) // the first one has the start with it
        steps.counts.push_back({counts.energy - before.energy,
                                counts.stress - before.stress,
                                counts.derivative - before.derivative});
      before = counts;
    };
    EXPECT_TRUE(Simulation::create(description)->run(options));
    steps.ledger = read_table(folder / "ledger.csv");
    EXPECT_GE(steps.counts.size(), 3u);
    return steps;
  }

  const std::string fixed              = R"({"fixed": {}})",
                    adaptive           = R"({"adaptive": {"maximum_step": 1e-3}})";
  constexpr unsigned int along_the_way = 2; // loads between the ends of a step, for the accounts
} // namespace


TEST(Evaluations, ExplicitSchemesAskOnceForLoadEnergyAndStiffness)
{
  for (const std::string scheme : {R"({"fe_be": {}})", R"({"midpoint": {}})"})
    for (const std::string &control : {fixed, adaptive})
      for (const Counts &step : run(scheme, control).counts)
        {
          SCOPED_TRACE(scheme + control);
          EXPECT_EQ(step.energy, 1u);
          EXPECT_EQ(step.stress, 1 + along_the_way);
          EXPECT_EQ(step.derivative, 2u); // one for each entry of F
        }
}

TEST(Evaluations, ImplicitSchemesTakeTheLoadFromTheLastSolution)
{
  for (const std::string scheme :
       {R"({"lagged_be": {}})", R"({"be_be": {}})", R"({"lagged_midpoint": {}})"})
    {
      SCOPED_TRACE(scheme);
      const Steps steps = run(scheme, fixed);
      for (unsigned int i = 0; i < steps.counts.size(); ++i)
        {
          const unsigned int row = i + 2;
          // A solution evaluates the load where it begins and after each correction.
          const double n_solutions = 1 + steps.ledger.at("geometry_iterations")[row];
          EXPECT_EQ(steps.counts[i].energy, 1u);
          EXPECT_EQ(steps.counts[i].stress,
                    steps.ledger.at("nonlinear_iterations")[row] + n_solutions + along_the_way);
        }
    }
}
