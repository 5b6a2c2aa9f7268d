// SPDX-License-Identifier: LGPL-2.1-or-later
// What the time schemes promise: order, energy, and what fluid and structure exchange.
#include "support/run_host.h"

#include <feib/testing/trial.h>

#include <gtest/gtest.h>

#include <cmath>

namespace
{
  using namespace feib;
  using feib::testing::registry;

  /// The case of a file, taken in hand.
  template <int dim>
  struct Trial : feib::testing::Trial<dim>
  {
    Trial(const std::string &file, const Case::Settings &settings)
      : feib::testing::Trial<dim>(Case::from_file(file, registry(), settings))
    {}
  };

  const std::string membrane = FEIB_SOURCE "/cases/elliptic_membrane/case.json",
                    shell    = FEIB_SOURCE "/cases/elliptic_shell/case.json",
                    disc     = FEIB_SOURCE "/cases/cavity_disc/case.json";

  const std::vector<std::string> schemes = {"fe_be",
                                            "lagged_be",
                                            "be_be",
                                            "midpoint",
                                            "lagged_midpoint"};

  bool
  is_midpoint(const std::string &scheme)
  {
    return scheme.find("midpoint") != std::string::npos;
  }

  bool
  is_explicit(const std::string &scheme)
  {
    return scheme == "fe_be" || scheme == "midpoint";
  }

  std::string
  block(const std::string &scheme, const std::string &parameters = "")
  {
    return "{\"" + scheme + "\": {" + parameters + "}}";
  }

  const std::string tight = "1e-12";

  const std::string stretched = "[\"0.6+1.25*(s1-0.6)\", \"0.5+0.8*(s2-0.5)\"]";
} // namespace


TEST(TimeSchemes, Order)
{
  // Differences between runs with dt, dt/2, dt/4, ... on one mesh.
  struct Example
  {
    std::string name, file, structure;
    double dt, end;
  };
  for (const Example &example : {Example{"elliptic_membrane", membrane, "membrane", .002, .04},
                                 Example{"elliptic_shell", shell, "hyperelastic", .002, .04}})
    for (const std::string &scheme : schemes)
      {
        SCOPED_TRACE(example.name + ", " + scheme);
        std::vector<VelocityVector> u;
        std::vector<Positions<2>> X;
        std::vector<double> area;
        for (const int refinement : {1, 2, 4, 8, 16})
          {
            const double dt = example.dt / refinement;
            Trial<2> run(example.file,
                         {{"/domain/cells", "[16, 16]"},
                          {"/fluid/navier_stokes/viscosity", "0.05"},
                          {"/fluid/navier_stokes/tolerance", tight},
                          {"/time/step", std::to_string(dt)},
                          {"/time/integrator",
                           block(scheme,
                                 scheme == "be_be" ? "\"geometry_tolerance\": 1e-9" : "")}});
            for (unsigned int i = 0; i < std::lround(example.end / dt); ++i)
              run.step();
            u.push_back(run.space.velocity);
            u.back().zero_out_ghost_values();
            X.push_back(run.structures[0].model->positions);
            area.push_back(run.structures[0].model->measure(X.back()));
          }
        const unsigned int last = u.size() - 1;
        std::vector<double> du, dX, dA;
        for (unsigned int i = 0; i < last; ++i)
          {
            VelocityVector difference = u[i];
            difference -= u[i + 1];
            du.push_back(difference.l2_norm());
            double sum = 0;
            for (unsigned int k = 0; k < X[i].size(); ++k)
              sum += X[i][k].distance_square(X[i + 1][k]);
            dX.push_back(std::sqrt(sum));
            dA.push_back(std::abs(area[i] - area[i + 1]));
          }
        // Over all halvings: each alone is scattered by nodes that cross faces of cells, where the
        // velocity has kinks.
        const auto rate = [&](const std::vector<double> &d) {
          return std::log2(d.front() / d.back()) / (d.size() - 1);
        };
        std::cout << example.name << ", " << scheme << ": orders of u, X, area " << rate(du) << ' '
                  << rate(dX) << ' ' << rate(dA) << "; differences of X " << dX[last - 2] << ' '
                  << dX[last - 1] << std::endl;
        const double order = is_midpoint(scheme) ? 2 : 1;
        EXPECT_NEAR(rate(du), order, .2);
        EXPECT_NEAR(rate(dX), order, .2);
        EXPECT_NEAR(rate(dA), order, .2);
      }
}

TEST(TimeSchemes, TheLedgerOfEnergyClosesForAllSchemesLawsAndRules)
{
  // K + E + dissipated + convected + numerical = initial, step by step, to the solver's tolerance.
  const std::string mesh = "/structures/0/hyperelastic";
  const std::vector<std::pair<std::string, std::vector<Case::Settings>>> examples = {
    {membrane, {{}, {{"/structures/0/membrane/excess_density", "0.5"}}}},
    {shell,
     {{{mesh + "/law",
        "{\"mooney_rivlin_fibres\": {\"c1\": 1, \"fibre_modulus\": 5, \"fibres\": [[1, 0]]}}"},
       {mesh + "/excess_density", "2"}}}},
    {disc,
     {{{mesh + "/law", "{\"neo_hookean\": {\"shear_modulus\": 10, \"stress_free\": true}}"},
       {mesh + "/initial_position", stretched},
       {mesh + "/face_quadrature", "{\"gauss\": {\"points\": 2}}"}}}}};
  for (const auto &[file, all] : examples)
    for (const Case::Settings &special : all)
      for (const std::string &scheme : schemes)
        {
          SCOPED_TRACE(file + ", " + scheme);
          Case::Settings settings = {{"/domain/cells", "[8, 8]"},
                                     {"/fluid/navier_stokes/tolerance", tight},
                                     {"/time/step", "0.002"},
                                     {"/time/integrator", block(scheme)}};
          settings.insert(settings.end(), special.begin(), special.end());
          Trial<2> run(file, settings);
          double before = run.energy(), sum_numerical = 0;
          const double initial = before;
          for (unsigned int n = 0; n < 4; ++n)
            {
              const auto report  = run.step();
              const double after = run.energy();
              EXPECT_NEAR(after - before + report.dissipated + report.convected + report.numerical +
                            report.unexplained - report.boundary_work - report.body_work,
                          0,
                          1e-11 * initial);
              EXPECT_GT(report.dissipated, 1e-9 * initial);
              EXPECT_NEAR(report.convected, 0, 1e-13 * initial);
              sum_numerical += report.numerical;
              before = after;
            }
          if (scheme == "lagged_be" || scheme == "be_be")
            {
              EXPECT_GT(sum_numerical, 0);
            }
        }
}

TEST(TimeSchemes, WhatFluidAndStructureExchange)
{
  // In a periodic box all momentum stays with fluid and structure. The force of a closed structure
  // is zero, its torque where it is spread from the positions it is computed at; power is what the
  // structure's forces do on the velocities the fluid gives it, exactly, for every scheme and rule.
  for (const bool thick : {false, true})
    for (const bool gauss : {false, true})
      for (const std::string excess : {"0", "2"})
        for (const std::string &scheme : schemes)
          {
            if (gauss && !thick)
              continue;
            SCOPED_TRACE(std::string(thick ? "shell" : "membrane") + (gauss ? ", gauss" : "") +
                         ", excess density " + excess + ", " + scheme);
            const std::string structure =
              std::string("/structures/0/") + (thick ? "hyperelastic" : "membrane");
            Case::Settings settings = {{"/domain/cells", "[12, 12]"},
                                       {"/domain/periodic", "[\"x\", \"y\"]"},
                                       {"/fluid/navier_stokes/tolerance", tight},
                                       {"/fluid/navier_stokes/convection", "none"},
                                       {"/fluid/navier_stokes/initial_velocity",
                                        "[\"0.3+0.5*sin(2*pi*y+1)\", 0.1]"},
                                       {structure + "/excess_density", excess},
                                       {"/time/step", "0.002"},
                                       {"/time/integrator", block(scheme)}};
            if (gauss)
              settings.push_back({structure + "/face_quadrature", "{\"gauss\": {\"points\": 2}}"});
            Trial<2> run(thick ? shell : membrane, settings);
            const StructureModel<2> &model = *run.structures[0].model;
            NodalField<2> elastic;
            model.load(model.positions, elastic);
            double scale = 0;
            for (const auto &force : elastic)
              scale += force.norm();
            double largest_torque = 0;
            for (unsigned int n = 0; n < 3; ++n)
              {
                const auto momentum_before = run.momentum();
                const auto before          = run.fluid->balance(run.space);
                const auto fluid_before    = before.momentum;
                const auto report          = run.step();
                const auto &exchange       = report.exchanges[0];
                // The fluid's own account of what it got (a backward Euler step loses the energy
                // of its increment, which the scheme's numerical loss holds for all but midpoints).
                if (is_midpoint(scheme))
                  {
                    const double gained =
                      run.fluid->balance(run.space).kinetic_energy - before.kinetic_energy;
                    EXPECT_NEAR(run.dt * exchange.power,
                                gained + report.dissipated + report.convected,
                                1e-10 * before.kinetic_energy);
                  }
                // All there is keeps its momentum; the fluid's changes by the force it is given.
                EXPECT_LT((run.momentum() - momentum_before).norm(), 1e-10 * run.dt * scale);
                EXPECT_LT((run.fluid->balance(run.space).momentum - fluid_before -
                           run.dt * exchange.force)
                            .norm(),
                          1e-10 * run.dt * scale);
                if (excess == "0")
                  {
                    EXPECT_LT(exchange.force.norm(), 1e-11 * scale);
                  }
                else
                  {
                    EXPECT_GT(exchange.force.norm(), 1e-9 * scale);
                  }
                largest_torque = std::max(largest_torque, std::abs(exchange.torque[2]));
              }
            if (excess == "0")
              {
                if (is_explicit(scheme))
                  {
                    EXPECT_LT(largest_torque, 1e-12 * scale);
                  }
                else if (scheme == "be_be") // as far as the geometry is found
                  {
                    EXPECT_LT(largest_torque, 1e-6 / 12 * scale);
                  }
                else
                  {
                    EXPECT_GT(largest_torque, 1e-9 * scale);
                  }
              }
          }
}

TEST(TimeSchemes, AreaSplitsIntoLeakAndTimeError)
{
  // In two dimensions area is a quadratic polynomial of the positions: the flux through the
  // polygon where J is taken, and the rest. Exactly half way there is no rest.
  for (const std::string &scheme : schemes)
    {
      Trial<2> run(membrane,
                   {{"/domain/cells", "[16, 16]"},
                    {"/coupling", "{\"variational\": {}}"}, // the one that leaks
                    {"/time/step", "0.002"},
                    {"/time/integrator",
                     scheme == "lagged_midpoint" ? block(scheme, "\"corrections\": 10")
                                                 : block(scheme)}});
      const StructureModel<2> &model = *run.structures[0].model;
      double leak = 0, time_error = 0;
      for (unsigned int n = 0; n < 5; ++n)
        {
          const double before = model.measure(model.positions);
          const auto report   = run.step();
          leak += report.exchanges[0].leak;
          time_error += model.measure(model.positions) - before - report.exchanges[0].leak;
        }
      std::cout << scheme << ": leak " << leak << ", time error " << time_error << std::endl;
      EXPECT_GT(std::abs(leak), 1e-8);
      if (scheme == "lagged_midpoint")
        {
          EXPECT_NEAR(time_error, 0, 1e-12);
        }
      else
        {
          EXPECT_GT(std::abs(time_error), 1e-10);
        }
    }
}

TEST(TimeSchemes, NonlinearLawsConvergeInFewNewtonIterationsAtLargeSteps)
{
  for (const std::string law :
       {"{\"neo_hookean\": {\"shear_modulus\": 50, \"stress_free\": true}}",
        "{\"mooney_rivlin_fibres\": {\"c1\": 20, \"c2\": 5, \"fibre_modulus\": 100, \"fibres\": "
        "[[1, 0]]}}"})
    for (const std::string scheme : {"lagged_be", "lagged_midpoint"})
      {
        SCOPED_TRACE(law + scheme);
        Trial<2> run(disc,
                     {{"/domain/cells", "[16, 16]"},
                      {"/domain/boundary", "{}"},
                      {"/fluid/navier_stokes/viscosity", "0.1"},
                      {"/structures/0/hyperelastic/law", law},
                      {"/structures/0/hyperelastic/initial_position", stretched},
                      {"/time/step", "0.01"},
                      {"/time/integrator", block(scheme)}});
        double before = run.energy();
        for (unsigned int n = 0; n < 5; ++n)
          {
            const auto report  = run.step();
            const double after = run.energy();
            EXPECT_LE(report.nonlinear_iterations, 8u);
            EXPECT_LT(after, before);
            before = after;
          }
      }
}

TEST(TimeSchemes, SurfacesAndBodiesInThreeDimensions)
{
  const std::string common =
    "\"dimension\": 3, \"domain\": {\"cells\": [3, 3, 3]}, \"fluid\": {\"navier_stokes\": "
    "{\"density\": 1, \"viscosity\": 0.1, \"tolerance\": 1e-11}}, \"structures\": [";
  const std::string surface =
    "{\"membrane\": {\"name\": \"s\", \"mesh\": {\"sphere\": {\"centre\": [0.5,0.5,0.5], "
    "\"radius\": 0.25, \"refinements\": 2}}, \"initial_position\": [\"0.5+1.2*(s1-0.5)\", \"s2\", "
    "\"0.5+0.9*(s3-0.5)\"], \"excess_density\": 0.1, \"law\": {\"neo_hookean\": "
    "{\"shear_modulus\": 1}}}}";
  const std::string body =
    "{\"hyperelastic\": {\"name\": \"b\", \"mesh\": {\"ball\": {\"centre\": [0.5,0.5,0.5], "
    "\"radius\": 0.25, \"refinements\": 1}}, \"initial_position\": [\"0.5+1.2*(s1-0.5)\", \"s2\", "
    "\"0.5+0.9*(s3-0.5)\"], \"law\": {\"neo_hookean\": {\"shear_modulus\": 4, \"stress_free\": "
    "true}}}}";
  const feib::testing::TemporaryFolder folder;
  for (const std::string &structure : {surface, body})
    for (const std::string &scheme : schemes)
      {
        SCOPED_TRACE(scheme + structure);
        const std::string file = folder.write("case.json",
                                              "{" + common + structure +
                                                "], \"time\": {\"step\": 0.02, \"end\": 1, "
                                                "\"integrator\": " +
                                                block(scheme) + "}}");
        Trial<3> run(file, {});
        double before        = run.energy();
        const double initial = before;
        for (unsigned int n = 0; n < 2; ++n)
          {
            const auto report  = run.step();
            const double after = run.energy();
            EXPECT_NEAR(after - before + report.dissipated + report.convected + report.numerical,
                        0,
                        1e-10 * initial);
            if (!is_explicit(scheme))
              {
                EXPECT_LT(after, before);
              }
            before = after;
          }
      }
}

TEST(TimeSchemes, TheLoadIsDifferentiatedExactly)
{
  // The entries that preconditioners are built of are those of the operator: with them in the
  // factorisation a linear problem takes one or two iterations, however stiff.
  for (const bool thick : {false, true})
    {
      const std::string structure =
        std::string("/structures/0/") + (thick ? "hyperelastic" : "membrane");
      for (const std::string quadrature : {"{\"vertex\": {}}", "{\"gauss\": {\"points\": 3}}"})
        {
          Trial<2> run(thick ? shell : membrane,
                       {{"/domain/cells", "[8, 8]"},
                        {"/fluid/navier_stokes/convection", "none"},
                        {structure + "/law/anisotropic_linear/stiffness", "1e4"},
                        {structure + "/face_quadrature", quadrature},
                        {structure + "/excess_density", "10"},
                        {"/time/step", "0.001"},
                        {"/time/integrator", block("lagged_be")}});
          unsigned int iterations = 0;
          for (unsigned int n = 0; n < 3; ++n)
            {
              iterations = run.step().linear_iterations;
              // Back to the start: the factorisation then is of this very matrix.
              run.space.velocity = run.space.old_velocity = run.space.older_velocity = 0.;
              run.space.pressure                                                     = 0.;
              run.structures[0].model->positions =
                Trial<2>(thick ? shell : membrane, {}).structures[0].model->positions;
              run.structures[0].model->velocities = NodalField<2>(run.structures[0].nodes);
            }
          EXPECT_LE(iterations, 3u) << structure << quadrature;
        }
    }
}
