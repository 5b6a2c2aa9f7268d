// SPDX-License-Identifier: LGPL-2.1-or-later
#include "check_plugin.h"

#include <feib/log.h>
#include <feib/message.h>
#include <feib/output_writer.h>
#include <feib/refinement_strategy.h>
#include <feib/simulation.h>
#include <feib/testing/law_declarations.h>
#include <feib/testing/law_requirements.h>
#include <feib/testing/structure_force_requirements.h>
#include <feib/testing/trial.h>

#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iomanip>

namespace feib
{
  namespace
  {
    using testing::Findings;

    /// A body in a box of fluid, small enough for a step to take no time.
    const char *const small_case_2d = R"j({ "dimension": 2, "domain": { "cells": [4, 4] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1 } },
      "structures": [ { "hyperelastic": { "name": "body",
        "mesh": { "rectangle": { "lower": [0.4, 0.4], "upper": [0.6, 0.6], "cells": [1, 1] } },
        "initial_position": ["0.5 + 1.1*(s1 - 0.5)", "s2"],
        "law": { "neo_hookean": { "shear_modulus": 1 } } } } ],
      "time": { "step": 0.001, "end": 1 }, "output": [] })j";

    const char *const small_case_3d = R"j({ "dimension": 3, "domain": { "cells": [2, 2, 2] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1 } },
      "structures": [ { "hyperelastic": { "name": "body",
        "mesh": { "box": { "lower": [0.4, 0.4, 0.4], "upper": [0.6, 0.6, 0.6],
                           "cells": [1, 1, 1] } },
        "initial_position": ["0.5 + 1.1*(s1 - 0.5)", "s2", "s3"],
        "law": { "neo_hookean": { "shear_modulus": 1 } } } } ],
      "time": { "step": 0.001, "end": 1 }, "output": [] })j";

    /// A kind of component: where it stands in a case, whether that makes steps here, and what only
    /// the kit, a test of the plugin, asks.
    struct Kind
    {
      const char *name, *place, *left_to_the_kit;
      bool in_steps;
    };

    const Kind kinds[] = {
      {"structure_model",
       "/structures",
       "entries of the tangent, forces on itself, bounds of its stiffness: "
       "FEIB_TEST_STRUCTURE_MODEL",
       true},
      {"fluid_solver",
       "/fluid",
       "divergence, powers, projection, steps undone, checkpoints, ranks: "
       "FEIB_TEST_FLUID_SOLVER",
       true},
      {"coupling_operator",
       "/coupling",
       "spread() as the transpose of interpolate(), entries, total force: "
       "FEIB_TEST_COUPLING_OPERATOR",
       true},
      {"time_integrator",
       "/time/integrator",
       "energy, momentum, order, steps undone, checkpoints, stability: FEIB_TEST_TIME_INTEGRATOR",
       true},
      {"refinement_strategy",
       "/refinement",
       "coming to rest, following structures, fields kept, checkpoints: "
       "FEIB_TEST_REFINEMENT_STRATEGY",
       false},
      {"output_writer",
       "/output",
       "its files, as nothing is written here: FEIB_TEST_OUTPUT_WRITER",
       false}};


    /// A plugin that calls exit() must not look like one that has passed.
    class ExitWatch
    {
    public:
      ExitWatch()
      {
        static const bool registered = std::atexit(at_exit) == 0;
        active                       = registered;
      }

      ~ExitWatch()
      {
        active = false;
      }

    private:
      static inline bool active = false;

      static void
      at_exit()
      {
        const char *const text = "\nerror: the plugin ended the program while it was checked\n";
        if (active && write(STDERR_FILENO, text, std::strlen(text)) >= 0)
          _exit(2);
        if (active)
          _exit(2);
      }
    };


    std::string
    sentence(const Error &error)
    {
      std::string text;
      for (const Issue &issue : error.issues())
        text += (text.empty() ? "" : "; ") + (issue.pointer.empty() ? "" : issue.pointer + ": ") +
                issue.message;
      return text;
    }


    std::string
    numbers(const std::vector<double> &values)
    {
      std::ostringstream text;
      text << std::setprecision(17);
      for (const double value : values)
        text << (text.tellp() == 0 ? "[" : ", ") << value;
      return text.str() + "]";
    }


    class PluginCheck
    {
    public:
      PluginCheck(const Registry &registry, const std::function<void(const std::string &)> &print)
        : registry(registry)
        , print(print)
      {}

      unsigned int n_checks = 0, n_failed = 0;

      /// A line; what is wrong, indented, below it. What is asked stands there before the plugin's
      /// code runs, in case that never returns.
      template <typename Check>
      void
      ask(const std::string &question, const Check &check)
      {
        print("  " + question + ": ");
        Findings findings;
        findings.run([&] { findings.append(check()); });
        print(findings.sentences.empty() ? "ok\n" : "FAILED\n");
        for (const std::string &text : findings.sentences)
          print("    " + readable_lines(text) + "\n");
        ++n_checks;
        n_failed += !findings.sentences.empty();
      }

      void
      component(const Registry::Entry &entry)
      {
        print(entry.kind + "/" + entry.name + "\n");
        if (entry.kind == ConstitutiveLaw<2, 2>::kind)
          return law(entry.name);
        if (entry.kind == StructureForce<2>::kind)
          return force(entry);
        for (const Kind &kind : kinds)
          if (entry.kind == kind.name)
            {
              for (const std::string &example : Schema(entry.schema).examples())
                this->example(kind, entry, example);
              print("  not checked without a compiler: " + std::string(kind.left_to_the_kit) +
                    "(\"" + entry.name + "\") in a test\n");
            }
      }

    private:
      const Registry &registry;
      const std::function<void(const std::string &)> &print;

      void
      law(const std::string &name)
      {
        const unsigned int n_before = n_failed;
        ask("an example for every dimension",
            [&] { return testing::check_examples(registry, name); });
        if (n_failed > n_before)
          return print("  not checked: the rest, which wants examples\n");
        for (const testing::LawRequirement &requirement : testing::law_requirements)
          ask(requirement.sentence,
              [&] { return testing::findings_of(requirement, registry, name); });
        ask("it behaves as its schema declares",
            [&] { return testing::check_declarations(registry, name); });
      }

      void
      force(const Registry::Entry &entry)
      {
        for (const std::string &example : Schema(entry.schema).examples())
          ask("the example " + example + ", all that its kit asks",
              [&] { return testing::check_structure_force(registry, entry.name, example); });
      }

      void
      example(const Kind &kind, const Registry::Entry &entry, const std::string &block)
      {
        std::vector<int> accepted;
        ask("the example " + block, [&] {
          std::string refusals;
          for (const int dim : {2, 3})
            try
              {
                dim == 2 ? make<2>(entry, block) : make<3>(entry, block);
                accepted.push_back(dim);
              }
            catch (const Error &error)
              {
                refusals += (refusals.empty() ? "" : "; ") + std::string("dimension ") +
                            std::to_string(dim) + ": " + sentence(error);
              }
          Findings findings;
          if (accepted.empty())
            findings.add("it is refused in every dimension: " + refusals);
          return findings;
        });
        for (const int dim : accepted)
          ask("in a case of dimension " + std::to_string(dim) +
                (kind.in_steps ? ", two steps of it" : ""),
              [&] {
                return dim == 2 ? in_case<2>(kind, entry, block) : in_case<3>(kind, entry, block);
              });
      }

      template <int dim>
      void
      make(const Registry::Entry &entry, const std::string &block) const
      {
        const auto create = [&](auto interface) {
          using Interface = typename decltype(interface)::type;
          if (entry.kind == Interface::kind)
            registry.create<Interface>(entry.name, block);
        };
        create(Type<FluidSolver<dim>>());
        create(Type<StructureModel<dim>>());
        create(Type<CouplingOperator<dim>>());
        create(Type<TimeIntegrator<dim>>());
        create(Type<RefinementStrategy<dim>>());
        create(Type<OutputWriter<dim>>());
      }

      template <typename T>
      struct Type
      {
        using type = T;
      };

      template <int dim>
      Findings
      in_case(const Kind &kind, const Registry::Entry &entry, const std::string &block) const
      {
        const std::string component = "{\"" + entry.name + "\": " + block + "}", place = kind.place;
        const bool is_list     = place == "/structures" || place == "/output";
        Case::Settings changes = {{place, is_list ? "[" + component + "]" : component}};
        if (place == "/structures") // a box that holds it
          {
            const auto model = registry.create<StructureModel<dim>>(entry.name, block);
            const auto &X    = model->positions;
            std::vector<double> lower(dim), upper(dim);
            double size = 0;
            for (unsigned int a = 0; a < dim; ++a)
              {
                upper[a] = X.largest([&](const unsigned int i) { return X[i][a]; });
                lower[a] = -X.largest([&](const unsigned int i) { return -X[i][a]; });
                size     = std::max(size, upper[a] - lower[a]);
              }
            for (unsigned int a = 0; a < dim; ++a)
              {
                lower[a] -= size;
                upper[a] += size;
              }
            changes.emplace_back("/domain/lower", numbers(lower));
            changes.emplace_back("/domain/upper", numbers(upper));
            // Of stiff examples too.
            changes.emplace_back("/time/step", "1e-6");
          }
        const auto description = [&] {
          return Case(dim == 2 ? small_case_2d : small_case_3d, "check", registry, changes);
        };
        Findings findings;
        try
          {
            Simulation::create(description());
            if (!kind.in_steps)
              return findings;
            testing::Trial<dim> trial(description());
            for (unsigned int step = 0; step < 2; ++step)
              trial.step();
            if (!std::isfinite(trial.energy()))
              findings.add("the energy is not finite after two steps");
          }
        catch (const Error &error)
          {
            findings.add(sentence(error));
          }
        return findings;
      }
    };
  } // namespace


  bool
  check_plugin(const PluginLoader &loader,
               const Registry &registry,
               const std::function<void(const std::string &)> &print)
  {
    const PluginLoader::Result &plugin = loader.results()[0];
    if (!plugin.accepted)
      {
        print(plugin.file + ": refused: " + plugin.reason + "\n");
        return false;
      }
    log::set_level("off");
    const ExitWatch watch;
    PluginCheck check(registry, print);
    print(plugin.plugin + " " + plugin.version + " (" + plugin.file + ")\n");
    print("  handshake and schemas: ok\n");
    check.ask("a name that runs find, *.feib.so", [&] {
      Findings findings;
      const std::string name = std::filesystem::path(plugin.file).filename().string();
      if (name.size() <= 8 || name.compare(name.size() - 8, 8, ".feib.so") != 0)
        findings.add("the file is called " + readable(name) + ", which no run looks for");
      return findings;
    });
    check.ask("components", [&] {
      Findings findings;
      if (plugin.components.empty())
        findings.add("the plugin adds none");
      return findings;
    });
    for (const Registry::Entry &entry : registry.entries())
      if (entry.origin == plugin.file)
        check.component(entry);
    print(check.n_failed == 0 ? "All " + std::to_string(check.n_checks) + " checks passed\n"
                              : std::to_string(check.n_failed) + " of " +
                                  std::to_string(check.n_checks) + " checks failed\n");
    return check.n_failed == 0;
  }
} // namespace feib
