// SPDX-License-Identifier: LGPL-2.1-or-later
// Closed membranes: pressure jump, and loss of area as loss of energy.
#include "support/run_case.h"

#include <feib/testing/spaces.h>
#include <feib/time_integrator.h>

#include <gtest/gtest.h>

#include <cmath>

namespace
{
  using namespace feib;
  using dealii::numbers::PI;
} // namespace

TEST(MembraneCircle, PressureIsExactWithinOnePerCentAwayFromTheCurve)
{
  const double R   = .4;
  const auto space = feib::testing::make_space<2>("{\"cells\": [32, 32]}");
  std::vector<ImmersedStructure<2>> structures(1);
  structures[0].model = feib::testing::registry().create<StructureModel<2>>(
    "membrane",
    "{\"name\": \"circle\", \"mesh\": {\"closed_curve\": {\"length\": 2.5132741228718345, "
    "\"elements\": 512}}, \"initial_position\": [\"0.5+0.4*cos(s1/0.4)\", "
    "\"0.5+0.4*sin(s1/0.4)\"], "
    "\"law\": {\"anisotropic_linear\": {\"stiffness\": 1}}}");
  structures[0].motion = feib::testing::registry().create<CouplingOperator<2>>("variational");
  structures[0].nodes  = LagrangianPoints::nodes(structures[0].model->mesh().n_nodes());
  const auto fluid =
    feib::testing::registry().create<FluidSolver<2>>("navier_stokes",
                                                     "{\"density\": 1, \"viscosity\": 1}");
  const auto scheme = feib::testing::registry().create<TimeIntegrator<2>>("fe_be");
  Timers timers;
  TimeIntegrator<2>::System system{*space, *fluid, structures, timers};
  fluid->initialize(*space);
  for (unsigned int n = 0; n < 5; ++n)
    {
      space->old_velocity = space->velocity;
      scheme->step(system, .005 * n, .005);
      system.fluid.commit();
    }

  // The mean of p over a cell is the coefficient of the constant basis function.
  const double jump = 1 / R, outside = -PI * R;
  unsigned int cells_inside = 0, cells_outside = 0;
  double worst = 0;
  for (unsigned int c = 0; c < space->cells().size(); ++c)
    {
      const auto &cell         = space->cells()[c];
      const dealii::Point<2> x = cell.lower + .5 * cell.size;
      const double r           = x.distance({.5, .5});
      if (std::abs(r - R) < 3. / 32)
        continue;
      const double exact = outside + (r < R ? jump : 0);
      worst              = std::max(worst,
                       std::abs(space->pressure.local_element(space->pressure_dofs(c)[0]) - exact) /
                         std::abs(exact));
      ++(r < R ? cells_inside : cells_outside);
    }
  std::cout << "largest relative pressure error away from the curve: " << worst << std::endl;
  EXPECT_GT(cells_inside, 250u);
  EXPECT_GT(cells_outside, 50u);
  EXPECT_LT(worst, .01);
}

// Where half axes are the same but for round-off, too.
TEST(MembraneCircle, HalfAxesAreTheRadius)
{
  const auto run = feib::testing::run_case(FEIB_SOURCE "/cases/membrane_circle/case.json", "");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<double> &area = run.ledger.at("measure_circle");
  EXPECT_GT(area.size(), 5u);
  for (const char *const axis : {"axis_1_circle", "axis_2_circle"})
    for (unsigned int n = 0; n < area.size(); ++n)
      EXPECT_NEAR(run.ledger.at(axis)[n], std::sqrt(area[n] / PI), 1e-3) << axis << " in row " << n;
}

/// A curve that crosses itself and encloses nothing: a figure of eight, and one of four segments.
TEST(CrossedMembrane, WithoutAreaHasTheMiddleForItsCentroid)
{
  struct
  {
    std::string elements, x, y;
  } const shapes[] = {{"64", "0.5 + 0.2*sin(s1)", "0.5 + 0.2*sin(2*s1)"},
                      {"4", "0.5 + 0.2*(sin(s1) - cos(s1))", "0.5 - 0.1*cos(2*s1)"}};
  for (const auto &[elements, x, y] : shapes)
    {
      SCOPED_TRACE(x);
      const feib::testing::CaseRun run = feib::testing::run_text(
        R"j({ "dimension": 2, "domain": { "cells": [8, 8] },
            "fluid": { "navier_stokes": { "density": 1, "viscosity": 1 } },
            "structures": [ { "membrane": { "name": "eight",
              "mesh": { "closed_curve": { "length": 6.283185307179586, "elements": )j" +
        elements + R"j( } }, "initial_position": [ ")j" + x + R"(", ")" + y + R"j(" ],
              "law": { "neo_hookean": { "shear_modulus": 1e-3 } } } } ],
            "time": { "step": 1e-3, "end": 5e-3 }, "output": [ { "ledger_csv": {} } ] })j");
      EXPECT_FALSE(run.warned("measure"));
      for (const char *const column : {"centroid_x_eight", "centroid_y_eight"})
        for (const double value : run.ledger.at(column))
          EXPECT_NEAR(value, .5, 1e-3) << column;
      for (const char *const column : {"measure_eight", "axis_1_eight", "moment_xx_eight"})
        EXPECT_EQ(run.ledger.at(column)[0], 0) << column;
      EXPECT_TRUE(run.summary["structures"][0]["relative_measure_change"].is_null());
    }
}

TEST(RelaxingEllipse, AreaLossAndEnergyLossAreOneNumber)
{
  // Gastaldi's ellipse ends as a circle with 0.8 (1 - q) of its energy if it lost the part q of its
  // area.
  const feib::testing::TemporaryFolder temporary;
  const std::string curve            = "/structures/0/membrane/mesh/closed_curve";
  const feib::testing::RunResult run = feib::testing::run_host(
    feib::testing::shell_quoted(FEIB_SOURCE "/cases/membrane_circle/case.json") + " --output " +
    feib::testing::shell_quoted(temporary / "results") +
    " --set /output=[] --set /time/step=0.01 --set /time/end=3 --set " + curve +
    "/length=1 --set '/structures/0/membrane/initial_position=[\"0.2*cos(2*pi*s1)+0.45\", "
    "\"0.1*sin(2*pi*s1)+0.45\"]'");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const auto summary    = feib::testing::read_json(temporary / "results/summary.json");
  const double q_area   = -summary["structures"][0]["relative_measure_change"].get<double>();
  const double q_energy = 1 - summary["energy"]["elastic"].get<double>() /
                                (.8 * summary["energy"]["total_initial"].get<double>());
  std::cout << "lost area " << q_area << ", lost energy " << q_energy << std::endl;
  EXPECT_GT(q_area, .01);
  EXPECT_NEAR(q_energy / q_area, 1, .06);
  EXPECT_LE(summary["energy"]["largest_increase"].get<double>(), 0);
}
