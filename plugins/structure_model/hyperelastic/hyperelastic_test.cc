// SPDX-License-Identifier: LGPL-2.1-or-later
#include "../base/elastic_structure_test.h"

using namespace feib;
using namespace feib::testing;

FEIB_TEST_STRUCTURE_MODEL("hyperelastic");

namespace
{
  const std::string component   = "hyperelastic";
  const std::string neo_hookean = R"({"neo_hookean": {"shear_modulus": 2}})";
  const std::string stress_free = R"({"neo_hookean": {"shear_modulus": 2, "stress_free": true}})";
  const std::string strip_map =
    R"j("initial_position": ["(1.5 - s2) * cos(s1)", "(1.5 - s2) * sin(s1)"])j";
  const std::string disc = R"({"disc": {"radius": 1, "rings": 5}})";
  const std::string ball = R"({"ball": {"radius": 1, "refinements": 1}})";
  const std::string ring =
    R"({"ring": {"inner_radius": 1, "outer_radius": 1.5, "cells": [17, 3]}})";

  std::string
  strip(const unsigned int n)
  {
    return R"({"periodic_strip": {"length": 6.283185307179586, "width": 0.5, "cells": [)" +
           std::to_string(n) + ", 2]}}";
  }
} // namespace

// --- force

namespace
{
  template <int dim>
  void
  compare_with_elements(const std::string &mesh,
                        const std::string &law,
                        const std::string &parameters,
                        const std::string &more = "")
  {
    SCOPED_TRACE(mesh + law);
    const auto model =
      make_model<dim>(component, mesh, "{\"" + law + "\": " + parameters + "}", more);
    const Positions<dim> X         = shaken(*model);
    const NodalField<dim> f        = load(*model, X);
    const NodalField<dim> expected = element_wise_load<dim, dim>(model->mesh(), X, law, parameters);
    double difference              = 0;
    for (unsigned int i = 0; i < f.size(); ++i)
      difference = std::max(difference, (f[i] - expected[i]).norm());
    EXPECT_LT(difference, 1e-13 * norm(expected));
  }
} // namespace

// On one rank and on two: the sum over ranks and the faces change nothing.
TEST(Hyperelastic, VertexRuleIsTheElementWiseForce)
{
  const std::string fibres   = R"({"stiffness": 3, "fibres": [["s1", "1"]]})";
  const std::string mooney_2 = R"({"c1": 1, "c2": 2, "fibre_modulus": 3, "fibres": [["s1", "1"]]})";
  const std::string mooney_3 =
    R"({"c1": 1, "c2": 2, "fibre_modulus": 3, "fibres": [["s1", "1", "s3"]]})";
  compare_with_elements<2>(disc, "neo_hookean", R"({"shear_modulus": 2, "stress_free": true})");
  compare_with_elements<2>(ring, "anisotropic_linear", fibres);
  compare_with_elements<2>(strip(20), "mooney_rivlin_fibres", mooney_2, strip_map);
  compare_with_elements<3>(ball, "mooney_rivlin_fibres", mooney_3);
  compare_with_elements<3>(R"({"box": {"cells": [2, 3, 2]}})",
                           "neo_hookean",
                           R"({"shear_modulus": 2, "stress_free": true})");
}

namespace
{
  template <int dim>
  void
  force_is_minus_energy_gradient(const std::string &mesh, const std::string &more = "")
  {
    SCOPED_TRACE(mesh);
    const auto model        = make_model<dim>(component, mesh, neo_hookean, more);
    const Positions<dim> X  = shaken(*model);
    const NodalField<dim> f = load(*model, X);
    // W is quadratic, so the central difference of a long step is exact.
    const double step = 1;
    for (unsigned int i = 0; i < X.size(); i += 3)
      for (unsigned int c = 0; c < dim; ++c)
        {
          Positions<dim> plus = X, minus = X;
          plus[i][c] += step;
          minus[i][c] -= step;
          EXPECT_NEAR(f[i][c],
                      -(model->energy(plus) - model->energy(minus)) / (2 * step),
                      1e-12 * norm(f));
        }
  }
} // namespace

TEST(Hyperelastic, VertexRuleIsMinusTheGradientOfTheEnergy)
{
  force_is_minus_energy_gradient<2>(disc);
  force_is_minus_energy_gradient<2>(strip(12), strip_map);
  force_is_minus_energy_gradient<3>(ball);
}

namespace
{
  template <int dim>
  void
  compare_rules(const std::string &mesh, const unsigned int n_points)
  {
    SCOPED_TRACE(mesh);
    const auto vertex  = make_model<dim>(component, mesh, stress_free);
    const auto gauss   = make_model<dim>(component,
                                       mesh,
                                       stress_free,
                                       R"("face_quadrature": {"gauss": {"points": )" +
                                         std::to_string(n_points) + "}}");
    const auto &points = gauss->load_points();
    EXPECT_EQ(points.nodes_per_point, static_cast<unsigned int>(dim));
    // Against velocities that are linear on faces, both rules are exact.
    const Positions<dim> X   = shaken(*vertex);
    const NodalField<dim> dX = random_field<dim>(X.size(), 1);
    const NodalField<dim> f  = load(*vertex, X);
    EXPECT_NEAR(load(*gauss, X) * at_points(points, dX), f * dX, 1e-13 * norm(f) * norm(dX));
    NodalField<dim> dv, dg;
    vertex->load_derivative(X, dX, dv);
    gauss->load_derivative(X, dX, dg);
    EXPECT_NEAR(dg * at_points(points, dX), dv * dX, 1e-12 * norm(dv) * norm(dX));
  }
} // namespace

TEST(Hyperelastic, GaussRuleHasTheWorkOfTheVertexRule)
{
  for (const unsigned int n : {1, 2, 3})
    {
      compare_rules<2>(disc, n);
      compare_rules<3>(ball, n);
    }
}

// A quadratic velocity on the boundary of an affinely deformed square: Simpson's rule knows the
// answer.
TEST(Hyperelastic, GaussRuleIsExactForItsDegree)
{
  const auto model = make_model<2>(
    component,
    R"({"rectangle": {"cells": [1, 1]}})",
    neo_hookean,
    R"("initial_position": ["s1", "s2"], "face_quadrature": {"gauss": {"points": 2}})");
  const NodalField<2> f = load(*model, model->positions);
  const auto x          = model->load_points().positions(model->positions);
  double power          = 0;
  for (unsigned int q = 0; q < f.size(); ++q)
    power += f[q][0] * x[q][0] * x[q][1] * x[q][1];
  // P = 2 I: - int_boundary 2 n_x x y^2 = - 2 int_0^1 y^2 dy
  EXPECT_NEAR(power, -2. / 3, 1e-14);
}

// A uniform F: the elements balance each other, the boundary alone pulls.
TEST(Hyperelastic, UniformDeformationLoadsTheBoundaryAlone)
{
  const std::string map = R"("initial_position": ["1.2 * s1 + 0.3 * s2", "-0.1 * s1 + 0.9 * s2"])";
  const std::string square =
    R"({"rectangle": {"lower": [0.25, 0.25], "upper": [0.75, 0.75], "cells": [6, 5]}})";
  const auto model = make_model<2>(component, square, stress_free, map);
  const auto without =
    make_model<2>(component, square, stress_free, map + R"(, "boundary_faces": false)");
  const NodalField<2> f = load(*model, model->positions);
  EXPECT_LT(norm(load(*without, model->positions)), 1e-13 * norm(f));
  for (unsigned int i = 0; i < f.size(); ++i)
    {
      const auto &s       = model->mesh().nodes()[i];
      const bool interior = s[0] > .26 && s[0] < .74 && s[1] > .26 && s[1] < .74;
      if (interior)
        EXPECT_LT(f[i].norm(), 1e-13 * norm(f));
      else
        EXPECT_GT(f[i].norm(), 1e-3 * norm(f));
    }
}

// Turning a ring made from a strip by one cell turns its forces: the seam cannot be seen.
TEST(Hyperelastic, SeamOfThePeriodicStripIsInvisible)
{
  const unsigned int n  = 16;
  const auto model      = make_model<2>(component, strip(n), stress_free, strip_map);
  const NodalField<2> f = load(*model, model->positions);
  const double angle    = 2 * M_PI / n;
  EXPECT_GT(norm(f), .1);
  for (unsigned int j = 0; j <= 2; ++j)
    for (unsigned int i = 0; i < n; ++i)
      {
        const auto &here = f[j * n + i], &next = f[j * n + (i + 1) % n];
        EXPECT_NEAR(next[0], std::cos(angle) * here[0] - std::sin(angle) * here[1], 1e-13);
        EXPECT_NEAR(next[1], std::sin(angle) * here[0] + std::cos(angle) * here[1], 1e-13);
      }
}

// --- numbers

TEST(Hyperelastic, MeasureAndCentroid)
{
  const double shell = .5 * 64 * (2.25 - 1) * std::sin(2 * M_PI / 64); // 64-gons
  const auto model   = make_model<2>(component, strip(64), neo_hookean, strip_map);
  EXPECT_NEAR(model->measure(model->positions), shell, 1e-13);
  EXPECT_LT(model->centroid(model->positions).norm(), 1e-13);

  const auto box =
    make_model<3>(component,
                  R"({"box": {"lower": [1, 1, 1], "upper": [2, 3, 4], "cells": [2, 1, 3]}})",
                  neo_hookean,
                  R"("initial_position": ["2 * s1", "s2 + s1", "s3"])");
  EXPECT_NEAR(box->measure(box->positions), 12, 1e-12);
  EXPECT_LT(box->centroid(box->positions).distance(dealii::Point<3>(3, 3.5, 2.5)), 1e-13);
}

TEST(Hyperelastic, StiffnessOfLinearLaws)
{
  const auto neo = make_model<3>(component, ball, R"({"neo_hookean": {"shear_modulus": 0.7}})");
  EXPECT_NEAR(neo->stiffness(shaken(*neo)).reference, .7, 1e-12);
  const auto fibres =
    make_model<2>(component,
                  disc,
                  R"({"anisotropic_linear": {"stiffness": 0.3, "fibres": [["1 + s2^2", "s1"]]}})");
  EXPECT_NEAR(fibres->stiffness(shaken(*fibres)).reference, .3, 1e-12);
}

// Per present measure, fibres along a count with |F a|^2/J: shear does not stiffen those along it.
TEST(Hyperelastic, SpatialStiffnessOfShearedFibres)
{
  for (const auto &[fibre, expected] :
       std::vector<std::pair<std::string, double>>{{R"(["1", "0"])", .3},
                                                   {R"(["0", "1"])", .3 * 10}})
    {
      const auto model =
        make_model<2>(component,
                      R"({"rectangle": {"cells": [4, 4]}})",
                      R"({"anisotropic_linear": {"stiffness": 0.3, "fibres": [)" + fibre + "]}}",
                      R"("initial_position": ["s1 + 3 * s2", "s2"])");
      EXPECT_NEAR(model->stiffness(model->positions).reference, .3, 1e-12);
      EXPECT_NEAR(model->stiffness(model->positions).spatial, expected, 1e-11);
    }
}

// At F = diag(a, b), P = mu (F - F^-T): the eigenvalues are mu (1 + 1/a^2), mu (1 + 1/b^2) and, for
// shear, mu (1 +- 1/(a b)).
TEST(Hyperelastic, StiffnessOfANonlinearLaw)
{
  const auto model = make_model<2>(component,
                                   R"({"rectangle": {"cells": [4, 4]}})",
                                   stress_free,
                                   R"("initial_position": ["2 * s1", "0.5 * s2"])");
  EXPECT_NEAR(model->stiffness(model->positions).reference, 2 * (1 + 4), 1e-11);
}

TEST(Hyperelastic, InvertedElementStopsTheRun)
{
  const auto model = make_model<2>(component, disc, stress_free);
  Positions<2> X   = model->positions;
  X[0]             = dealii::Point<2>(5, 0);
  NodalField<2> f;
  try
    {
      model->load(X, f);
      FAIL() << "an inverted element was accepted";
    }
  catch (const RunFailure &failure)
    {
      EXPECT_TRUE(contains(failure.what(), "structure body: element"));
      EXPECT_TRUE(contains(failure.what(), "is inverted (det F = -"));
    }
  X[0][0] = std::nan("");
  EXPECT_THROW(model->energy(X), RunFailure);
  // Without ln J there is an energy all the same.
  X[0] = dealii::Point<2>(5, 0);
  EXPECT_NO_THROW(make_model<2>(component, disc, neo_hookean)->load(X, f));
}

namespace
{
  const std::string deviatoric = R"("deviatoric": true)";
  const std::string volumetric = R"("volumetric_modulus": 3)";
} // namespace

// One F on the unit square, so the energy is its density: |F|^2, or |F|^2/J when deviatoric, and
// k/2 (ln J)^2 with the modulus.
TEST(Hyperelastic, OptionsOfTheLawSplitShapeAndVolume)
{
  const std::string square = R"({"rectangle": {"cells": [3, 2]}})";
  const std::string map    = R"(, "initial_position": ["1.5 * s1 + 0.2 * s2", "0.9 * s2"])";
  const auto energy        = [&](const std::string &options) {
    const auto model = make_model<2>(component, square, neo_hookean, options + map);
    EXPECT_FALSE(model->linear());
    return model->energy(model->positions);
  };
  const double J = 1.5 * .9, F_squared = 1.5 * 1.5 + .2 * .2 + .9 * .9;
  const double volume = 3. / 2 * std::log(J) * std::log(J);
  EXPECT_NEAR(energy(deviatoric), F_squared / J, 1e-14);
  EXPECT_NEAR(energy(volumetric), F_squared + volume, 1e-14);
  EXPECT_NEAR(energy(deviatoric + ", " + volumetric), F_squared / J + volume, 1e-14);
}

TEST(Hyperelastic, WithoutOptionsTheLawIsAsItIs)
{
  const auto plain = make_model<2>(component, disc, neo_hookean);
  const auto off =
    make_model<2>(component, disc, neo_hookean, R"("deviatoric": false, "volumetric_modulus": 0)");
  EXPECT_TRUE(off->linear());
  EXPECT_EQ(load(*off, shaken(*off)), load(*plain, shaken(*plain)));
}

TEST(Hyperelastic, OptionsOfTheLawNeedPositiveDeterminants)
{
  const std::string mirror = R"(, "initial_position": ["-s1", "s2"])";
  for (const std::string &option : {deviatoric, volumetric})
    {
      EXPECT_TRUE(contains(error_of<2>(component, disc, neo_hookean, option + mirror),
                           "/initial_position: inverts element "));
      const auto model = make_model<2>(component, disc, neo_hookean, option);
      Positions<2> X   = model->positions;
      X[0]             = dealii::Point<2>(5, 0);
      EXPECT_THROW(load(*model, X), RunFailure);
      EXPECT_THROW(model->energy(X), RunFailure);
    }
}

// --- meshes

TEST(Hyperelastic, Meshes)
{
  const auto mesh_2 = [](const std::string &mesh, const std::string &more = "") {
    return make_model<2>(component, mesh, neo_hookean, more)->mesh();
  };
  const auto mesh_3 = [](const std::string &mesh) {
    return make_model<3>(component, mesh, neo_hookean)->mesh();
  };
  const LagrangianMesh<2> rectangle =
    mesh_2(R"({"rectangle": {"upper": [2, 1], "cells": [4, 3]}})");
  EXPECT_NEAR(check_mesh(rectangle), 2, 1e-13);
  EXPECT_EQ(rectangle.n_nodes(), 20u);
  EXPECT_EQ(rectangle.n_elements(), 24u);
  EXPECT_EQ(rectangle.faces().size(), 4 * 4 + 5 * 3 + 12u);
  EXPECT_NEAR(rectangle.diameter(), std::hypot(1. / 2, 1. / 3), 1e-14);

  const LagrangianMesh<2> glued = mesh_2(strip(8), strip_map);
  EXPECT_NEAR(check_mesh(glued, true), M_PI, 1e-13);
  EXPECT_EQ(glued.n_nodes(), 24u);
  unsigned int boundary = 0;
  for (const auto &face : glued.faces())
    boundary += face.at_boundary();
  EXPECT_EQ(boundary, 16u);

  const LagrangianMesh<2> circle = mesh_2(disc);
  EXPECT_NEAR(check_mesh(circle), 15 * std::sin(2 * M_PI / 30), 1e-13);
  EXPECT_EQ(circle.n_elements(), 6 * 25u);
  EXPECT_GT(worst_shape(circle), .6);

  EXPECT_NEAR(check_mesh(mesh_2(ring)), .5 * 17 * (2.25 - 1) * std::sin(2 * M_PI / 17), 1e-13);

  EXPECT_NEAR(check_mesh(mesh_3(R"({"box": {"upper": [1, 2, 3], "cells": [2, 2, 2]}})")), 6, 1e-13);

  double error = 1;
  for (const unsigned int refinements : {0, 1, 2, 3, 4})
    {
      const LagrangianMesh<3> mesh =
        mesh_3(R"({"ball": {"centre": [1, 2, 3], "radius": 2, "refinements": )" +
               std::to_string(refinements) + "}}");
      EXPECT_EQ(mesh.n_elements(), 20u << 3 * refinements);
      const double new_error = 1 - check_mesh(mesh) / (4. / 3 * M_PI * 8);
      EXPECT_LT(new_error, refinements == 0 ? .5 : error / 3);
      error = new_error;
      EXPECT_GT(worst_shape(mesh), .13);
      for (const auto &face : mesh.faces())
        for (unsigned int k = 0; face.at_boundary() && k < 3; ++k)
          EXPECT_NEAR(mesh.nodes()[face.nodes[k]].distance(dealii::Point<3>(1, 2, 3)), 2, 1e-13);
    }
}

// Bodies along any axis: reference coordinates are places, sides are where they should be, and a
// body is that of another axis, turned.
TEST(Hyperelastic, TubesAndCylinders)
{
  // Of a polygon in the circle of radius 1.
  const double area = .5 * 12 * std::sin(M_PI / 6), area_24 = .5 * 24 * std::sin(M_PI / 12);
  const auto mesh_3 = [](const std::string &text) {
    return LagrangianMesh<3>(make_model<3>(component, text, neo_hookean)->mesh());
  };
  for (const std::string axis : {"[0, 0, 2]", "[1, 0, 0]", "[0, -3, 0]", "[1, 2, -2]"})
    {
      const std::string common =
        R"("centre": [1, 2, 3], "length": 2, "axis": )" + axis + R"(, "cells": [24, 2, 6])";
      const LagrangianMesh<3> tube =
        mesh_3(R"({"tube": {"inner_radius": 1, "outer_radius": 1.5, )" + common + "}}");
      EXPECT_EQ(tube.n_elements(), 24 * 2 * 6 * 6u);
      EXPECT_EQ(tube.n_nodes(), 24 * 3 * 7u);
      EXPECT_EQ(tube.surface().size(), 2 * (2 * 24 * 6 + 2 * 24 * 2u));
      EXPECT_NEAR(check_mesh(tube), area_24 * (2.25 - 1) * 2, 1e-12);
      EXPECT_GT(worst_shape(tube), .2);

      const LagrangianMesh<3> solid =
        mesh_3(R"({"cylinder": {"radius": 1, "rings": 2, "layers": 4, )" +
               common.substr(0, common.find(R"(, "cells")")) + "}}");
      EXPECT_EQ(solid.n_elements(), 18 * 4 * 4u);
      EXPECT_EQ(solid.n_nodes(), 19 * 5u);
      EXPECT_NEAR(check_mesh(solid), area * 2, 1e-12);
      EXPECT_GT(worst_shape(solid), .35);

      for (const LagrangianMesh<3> *mesh : {&tube, &solid})
        {
          dealii::Tensor<1, 3> along = axis == "[0, 0, 2]"   ? dealii::Tensor<1, 3>({0, 0, 1})
                                       : axis == "[1, 0, 0]" ? dealii::Tensor<1, 3>({1, 0, 0})
                                       : axis == "[0, -3, 0]"
                                         ? dealii::Tensor<1, 3>({0, -1, 0})
                                         : dealii::Tensor<1, 3>({1., 2., -2.}) / 3.;
          const double outer         = mesh == &tube ? 1.5 : 1;
          double volume              = 0; // from the boundary
          for (const auto &facet : mesh->surface())
            {
              dealii::Tensor<2, 3> x;
              for (unsigned int k = 0; k < 3; ++k)
                x[k] = mesh->nodes()[facet[k]] - dealii::Point<3>(1, 2, 3);
              volume += determinant(x) / 6;
            }
          EXPECT_NEAR(volume, mesh == &tube ? area_24 * 2.5 : area * 2, 1e-12);
          for (const auto &node : mesh->nodes())
            {
              const dealii::Tensor<1, 3> x = node - dealii::Point<3>(1, 2, 3);
              EXPECT_LT(std::abs(x * along), 1 + 1e-14);
              EXPECT_LT((x - (x * along) * along).norm(), outer + 1e-14);
            }
        }
    }
}

// --- what a user may get wrong

TEST(Hyperelastic, SaysWhatIsWrongWithAMesh)
{
  const std::string tube = R"("inner_radius": 1, "outer_radius": 2, "length": 1)";
  const auto refused     = [](const std::string &mesh, const std::string &sentence) {
    EXPECT_TRUE(contains(error_of<3>(component, mesh, neo_hookean), sentence));
  };
  refused(R"({"tube": {)" + tube + R"(, "cells": [2, 1, 1]}})",
          "/mesh/tube/cells: needs at least 3 cells around the ring, found 2");
  refused(R"({"tube": {)" + tube + R"(, "cells": [3, 1, 1], "axis": [0, 0, 0]}})",
          "/mesh/tube/axis: must have a direction, found [0, 0, 0]");
  refused(R"({"tube": {"inner_radius": 2, "outer_radius": 2, "length": 1, "cells": [3, 1, 1]}})",
          "/mesh/tube/outer_radius: must be greater than \"inner_radius\" (2), found 2");
  refused(R"({"cylinder": {"radius": 1, "length": 1, "rings": 4000, "layers": 100}})",
          "/mesh/cylinder/layers: gives 28800 million elements");
  EXPECT_TRUE(contains(
    error_of<3>(component, R"({"rectangle": {"cells": [2, 2]}})", neo_hookean),
    "/mesh/rectangle: rectangle is a mesh of dimension 2 for dimension 2 or 2 for "
    "dimension 3; a thick "
    "body in dimension 3 needs a mesh of dimension 3: ball, box, cylinder, tube, gmsh, vtk"));
  EXPECT_TRUE(
    contains(error_of<2>(component,
                         R"({"rectangle": {"lower": [1, 1], "upper": [2, 1], "cells": [2, 2]}})",
                         neo_hookean),
             "/mesh/rectangle/upper: must be greater"));
  EXPECT_TRUE(
    contains(error_of<2>(component,
                         R"({"ring": {"inner_radius": 2, "outer_radius": 1, "cells": [9, 2]}})",
                         neo_hookean),
             "/mesh/ring/outer_radius: must be greater"));
  EXPECT_TRUE(contains(error_of<2>(component, strip(2), neo_hookean, strip_map),
                       "/mesh/periodic_strip/cells: needs at least 3"));
  EXPECT_TRUE(
    contains(error_of<2>(component, R"({"rectangle": {"cells": [100000, 100000]}})", neo_hookean),
             "/mesh/rectangle/cells: gives 20000 million elements"));
}

namespace
{
  /// A mesh of two parts, the second one moved by an initial position of its own.
  std::string
  two_parts(const std::string &first,
            const std::string &second,
            const std::string &place = R"(["s1 + 4", "s2"])")
  {
    return R"({"parts": {"meshes": [{"name": "first", "mesh": )" + first +
           R"(}, {"name": "second", "mesh": )" + second + R"(, "initial_position": )" + place +
           "}]}}";
  }

  std::string
  refined(const std::string &mesh, const std::string &longest_edge)
  {
    return R"({"refined": {"mesh": )" + mesh + R"(, "longest_edge": )" + longest_edge + "}}";
  }

  template <int dim>
  double
  longest(const StructureModel<dim> &model)
  {
    double result = 0;
    for (const auto &element : model.mesh().elements())
      result = std::max(result, element.diameter);
    return result;
  }
} // namespace


// Splitting changes neither the body nor its energy under an affine motion; seams stay seams.
TEST(Hyperelastic, RefinedMeshesAreTheSameBody)
{
  const auto check = [](const auto &coarse,
                        const auto &fine,
                        const unsigned int factor,
                        const bool straight = true) {
    EXPECT_EQ(fine->mesh().n_elements(), factor * coarse->mesh().n_elements());
    EXPECT_EQ(fine->mesh().surface().size(), factor / 2 * coarse->mesh().surface().size());
    for (unsigned int e = 0; e < fine->mesh().n_elements(); ++e)
      {
        EXPECT_EQ(fine->mesh().elements()[e].material_id,
                  coarse->mesh().elements()[e / factor].material_id);
        EXPECT_NEAR(fine->mesh().elements()[e].measure,
                    coarse->mesh().elements()[e / factor].measure / factor,
                    1e-13);
      }
    if (!straight)
      return;
    EXPECT_NEAR(fine->measure(fine->positions), coarse->measure(coarse->positions), 1e-12);
    for (const auto &model : {&*coarse, &*fine})
      for (auto &x : model->positions)
        x[0] = 1.2 * x[0] + .1 * x[1];
    EXPECT_NEAR(fine->energy(fine->positions), coarse->energy(coarse->positions), 1e-12);
  };
  const auto flat        = make_model<2>(component, ring, neo_hookean);
  const std::string half = std::to_string(.51 * longest(*flat));
  check(flat, make_model<2>(component, refined(ring, half), neo_hookean), 4);
  check(make_model<2>(component, strip(20), neo_hookean, strip_map),
        make_model<2>(
          component,
          refined(strip(20),
                  std::to_string(
                    .51 * longest(*make_model<2>(component, strip(20), neo_hookean, strip_map)))),
          neo_hookean,
          strip_map),
        4,
        false);
  // The octahedron inside a tetrahedron has a diagonal that may be longer than half an edge.
  const auto solid = make_model<3>(component, ball, neo_hookean);
  const auto fine =
    make_model<3>(component, refined(ball, std::to_string(.99 * longest(*solid))), neo_hookean);
  check(solid, fine, 8);
  EXPECT_LT(longest(*fine), .99 * longest(*solid));
  // A mesh whose elements are short enough stays as it is.
  EXPECT_EQ(make_model<2>(component, refined(disc, "10"), neo_hookean)->mesh().n_elements(),
            make_model<2>(component, disc, neo_hookean)->mesh().n_elements());
  EXPECT_TRUE(contains(error_of<2>(component, refined(disc, "1e-6"), neo_hookean),
                       "/mesh/refined/longest_edge: gives"));
  EXPECT_TRUE(contains(error_of<2>(component, refined(strip(9), "1"), neo_hookean),
                       "lacks \"initial_position\""));
}


// A structure of several parts is what its parts are by themselves; each is a material.
TEST(Hyperelastic, PartsAreMeshesOfTheirOwn)
{
  const auto both = make_model<2>(component, two_parts(disc, ring), neo_hookean);
  const auto a    = make_model<2>(component, disc, neo_hookean),
             b    = make_model<2>(component, ring, neo_hookean);
  EXPECT_EQ(both->mesh().n_nodes(), a->mesh().n_nodes() + b->mesh().n_nodes());
  EXPECT_EQ(both->mesh().material_names(),
            (LagrangianMesh<2>::MaterialNames{{"first", 0}, {"second", 1}}));
  for (unsigned int e = 0; e < both->mesh().n_elements(); ++e)
    EXPECT_EQ(both->mesh().elements()[e].material_id, e < a->mesh().n_elements() ? 0u : 1u);
  for (unsigned int i = 0; i < both->mesh().n_nodes(); ++i)
    {
      const bool first = i < a->mesh().n_nodes();
      const dealii::Point<2> expected =
        first ? a->positions[i]
              : b->positions[i - a->mesh().n_nodes()] + dealii::Tensor<1, 2>({4., 0.});
      EXPECT_LT(both->positions[i].distance(expected), 1e-14);
    }
  EXPECT_NEAR(both->measure(both->positions),
              a->measure(a->positions) + b->measure(b->positions),
              1e-12);
  EXPECT_NEAR(both->energy(both->positions),
              a->energy(a->positions) + b->energy(b->positions),
              1e-12);
}

// Corners across the seam of a glued mesh are where they were.
TEST(Hyperelastic, PartsKeepTheirSeams)
{
  const auto both = make_model<2>(component,
                                  two_parts(strip(20), disc, R"(["s1", "s2 + 9"])"),
                                  neo_hookean,
                                  strip_map);
  const auto one  = make_model<2>(component, strip(20), neo_hookean, strip_map);
  for (unsigned int e = 0; e < one->mesh().n_elements(); ++e)
    {
      EXPECT_NEAR(both->mesh().elements()[e].measure, one->mesh().elements()[e].measure, 1e-14);
      EXPECT_LT(both->mesh().elements()[e].centroid.distance(one->mesh().elements()[e].centroid),
                1e-13);
    }
}

TEST(Hyperelastic, SaysWhatIsWrongWithParts)
{
  EXPECT_TRUE(
    contains(error_of<2>(component, two_parts(disc, disc, R"(["s1 + 1", "s2"])"), neo_hookean),
             "overlap at"));
  EXPECT_TRUE(contains(error_of<2>(component, two_parts(disc, ball), neo_hookean),
                       "/mesh/parts/meshes/1/mesh/ball: ball is a mesh of dimension 3"));
  EXPECT_TRUE(contains(error_of<2>(component, two_parts(strip(9), disc), neo_hookean),
                       "/mesh/parts/meshes/0: lacks \"initial_position\""));
  EXPECT_TRUE(contains(error_of<2>(component, two_parts(disc, strip(9)), neo_hookean),
                       "/mesh/parts/meshes/1/initial_position: does not close"));
  std::string same = two_parts(disc, disc);
  same.replace(same.find("second"), 6, "first");
  EXPECT_TRUE(contains(error_of<2>(component, same, neo_hookean),
                       "/mesh/parts/meshes/1/name: found \"first\" a second time"));
}

TEST(Hyperelastic, SaysWhatIsWrongWithTheInitialPosition)
{
  EXPECT_TRUE(
    contains(error_of<2>(component, strip(8), neo_hookean), "lacks \"initial_position\""));
  EXPECT_TRUE(
    contains(error_of<2>(component, strip(8), neo_hookean, R"("initial_position": ["s1", "s2"])"),
             "/initial_position: does not close"));
  EXPECT_TRUE(
    contains(error_of<2>(component, disc, neo_hookean, R"("initial_position": ["1 / s1", "s2"])"),
             "/initial_position/0: \"1 / s1\" is inf at the reference place (0, 0)"));
  const std::string mirror = R"("initial_position": ["-s1", "s2"])";
  EXPECT_EQ(error_of<2>(component, disc, neo_hookean, mirror), "");
  const std::string message = error_of<2>(component, disc, stress_free, mirror);
  EXPECT_TRUE(contains(message, "/initial_position: inverts element "));
  EXPECT_TRUE(contains(message, "det F = -1;"));
}

TEST(Hyperelastic, SaysWhatIsWrongWithTheRest)
{
  EXPECT_THROW(registry().create<StructureModel<2>>(component,
                                                    R"({"name": "my shell", "mesh": )" + disc +
                                                      R"(, "law": )" + neo_hookean + "}"),
               Error);
  // The bad place belongs to one rank; all ranks must hear of it.
  EXPECT_TRUE(contains(
    error_of<2>(component,
                R"({"rectangle": {"cells": [1, 4]}})",
                R"({"anisotropic_linear": {"stiffness": 1, "fibres": [["s2 > 0.8 ? 0 : 1", 0]]}})"),
    "/law/anisotropic_linear/fibres/0: has no direction"));
  EXPECT_TRUE(contains(error_of<2>(component,
                                   R"({"rectangle": {"cells": [1, 4]}})",
                                   R"({"neo_hookean": {"shear_modulus": "0.8 - s2"}})"),
                       "/law/neo_hookean/shear_modulus: is -"));
}

// --- what a mesh file knows of its elements

namespace
{
  /// A square of two triangles, 7 and 9, and a line that belongs to it, 3; @p values: of 7 and 9.
  std::string
  square_with_data(const std::string &values)
  {
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
           "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n"
           "$Elements\n3\n3 1 2 1 1 1 2\n7 2 2 1 1 1 2 3\n9 2 2 2 2 1 3 4\n$EndElements\n"
           "$ElementData\n1\n\"the fibres\"\n1\n0\n3\n0\n3\n" +
           values +
           "$EndElementData\n"
           "$ElementData\n1\n\"a tensor\"\n1\n0\n3\n0\n9\n1\n7 1 2 3 4 5 6 7 8 "
           "9\n$EndElementData\n";
  }

  std::string
  fibre_law(const std::string &fibre)
  {
    return R"({"anisotropic_linear": {"stiffness": 2, "fibres": [)" + fibre + "]}}";
  }
} // namespace

TEST(Hyperelastic, FibresComeFromDataOfTheMeshFile)
{
  const TemporaryFile file(square_with_data("2\n7 1 2 0\n9 0 3 0\n"));
  const auto model     = make_model<2>(component, gmsh(file), fibre_law("\"the fibres\"")),
             same      = make_model<2>(component,
                                  gmsh(file),
                                  fibre_law("[\"if(s1 > s2, 1, 0)\", \"if(s1 > s2, 2, 3)\"]"));
  const Positions<2> X = shaken(*model, .2);
  EXPECT_GT(model->energy(X), 0);
  EXPECT_NEAR(model->energy(X), same->energy(X), 1e-14);
  const auto densities = model->energy_density(X), expected = same->energy_density(X);
  for (unsigned int e = 0; e < 2; ++e)
    EXPECT_NEAR(densities[e], expected[e], 1e-14);
}

TEST(Hyperelastic, DataThatIsNotThereIsRefused)
{
  const TemporaryFile file(square_with_data("2\n7 1 2 0\n9 0 3 0\n"));
  EXPECT_TRUE(contains(error_of<2>(component, gmsh(file), fibre_law("\"other\"")),
                       "/law/anisotropic_linear/fibres/0: names data of the mesh file, "
                       "\"other\"; its elements have \"the fibres\""));
  EXPECT_TRUE(
    contains(error_of<2>(component, disc, fibre_law("\"other\"")), "its elements have none"));
  const TemporaryFile partial(square_with_data("1\n7 1 2 0\n"));
  EXPECT_TRUE(contains(error_of<2>(component, gmsh(partial), fibre_law("\"the fibres\"")),
                       "has no direction in the structure at the reference place (0.333"));
  const TemporaryFile wrong(square_with_data("2\n7 1 2 0\n9 0 nan 0\n"));
  EXPECT_TRUE(contains(error_of<2>(component, gmsh(wrong), fibre_law("\"the fibres\"")),
                       "where a finite number is expected"));
}
