// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/fields.h>
#include <feib/testing/structure_force_kit.h>

#include <deal.II/base/numbers.h>

FEIB_TEST_STRUCTURE_FORCE("bending");

namespace
{
  using namespace feib;
  using dealii::numbers::PI;
  using feib::testing::registry;

  /// The energy of bending of a membrane as it starts, in a box that is periodic in @p directions.
  template <int dim>
  double
  energy(const std::string &mesh, const std::string &bending, const std::string &directions = "")
  {
    const auto model = registry().create<StructureModel<dim>>(
      "membrane",
      R"({"name": "s", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": )" + mesh + "}");
    const auto force = registry().create<StructureForce<dim>>("bending", bending);
    const auto space = feib::testing::make_space<dim>(std::string(R"({"cells": )") +
                                                      (dim == 2 ? "[4, 4]" : "[4, 4, 4]") +
                                                      R"(, "periodic": [)" + directions + "]}");
    force->attach({model->mesh(), model->positions, {}, {0.}, space->domain()});
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


/// What goes on as its image is bent there as elsewhere, be it of one element only; rims are not.
TEST(Bending, SeamsOfAPeriodicBox)
{
  const auto sheet = [](const std::string &cells, const std::string &y) {
    return energy<3>(R"({"rectangle": {"upper": [1, 0, 1], "cells": )" + cells +
                       R"(}}, "initial_position": ["s1", ")" + y + R"(", "s3"])",
                     R"({"rigidity": 2})",
                     R"("x", "z")");
  };
  const auto along = [](const std::string &s, const std::string &begin) {
    return "0.5 + 0.05*sin(2*pi*(" + s + " + " + begin + "))";
  };
  for (const std::string cells : {"[1, 1]", "[1, 3]", "[2, 2]", "[2, 3]", "[3, 2]", "[4, 4]"})
    EXPECT_EQ(sheet(cells, "0.5"), 0) << cells;
  for (const auto &[cells, s] : {std::pair{"[1, 16]", "s3"},
                                 std::pair{"[2, 16]", "s3"},
                                 std::pair{"[3, 16]", "s3"},
                                 std::pair{"[16, 2]", "s1"}})
    {
      const double whole = sheet(cells, along(s, "0"));
      EXPECT_GT(whole, .1) << cells;
      EXPECT_NEAR(sheet(cells, along(s, "0.25")), whole, 1e-12 * whole) << cells;
    }
  // A strip whose rims are free has no more than what lies between them.
  const std::string rim = R"j({"rectangle": {"upper": [1, 0, 0.5], "cells": [2, 3]}},
    "initial_position": ["s1", "0.5 + 0.05*cos(2*pi*s1)", "s3"])j";
  EXPECT_TRUE(std::isfinite(energy<3>(rim, R"({"rigidity": 2})", R"("x")")));

  const auto curve = [](const unsigned int elements, const std::string &begin) {
    return energy<2>(R"({"open_curve": {"length": 1, "elements": )" + std::to_string(elements) +
                       R"j(}}, "initial_position": ["s1", "0.5 + 0.05*sin(2*pi*(s1 + )j" + begin +
                       R"j())"])j",
                     R"({"rigidity": 2})",
                     R"("x")");
  };
  EXPECT_NEAR(curve(16, "0.25"), curve(16, "0"), 1e-12 * curve(16, "0"));
  // B/2 int y''^2 dx, to second order, where a seam left out would be an error of the first.
  const double exact = 1. * std::pow(.05 * 4 * PI * PI, 2) / 2;
  EXPECT_NEAR(curve(64, "0.25") / exact, 1, .15);
  EXPECT_EQ(curve(1, "0"), 0);
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
