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
    force->attach({model->mesh(), model->positions, {}, {0.}});
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


/// A tube bends in one direction alone: B/2 (1/R)^2 times its area, whichever way the triangles
/// lie.
TEST(Bending, EnergyOfATube)
{
  for (const auto &[n, within] :
       std::map<std::string, double>{{"[12, 6]", .05}, {"[24, 12]", .013}, {"[48, 9]", .004}})
    {
      const double n_around = std::stod(n.substr(1)),
                   n_along  = std::stod(n.substr(n.find(',') + 1));
      // Of what is between the inner rings; across the ends nothing bends.
      const double exact = .7 / 2 / (.2 * .2) * 2 * PI * .2 * .5;
      const double E =
        energy<3>(R"({"cylinder": {"radius": 0.2, "length": 0.5, "cells": )" + n + "}}",
                  R"({"rigidity": 0.7})");
      std::cout << n << " " << E / exact << " " << n_around << n_along << std::endl;
      EXPECT_NEAR(E / exact, 1, within) << n;
    }
}


TEST(Bending, EnergyOfASphere)
{
  for (const unsigned int refinements : {1, 2, 3, 4, 5})
    {
      const double E = energy<3>(R"({"sphere": {"radius": 0.3, "refinements": )" +
                                   std::to_string(refinements) + "}}",
                                 R"({"rigidity": 0.7})");
      std::cout << refinements << " " << E / (4 * PI * .7) << std::endl;
    }
  EXPECT_NEAR(energy<3>(R"({"sphere": {"radius": 0.25, "refinements": 3}})",
                        R"({"rigidity": 1, "curvature": 4})"),
              0,
              .01);
}


TEST(Bending, BodiesAreRefused)
{
  const auto model = registry().create<StructureModel<2>>(
    "hyperelastic",
    R"({"name": "s", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": {"rectangle": {"cells": [1, 1]}}})");
  const auto force = registry().create<StructureForce<2>>("bending", R"({"rigidity": 1})");
  try
    {
      force->attach({model->mesh(), model->positions, {}, {0.}});
      FAIL();
    }
  catch (const Error &error)
    {
      EXPECT_NE(std::string(error.what()).find("this structure is a body"), std::string::npos)
        << error.what();
    }
}
