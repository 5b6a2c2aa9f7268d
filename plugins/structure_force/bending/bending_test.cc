// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/structure_force_kit.h>

#include <deal.II/base/numbers.h>

FEIB_TEST_STRUCTURE_FORCE("bending");

namespace
{
  using namespace feib;
  using dealii::numbers::PI;
  using feib::testing::registry;

  /// The energy of bending of a membrane as it starts.
  template <int dim>
  double
  energy(const std::string &mesh, const std::string &bending)
  {
    const auto model = registry().create<StructureModel<dim>>(
      "membrane",
      R"({"name": "s", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": )" + mesh + "}");
    const auto force = registry().create<StructureForce<dim>>("bending", bending);
    const auto box   = feib::testing::unit_box<dim>();
    force->attach({model->mesh(), model->positions, {}, {0.}, box});
    return force->energy(model->positions);
  }

  double
  ring(const unsigned int n, const std::string &bending)
  {
    return energy<2>(R"j({"closed_curve": {"length": 1.5707963267948966, "elements": )j" +
                       std::to_string(n) +
                       R"j(}}, "initial_position": ["0.25*cos(4*s1)", "0.25*sin(4*s1)"])j",
                     bending);
  }
} // namespace


/// B/2 int (1/R - curvature)^2 ds, to second order.
TEST(Bending, EnergyOfARing)
{
  for (const double curvature : {0., 1.5, -2.})
    {
      const std::string bending =
        R"({"rigidity": 0.3, "curvature": )" + std::to_string(curvature) + "}";
      const double exact = .3 / 2 * std::pow(4 - curvature, 2) * PI / 2;
      const double error = std::abs(ring(20, bending) - exact),
                   half  = std::abs(ring(40, bending) - exact);
      EXPECT_LT(error, .03 * exact) << curvature;
      EXPECT_NEAR(error / half, 4, .1) << curvature;
    }
  EXPECT_LT(ring(20, R"({"rigidity": 0.3, "initial_shape": true})"), 1e-20);
}


namespace
{
  double
  tube(const std::string &cells)
  {
    return energy<3>(R"({"cylinder": {"radius": 0.2, "length": 0.5, "cells": )" + cells + "}}",
                     R"({"rigidity": 0.7})");
  }

  double
  sphere(const unsigned int refinements, const std::string &bending)
  {
    return energy<3>(R"({"sphere": {"radius": 0.25, "refinements": )" +
                       std::to_string(refinements) + "}}",
                     bending);
  }
} // namespace


/// A tube bends in one direction alone: B/2 (1/R)^2 times its area.
TEST(Bending, EnergyOfATube)
{
  const double exact  = .7 / 2 / (.2 * .2) * 2 * PI * .2 * .5;
  const double coarse = tube("[12, 6]") / exact - 1, fine = tube("[24, 12]") / exact - 1;
  EXPECT_NEAR(fine, 0, .02);
  EXPECT_NEAR(coarse / fine, 4, .2);
  EXPECT_NEAR(tube("[48, 9]") / exact, 1, .005);
}


/// With mean curvature H and Gaussian curvature K, B/2 (2H)^2 - 4/3 B K per area where triangles
/// are equilateral: 8/3 pi B. What counts for the forces on a closed surface is the first term, as
/// the other is the same for all shapes.
TEST(Bending, EnergyOfASphere)
{
  const double exact = 8. / 3 * PI;
  for (const unsigned int refinements : {2, 3, 4})
    EXPECT_NEAR(sphere(refinements, R"({"rigidity": 1})") / exact, 1, .03) << refinements;
  // A sphere of the curvature that costs nothing.
  EXPECT_LT(sphere(3, R"({"rigidity": 1, "curvature": 4})"), .02 * exact);
  EXPECT_GT(sphere(3, R"({"rigidity": 1, "curvature": -4})"), 3 * exact);
  EXPECT_LT(sphere(3, R"({"rigidity": 1, "initial_shape": true})"), 1e-20);
}


TEST(Bending, BodiesAreRefused)
{
  const auto model = registry().create<StructureModel<2>>(
    "hyperelastic",
    R"({"name": "s", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": {"rectangle": {"cells": [1, 1]}}})");
  const auto force = registry().create<StructureForce<2>>("bending", R"({"rigidity": 1})");
  try
    {
      const auto box = feib::testing::unit_box<2>();
      force->attach({model->mesh(), model->positions, {}, {0.}, box});
      FAIL();
    }
  catch (const Error &error)
    {
      EXPECT_NE(std::string(error.what()).find("this structure is a body"), std::string::npos)
        << error.what();
    }
}
