// SPDX-License-Identifier: LGPL-2.1-or-later
// What the divergence-free coupling promises (docs/volume.md), on whole runs: bodies at rest stay
// at rest, and what a structure encloses changes by the error of the time scheme alone.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace
{
  using namespace feib::testing;
  using Json = nlohmann::json;

  const std::string membrane  = FEIB_SOURCE "/cases/elliptic_membrane/case.json",
                    circle    = FEIB_SOURCE "/cases/membrane_circle/case.json",
                    disc      = FEIB_SOURCE "/cases/stretched_disc/case.json",
                    ellipsoid = FEIB_SOURCE "/cases/ellipsoid/case.json",
                    shell     = FEIB_SOURCE "/cases/elliptic_shell/case.json";

  const std::string variational     = "{\"variational\": {}}",
                    divergence_free = "{\"divergence_free\": {}}";

  /// The summary of a run of a case with settings, its ledger's largest velocity beside it.
  Json
  summary_of(const std::string &file, const std::map<std::string, std::string> &settings)
  {
    const TemporaryFolder temporary;
    std::string command = shell_quoted(file) + " --output " + shell_quoted(temporary / "results") +
                          " --set '/output=[{\"ledger_csv\": {}}]'";
    // What is exact shows where the fluid is solved exactly; in 3D with the default.
    if (file != ellipsoid)
      command += " --set /fluid/navier_stokes/linear_solver=direct"
                 " --set /fluid/navier_stokes/tolerance=1e-12";
    for (const auto &[pointer, value] : settings)
      command += " --set " + shell_quoted(pointer + "=" + value);
    const RunResult result = run_host(command);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    Json summary = read_json(temporary / "results/summary.json");

    std::ifstream ledger(temporary / "results/ledger.csv");
    std::string line, cell;
    std::getline(ledger, line);
    std::istringstream names(line);
    unsigned int column = 0;
    while (std::getline(names, cell, ',') && cell != "largest_velocity")
      ++column;
    EXPECT_EQ(cell, "largest_velocity");
    double largest = 0;
    while (std::getline(ledger, line))
      {
        std::istringstream row(line);
        for (unsigned int i = 0; i <= column; ++i)
          std::getline(row, cell, ',');
        largest = std::max(largest, std::stod(cell));
      }
    summary["largest_velocity"] = largest;
    return summary;
  }

  double
  measure_change(const Json &summary)
  {
    return std::abs(summary["structures"][0]["relative_measure_change"].get<double>());
  }

  double
  leak(const Json &summary)
  {
    return std::abs(summary["structures"][0]["relative_leak"].get<double>());
  }

  double
  element_change(const Json &summary)
  {
    return summary["structures"][0]["relative_element_change"]["rms"];
  }
} // namespace


TEST(Volume, ACircleAtRestStaysAtRest)
{
  std::map<std::string, std::string> settings = {
    {"/domain/cells", "[16,16]"},
    {"/fluid/navier_stokes/viscosity", "0.01"},
    {"/structures/0/membrane/mesh/closed_curve/elements", "128"},
    {"/time/step", "0.002"},
    {"/time/end", "1"},
    {"/time/integrator", "{\"midpoint\": {}}"},
    {"/coupling", divergence_free}};
  const Json still = summary_of(circle, settings);
  EXPECT_LT(still["largest_velocity"], 1e-11);
  EXPECT_LT(measure_change(still), 1e-13);
  settings["/coupling"] = variational;
  const Json moving     = summary_of(circle, settings);
  EXPECT_GT(moving["largest_velocity"], 1e-2);
  EXPECT_GT(measure_change(moving), 1e-2);
}

/// An icosahedron under a surface tension is in equilibrium by its symmetry.
TEST(Volume, AnIcosahedronAtRestStaysAtRest)
{
  std::map<std::string, std::string> settings = {
    {"/structures/0/membrane/mesh/sphere/refinements", "0"},
    {"/structures/0/membrane/initial_position", "[\"s1\", \"s2\", \"s3\"]"},
    {"/fluid/navier_stokes/viscosity", "0.01"},
    {"/time/end", "0.1"}};
  const Json still = summary_of(ellipsoid, settings);
  EXPECT_LT(still["largest_velocity"], 1e-11);
  EXPECT_LT(measure_change(still), 1e-13);
  settings["/coupling"] = variational;
  const Json moving     = summary_of(ellipsoid, settings);
  EXPECT_GT(moving["largest_velocity"], 1e-2);
}

/// Under P = mu_e F a body in its reference shape presses on its boundary alone.
TEST(Volume, ADiscAtRestStaysAtRest)
{
  const std::string body                      = "/structures/0/hyperelastic/";
  std::map<std::string, std::string> settings = {{body + "initial_position", "[\"s1\", \"s2\"]"},
                                                 {body + "law/neo_hookean/shear_modulus", "1"},
                                                 {body + "material", "0"},
                                                 {body + "deviatoric", "false"},
                                                 {body + "volumetric_modulus", "0"}};
  const Json still                            = summary_of(disc, settings);
  EXPECT_LT(still["largest_velocity"], 1e-11);
  EXPECT_LT(measure_change(still), 1e-13);
  EXPECT_LT(element_change(still), 1e-11);
  settings["/coupling"] = variational;
  const Json moving     = summary_of(disc, settings);
  EXPECT_GT(moving["largest_velocity"], 1e-2);
  EXPECT_GT(measure_change(moving), 1e-2);
}

/// Each part of the coupling gains a decade or more; all together leave the error of time.
TEST(Volume, EachPartOfTheCouplingGains)
{
  std::map<std::string, std::string> settings = {
    {"/domain/cells", "[16,16]"},
    {"/domain/periodic", "[]"},
    {"/structures/0/membrane/mesh/closed_curve/elements", "64"},
    {"/time/step", "0.001"},
    {"/time/integrator", "{\"midpoint\": {}}"}};
  double before = 1;
  for (const auto &[coupling, at_most] : std::vector<std::pair<std::string, double>>{
         {variational, .4},
         {"{\"divergence_free\": {\"quadrature\": {\"vertex\": {}}}}", .05},
         {"{\"divergence_free\": {\"quadrature\": {\"gauss\": {}}, \"flux_exact\": false}}", .01},
         {"{\"divergence_free\": {\"flux_exact\": false}}", 2e-4},
         {divergence_free, 1e-7}})
    {
      settings["/coupling"] = coupling;
      const Json summary    = summary_of(membrane, settings);
      const double change   = measure_change(summary);
      std::cout << coupling << ": relative change of area " << change << ", leak " << leak(summary)
                << std::endl;
      EXPECT_LT(change, at_most);
      EXPECT_LT(change, before / 2);
      EXPECT_LT(summary["energy"]["largest_increase"], 0);
      EXPECT_LT(summary["energy"]["largest_closure"], 1e-12);
      before = change;
    }
  EXPECT_LT(leak(summary_of(membrane, settings)), 1e-13);
}

/// The error of time falls like that of the scheme: second order.
TEST(Volume, AreaErrorIsOfSecondOrderInTime)
{
  std::map<std::string, std::string> settings = {
    {"/domain/cells", "[16,16]"},
    {"/domain/periodic", "[]"},
    {"/structures/0/membrane/mesh/closed_curve/elements", "64"},
    {"/time/end", "0.1"},
    {"/time/integrator", "{\"midpoint\": {}}"},
    {"/time/step", "0.002"}};
  const double coarse    = measure_change(summary_of(membrane, settings));
  settings["/time/step"] = "0.0005";
  const double fine      = measure_change(summary_of(membrane, settings));
  std::cout << "steps of 2e-3: " << coarse << ", of 5e-4: " << fine << std::endl;
  EXPECT_GT(std::log(coarse / fine) / std::log(4.), 1.8);
}

/// Nothing leaks either while the mesh follows a body, and with implicit forces.
TEST(Volume, NothingLeaksOnAMeshThatFollows)
{
  for (const std::string scheme : {"midpoint", "lagged_midpoint"})
    {
      const Json summary =
        summary_of(shell,
                   {{"/domain/cells", "[8,8]"},
                    {"/structures/0/hyperelastic/mesh/periodic_strip/cells", "[96,4]"},
                    {"/time/integrator", "{\"" + scheme + "\": {}}"},
                    {"/time/step", scheme == "midpoint" ? "0.002" : "0.01"},
                    {"/fluid/navier_stokes/tolerance", "1e-11"},
                    {"/time/end", "0.2"}});
      EXPECT_LT(leak(summary), 1e-12) << scheme;
      EXPECT_LT(measure_change(summary), 1e-4) << scheme;
    }
}

/// Total area, and the areas of the elements, of a stretched disc of one and of two materials.
TEST(Volume, Solids)
{
  const std::string body                           = "/structures/0/hyperelastic/";
  std::map<std::string, std::string> settings      = {{body + "deviatoric", "false"},
                                                      {body + "volumetric_modulus", "0"}};
  const Json interface                             = summary_of(disc, settings);
  settings[body + "material"]                      = "0";
  const Json mixed                                 = summary_of(disc, settings);
  settings[body + "law/neo_hookean/shear_modulus"] = "1";
  const Json uniform                               = summary_of(disc, settings);
  settings["/coupling"]                            = variational;
  const Json standard                              = summary_of(disc, settings);
  const Json best                                  = summary_of(disc, {});
  for (const auto &[name, summary] : std::map<std::string, Json>{{"two materials", mixed},
                                                                 {"interface", interface},
                                                                 {"one material", uniform},
                                                                 {"standard, one", standard},
                                                                 {"best, two", best}})
    std::cout << name << ": area " << measure_change(summary) << ", elements "
              << element_change(summary) << std::endl;
  EXPECT_GT(measure_change(standard), .05);
  EXPECT_GT(element_change(standard), .1);
  EXPECT_LT(measure_change(uniform), 1e-7);
  EXPECT_LT(element_change(uniform), .02);
  EXPECT_LT(measure_change(mixed), 2e-7);
  EXPECT_LT(element_change(interface), element_change(mixed) / 5);
  EXPECT_LT(measure_change(best), 2e-7);
  EXPECT_LT(element_change(best), .02);
}

/// A thick sheet across a periodic box, with a wave on it: its ends are one.
TEST(Volume, ASheetAcrossAPeriodicBox)
{
  const std::string body                      = "/structures/0/hyperelastic/";
  std::map<std::string, std::string> settings = {
    {"/domain/cells", "[16,16]"},
    {"/domain/periodic", "[\"x\"]"},
    {body + "mesh",
     "{\"rectangle\": {\"lower\": [0.3, 0.4], \"upper\": [1.3, 0.6], \"cells\": [24, 5]}}"},
    {body + "initial_position", "[\"s1\", \"s2 + 0.1 * sin(2 * pi * s1)\"]"},
    {body + "material", "s2 < 0.5 ? 1 : 0"},
    {body + "law", "{\"neo_hookean\": {\"shear_modulus\": 1}}"},
    {"/refinement", "{\"immersed_cells\": {\"level\": 1, \"interval\": 5}}"},
    {"/time/step", "0.001"},
    {"/time/end", "0.1"}};
  for (const std::string scheme : {"midpoint", "lagged_midpoint"})
    {
      settings["/time/integrator"] = "{\"" + scheme + "\": {}}";
      settings["/coupling"]        = divergence_free;
      const Json kept              = summary_of(disc, settings);
      settings["/coupling"]        = variational;
      const Json gained            = summary_of(disc, settings);
      std::cout << scheme << ": leak " << leak(kept) << ", variational " << leak(gained)
                << ", largest velocity " << kept["largest_velocity"] << std::endl;
      EXPECT_LT(leak(kept), 1e-12);
      EXPECT_LT(measure_change(kept), 1e-4);
      EXPECT_GT(leak(gained), 1e-6);
      EXPECT_GT(kept["largest_velocity"], .01);
      EXPECT_LT(kept["largest_velocity"], 1);
    }
}

TEST(Volume, AnEllipsoidKeepsItsVolume)
{
  std::map<std::string, std::string> settings = {{"/time/step", "0.001"}, {"/time/end", "0.03"}};
  // What leaks is what multigrid leaves of the divergence; a factorisation leaves nothing.
  const Json by_multigrid                        = summary_of(ellipsoid, settings);
  settings["/fluid/navier_stokes/linear_solver"] = "direct";
  const Json kept                                = summary_of(ellipsoid, settings);
  settings["/coupling"]                          = variational;
  const Json lost                                = summary_of(ellipsoid, settings);
  std::cout << "change of volume " << measure_change(kept) << ", leak " << leak(kept)
            << ", by multigrid " << leak(by_multigrid) << "; standard coupling "
            << measure_change(lost) << std::endl;
  EXPECT_LT(measure_change(kept), 1e-5);
  EXPECT_LT(leak(kept), 1e-13);
  EXPECT_GT(leak(by_multigrid), 1e-13);
  EXPECT_LT(leak(by_multigrid), 2e-9);
  EXPECT_LT(measure_change(by_multigrid), 1e-5);
  EXPECT_GT(measure_change(lost), 1e-2);
}

/// Two curves less than a cell apart, each with its own coupling.
TEST(Volume, SeveralStructuresInOneCell)
{
  const auto curve = [](const std::string &name, const std::string &radius) {
    return "{\"membrane\": {\"name\": \"" + name +
           "\", \"mesh\": {\"closed_curve\": {\"length\": 1, \"elements\": 64}}, "
           "\"initial_position\": [\"0.5+1.2*" +
           radius + "*cos(2*pi*s1)\", \"0.5+" + radius +
           "*sin(2*pi*s1)\"], \"law\": {\"anisotropic_linear\": {\"stiffness\": 0.1}}}}";
  };
  const Json summary =
    summary_of(membrane,
               {{"/domain/cells", "[16,16]"},
                {"/structures", "[" + curve("a", "0.2") + "," + curve("b", "0.22") + "]"},
                {"/time/step", "0.001"},
                {"/time/end", "0.1"}});
  for (const Json &structure : summary["structures"])
    EXPECT_LT(std::abs(structure["relative_leak"].get<double>()), 1e-13) << structure;
  EXPECT_LT(summary["energy"]["largest_closure"], 1e-12);
}
