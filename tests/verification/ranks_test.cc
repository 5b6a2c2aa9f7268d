// SPDX-License-Identifier: LGPL-2.1-or-later
// The ledger does not depend on the number of ranks.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace
{
  using namespace feib::testing;

  struct Table
  {
    std::vector<std::string> columns;
    std::vector<std::vector<double>> rows;
  };

  Table
  read_ledger(const std::string &file)
  {
    Table table;
    std::istringstream text(read_file(file));
    std::string line, cell;
    std::getline(text, line);
    std::istringstream header(line);
    while (std::getline(header, cell, ','))
      table.columns.push_back(cell);
    while (std::getline(text, line))
      {
        std::istringstream row(line);
        table.rows.emplace_back();
        while (std::getline(row, cell, ','))
          table.rows.back().push_back(std::stod(cell));
      }
    return table;
  }

  void
  compare(const std::string &name, const std::string &settings)
  {
    const TemporaryFolder temporary;
    for (const unsigned int ranks : {1, 2, 3})
      {
        const RunResult run =
          run_host(shell_quoted(FEIB_SOURCE "/cases/" + name + "/case.json") + " --output " +
                     shell_quoted(temporary / std::to_string(ranks)) +
                     " --set '/output=[{\"ledger_csv\": {}}]' " + settings,
                   ranks);
        ASSERT_EQ(run.exit_code, 0) << run.output;
        EXPECT_EQ(read_json(temporary / std::to_string(ranks) + "/summary.json")["ranks"], ranks);
      }
    const Table one = read_ledger(temporary / "1/ledger.csv");
    ASSERT_GT(one.rows.size(), 10u);
    for (const std::string ranks : {"2", "3"})
      {
        const Table other = read_ledger(temporary / (ranks + "/ledger.csv"));
        ASSERT_EQ(one.columns, other.columns);
        ASSERT_EQ(one.rows.size(), other.rows.size());
        double worst = 0;
        const unsigned int total =
          std::find(one.columns.begin(), one.columns.end(), "total_energy") - one.columns.begin();
        for (unsigned int c = 0; c < one.columns.size(); ++c)
          {
            // Times, and iterations, which depend on round-off.
            if (one.columns[c].rfind("seconds", 0) == 0 ||
                one.columns[c].find("iterations") != std::string::npos)
              continue;
            // Relative to the largest value of the column; sums that cancel, to 1e-6, and parts of
            // the energy to a thousandth of the whole.
            const std::set<std::string> parts = {
              "convected", "numerical", "unexplained", "remeshing", "closure"};
            double scale = 1e-6;
            if (parts.count(one.columns[c]) != 0)
              scale = 1e-3 * one.rows[0][total];
            for (const auto &row : one.rows)
              scale = std::max(scale, std::abs(row[c]));
            for (unsigned int i = 0; i < one.rows.size(); ++i)
              {
                const double difference = std::abs(one.rows[i][c] - other.rows[i][c]) / scale;
                worst                   = std::max(worst, difference);
                EXPECT_LE(difference, 1e-8)
                  << one.columns[c] << ", row " << i << ", ranks " << ranks;
              }
          }
        std::cout << name << ": ranks 1 and " << ranks << " differ by " << worst << std::endl;
      }
  }

  // Iterations of solvers need not stop at the same place.
  const std::string tight = "--set /fluid/navier_stokes/tolerance=1e-11 ";
} // namespace

TEST(Ranks, ThickShellOnAMeshThatFollowsIt)
{
  compare("elliptic_shell", tight + "--set /time/end=0.03 --set /domain/cells=[8,8]");
}

// The elements are divided by their order: some ranks have none of one of the materials.
TEST(Ranks, LawsWithoutElementsOnSomeRanks)
{
  compare("stretched_disc",
          tight + "--set /time/end=0.03 --set /time/step=0.0025 --set /domain/cells=[8,8] --set "
                  "'/time/integrator={\"lagged_be\": {}}' --set "
                  "'/structures/0/hyperelastic/mesh={\"rectangle\": {\"lower\": [0.3, 0.3], "
                  "\"upper\": [0.7, 0.7], \"cells\": [4, 4]}}' --set "
                  "'/structures/0/hyperelastic/material=s2 > 0.6 ? 1 : 0' --set "
                  "'/structures/0/hyperelastic/law={\"by_material\": {\"laws\": [{\"materials\": "
                  "[0], \"law\": {\"neo_hookean\": {\"shear_modulus\": 1}}}, {\"materials\": [1], "
                  "\"law\": {\"kelvin_voigt\": {\"viscosity\": 0.1, \"law\": {\"mullins_damage\": "
                  "{\"r\": 2, \"m\": 0.01, \"law\": {\"saint_venant_kirchhoff\": {\"mu\": "
                  "1}}}}}}}]}}'");
}

TEST(Ranks, MembraneInAPeriodicBox)
{
  for (const std::string solver : {"direct", "multigrid"})
    compare("elliptic_membrane",
            tight + "--set /fluid/navier_stokes/linear_solver=" + solver +
              " --set /time/end=0.02 --set /domain/cells=[16,16]");
}

TEST(Ranks, BodiesInContact)
{
  compare("two_discs",
          "--set /fluid/navier_stokes/tolerance=1e-13 --set /time/end=0.12 "
          "--set /domain/cells=[8,16] "
          "--set /structures/0/hyperelastic/mesh/parts/meshes/0/mesh/disc/centre=[0.49,1.17] "
          "--set '/structures/0/hyperelastic/excess_density=s2 > 1.04 ? 1 : 0'");
}

TEST(Ranks, SheetAcrossAPeriodicBox)
{
  compare("elliptic_membrane",
          tight + "--set /time/step=0.002 --set /time/end=0.024 --set /domain/cells=[8,8] "
                  "--set '/structures/0/membrane/mesh={\"open_curve\": {\"length\": 1, "
                  "\"elements\": 24}}' --set '/structures/0/membrane/initial_position=[\"0.3 + "
                  "s1\", \"0.5 + 0.1 * sin(2 * pi * s1)\"]' "
                  "--set '/refinement={\"immersed_cells\": {\"level\": 1, \"interval\": 3}}'");
}

TEST(Ranks, EllipsoidOnAMeshThatFollowsIt)
{
  compare("ellipsoid",
          tight + "--set /time/end=0.024 --set /domain/cells=[4,4,4] "
                  "--set '/refinement={\"immersed_cells\": {\"level\": 1, \"interval\": 4}}'");
}

TEST(Ranks, MembraneAcrossTheCornerOfAPeriodicBoxOnAMeshThatFollowsIt)
{
  // Cells refined at the corner: chains of periodic and hanging constraints between ranks.
  compare(
    "elliptic_membrane",
    "--set /time/step=0.002 --set /time/end=0.024 --set /domain/cells=[8,8] "
    "--set '/structures/0/membrane/initial_position=[\"0.98+0.1*cos(s1/R)\", "
    "\"0.97+0.15*sin(s1/R)\"]' "
    "--set '/fluid/navier_stokes={\"density\": 1, \"viscosity\": 0.1, \"tolerance\": 1e-11, "
    "\"linear_solver\": \"multigrid\", \"initial_velocity\": "
    "[\"sin(2*pi*y)\", 0.3]}' "
    "--set '/refinement={\"immersed_cells\": {\"level\": 3, \"buffer\": 0, \"interval\": 2}}'");
}

TEST(Ranks, MembraneOnAMeshThatFollowsThePressureJumps)
{
  // Symmetric to the diagonals: equal indicators, which round-off must not tell apart.
  compare("elliptic_membrane",
          tight + "--set /time/step=0.002 --set /time/end=0.024 --set /domain/cells=[8,8] "
                  "--set '/refinement={\"error_indicator\": {\"maximum_level\": 3, "
                  "\"structure_level\": 1, \"interval\": 2}}'");
}

TEST(Ranks, DrivenCavityWithImplicitConvection)
{
  compare("cavity_disc",
          tight + "--set /time/end=0.15 --set /domain/cells=[12,12] "
                  "--set '/fluid/navier_stokes/convection=\"implicit\"'");
}

TEST(Ranks, ImplicitSchemes)
{
  const std::string common =
    "--set /time/step=0.004 --set /time/end=0.044 --set /domain/cells=[8,8] "
    "--set /fluid/navier_stokes/tolerance=1e-13 ";
  compare("elliptic_shell",
          common + "--set '/time/integrator={\"lagged_midpoint\": {}}' "
                   "--set /structures/0/hyperelastic/excess_density=1 "
                   "--set /structures/0/hyperelastic/mesh/periodic_strip/cells=[64,3] "
                   "--set '/refinement={\"immersed_cells\": {\"level\": 1, \"interval\": 5}}'");
  compare("elliptic_membrane",
          common + "--set '/time/integrator={\"be_be\": {\"geometry_tolerance\": 1e-10}}' "
                   "--set /fluid/navier_stokes/viscosity=0.1");
}
