// SPDX-License-Identifier: LGPL-2.1-or-later
#include "../base/elastic_structure_test.h"

using namespace feib;
using namespace feib::testing;

FEIB_TEST_STRUCTURE_MODEL("membrane");

namespace
{
  const std::string component   = "membrane";
  const std::string linear      = R"({"anisotropic_linear": {"stiffness": 2}})";
  const std::string neo_hookean = R"({"neo_hookean": {"shear_modulus": 2}})";
  const std::string circle      = R"("initial_position": ["cos(s1) + 3", "sin(s1) - 2"])";

  std::string
  curve(const unsigned int n)
  {
    return R"({"closed_curve": {"length": 6.283185307179586, "elements": )" + std::to_string(n) +
           "}}";
  }

  std::string
  sphere(const unsigned int refinements)
  {
    return R"({"sphere": {"centre": [3, 2, 1], "radius": 2, "refinements": )" +
           std::to_string(refinements) + "}}";
  }

  template <int dim>
  void
  check_force(const std::string &mesh,
              const std::string &law,
              const std::string &parameters,
              const std::string &more = "")
  {
    SCOPED_TRACE(mesh + law);
    const auto model =
      make_model<dim>(component, mesh, "{\"" + law + "\": " + parameters + "}", more);
    const Positions<dim> X  = shaken(*model);
    const NodalField<dim> f = load(*model, X);
    const NodalField<dim> expected =
      element_wise_load<dim - 1, dim>(model->mesh(), X, law, parameters);
    double difference = 0;
    for (unsigned int i = 0; i < f.size(); ++i)
      difference = std::max(difference, (f[i] - expected[i]).norm());
    EXPECT_LT(difference, 1e-13 * norm(expected));

    if (law != "mooney_rivlin_fibres") // W is quadratic: the central difference is exact
      for (unsigned int i = 0; i < X.size(); i += 3)
        for (unsigned int c = 0; c < dim; ++c)
          {
            Positions<dim> plus = X, minus = X;
            plus[i][c] += 1;
            minus[i][c] -= 1;
            EXPECT_NEAR(f[i][c],
                        -(model->energy(plus) - model->energy(minus)) / 2,
                        1e-12 * norm(f));
          }
  }
} // namespace

// Curves of one structure, each where its own initial position says, in one sense.
TEST(Membrane, PartsAreCurvesOfTheirOwn)
{
  const auto part = [](const std::string &name, const std::string &x, const std::string &mesh) {
    return R"({"name": ")" + name + R"(", "mesh": )" + mesh +
           R"j(, "initial_position": ["cos(s1) + )j" + x + R"j(", "sin(s1)"]})j";
  };
  const auto both = make_model<2>(component,
                                  R"({"parts": {"meshes": [)" + part("a", "0", curve(20)) + "," +
                                    part("b", "3", curve(40)) + "]}}",
                                  linear);
  const double pi = dealii::numbers::PI;
  EXPECT_NEAR(both->measure(both->positions),
              10 * std::sin(2 * pi / 20) + 20 * std::sin(2 * pi / 40),
              1e-12);
  for (const auto &element : both->mesh().elements())
    EXPECT_NEAR(element.measure, 2 * pi / (element.material_id == 0 ? 20 : 40), 1e-13);
  EXPECT_TRUE(both->mesh().closed());
}

// On one rank and on two: the sum over ranks and the faces change nothing.
TEST(Membrane, ForceIsElementWiseAndMinusTheGradientOfTheEnergy)
{
  check_force<2>(curve(33), "anisotropic_linear", R"({"stiffness": 2})", circle);
  check_force<2>(curve(33), "mooney_rivlin_fibres", R"({"c1": 2, "fibre_modulus": 1})", circle);
  check_force<2>(R"({"open_curve": {"length": 2, "elements": 7}})",
                 "neo_hookean",
                 R"({"shear_modulus": 2})",
                 R"("initial_position": ["s1", "s1^2"])");
  check_force<3>(sphere(1), "neo_hookean", R"({"shear_modulus": 2})");
  check_force<3>(sphere(1),
                 "anisotropic_linear",
                 R"({"stiffness": 2, "fibres": [["2 - s2", "s1 - 3", "0.5"]]})");
  check_force<3>(sphere(1),
                 "mooney_rivlin_fibres",
                 R"({"c1": 1, "c2": 2, "fibre_modulus": 3, "fibres": [["1", "s1", "s3"]]})");
}

// Nodes of a circle: two tensions kappa |dX/ds| along the chords, so the force points inwards.
TEST(Membrane, ForceOnACircle)
{
  const unsigned int n  = 24;
  const auto model      = make_model<2>(component, curve(n), linear, circle);
  const NodalField<2> f = load(*model, model->positions);
  const double h        = 2 * M_PI / n;
  for (unsigned int i = 0; i < n; ++i)
    {
      const auto normal = model->positions[i] - dealii::Point<2>(3, -2);
      EXPECT_LT((f[i] + 2 / h * (2 - 2 * std::cos(h)) * normal).norm(), 1e-13);
    }
}

TEST(Membrane, GaussRuleHasTheWorkOfTheVertexRule)
{
  const auto vertex = make_model<3>(component, sphere(1), neo_hookean);
  const auto gauss  = make_model<3>(component,
                                   sphere(1),
                                   neo_hookean,
                                   R"("face_quadrature": {"gauss": {"points": 3}})");
  EXPECT_EQ(gauss->load_points().size(), 3 * gauss->mesh().faces().size());
  const Positions<3> X   = shaken(*vertex);
  const NodalField<3> dX = random_field<3>(X.size(), 1);
  const NodalField<3> f  = load(*vertex, X);
  EXPECT_NEAR(load(*gauss, X) * at_points(gauss->load_points(), dX),
              f * dX,
              1e-13 * norm(f) * norm(dX));

  // The faces of a curve are its nodes.
  const auto point =
    make_model<2>(component, curve(9), linear, circle + R"(, "face_quadrature": {"gauss": {}})");
  EXPECT_EQ(point->load_points().nodes_per_point, 1u);
  EXPECT_EQ(point->load_points().size(), 9u);
}

TEST(Membrane, EndsOfAnOpenCurvePullAsBoundaryFaces)
{
  const std::string mesh = R"({"open_curve": {"length": 2, "elements": 5}})";
  const std::string line = R"("initial_position": ["2 * s1", "0"])";
  const auto with        = make_model<2>(component, mesh, linear, line);
  const auto without =
    make_model<2>(component, mesh, linear, line + R"(, "boundary_faces": false)");
  const NodalField<2> f = load(*with, with->positions);
  EXPECT_NEAR(f[0][0], 4, 1e-13);
  EXPECT_NEAR(f[5][0], -4, 1e-13);
  EXPECT_LT(std::abs(f[2][0]), 1e-13);
  EXPECT_LT(norm(load(*without, without->positions)), 1e-13);
}

TEST(Membrane, MeasureAndCentroid)
{
  const auto polygon = make_model<2>(component, curve(40), linear, circle);
  EXPECT_NEAR(polygon->measure(polygon->positions), 20 * std::sin(2 * M_PI / 40), 1e-13);
  EXPECT_LT(polygon->centroid(polygon->positions).distance(dealii::Point<2>(3, -2)), 1e-13);
  // Clockwise encloses the same.
  const auto clockwise =
    make_model<2>(component, curve(40), linear, R"j("initial_position": ["cos(s1)", "-sin(s1)"])j");
  EXPECT_NEAR(clockwise->measure(clockwise->positions), 20 * std::sin(2 * M_PI / 40), 1e-13);

  const auto open = make_model<2>(component,
                                  R"({"open_curve": {"length": 2, "elements": 5}})",
                                  linear,
                                  R"("initial_position": ["3 * s1", "4 * s1"])");
  EXPECT_NEAR(open->measure(open->positions), 10, 1e-13);
  EXPECT_LT(open->centroid(open->positions).distance(dealii::Point<2>(3, 4)), 1e-13);

  // An icosahedron of radius R: edge a = R / sin(2 pi / 5), volume 5 (3 + sqrt 5) a^3 / 12.
  const auto icosahedron = make_model<3>(component, sphere(0), neo_hookean);
  const double a         = 2 / std::sin(2 * M_PI / 5);
  EXPECT_NEAR(icosahedron->measure(icosahedron->positions),
              5 * (3 + std::sqrt(5.)) * a * a * a / 12,
              1e-12);
  EXPECT_LT(icosahedron->centroid(icosahedron->positions).distance(dealii::Point<3>(3, 2, 1)),
            1e-13);
}

TEST(Membrane, StiffnessOfLinearLaws)
{
  const auto polygon = make_model<2>(component, curve(40), linear, circle);
  EXPECT_NEAR(polygon->stiffness(shaken(*polygon)).reference, 2, 1e-12);
  const auto surface = make_model<3>(component, sphere(1), neo_hookean);
  EXPECT_NEAR(surface->stiffness(shaken(*surface)).reference, 2, 1e-12);
}

TEST(Membrane, ExcessMassIsDensityTimesReferenceMeasure)
{
  const auto polygon =
    make_model<2>(component, curve(40), linear, circle + ", \"excess_density\": 3");
  double length = 0, mass = 0;
  for (const auto &element : polygon->mesh().elements())
    length += element.measure;
  for (const double m : polygon->excess_mass())
    {
      EXPECT_NEAR(m, 3 * length / 40, 1e-13);
      mass += m;
    }
  EXPECT_NEAR(mass, 3 * length, 1e-12);
  EXPECT_TRUE(make_model<2>(component, curve(40), linear, circle)->excess_mass().empty());
}

/// Excess mass starts at rest or as it is told; without it there is nothing to tell.
TEST(Membrane, ExcessMassHasAVelocityOfItsOwn)
{
  const std::string velocity = ", \"initial_velocity\": [\"2*s1\", -1]";
  const auto still =
    make_model<2>(component, curve(40), linear, circle + ", \"excess_density\": 3");
  const auto moving =
    make_model<2>(component, curve(40), linear, circle + ", \"excess_density\": 3" + velocity);
  for (unsigned int i = 0; i < 40; ++i)
    {
      EXPECT_EQ(still->velocities[i].norm(), 0);
      EXPECT_NEAR(moving->velocities[i][0], 2 * moving->mesh().nodes()[i][0], 1e-14);
      EXPECT_EQ(moving->velocities[i][1], -1);
    }
  EXPECT_THROW(make_model<2>(component, curve(40), linear, circle + velocity), Error);
}

// A structure that one rank makes for itself is the whole one, and waits for nobody.
TEST(Membrane, WorksOnTheRanksItIsMadeBy)
{
  const std::string text =
    R"({"name": "body", "mesh": )" + curve(12) + R"(, "law": )" + linear + ", " + circle + "}";
  const auto shared = registry().create<StructureModel<2>>(component, text);
  const auto own    = registry().create<StructureModel<2>>(component, text, MPI_COMM_SELF);
  ASSERT_EQ(dealii::Utilities::MPI::n_mpi_processes(own->mesh().communicator()), 1u);
  EXPECT_EQ(own->mesh().local_elements(), std::make_pair(0u, 12u));
  const Positions<2> X    = shaken(*shared);
  const double expected   = shared->energy(X);
  const NodalField<2> all = load(*shared, X);
  const double kappa      = shared->stiffness(X).reference;
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) > 0)
    return;
  EXPECT_NEAR(own->energy(X), expected, 1e-14 * expected);
  const NodalField<2> mine = load(*own, X);
  for (unsigned int i = 0; i < mine.size(); ++i)
    EXPECT_LT((mine[i] - all[i]).norm(), 1e-14 * norm(all));
  EXPECT_NEAR(own->stiffness(X).reference, kappa, 1e-12 * kappa);
}

TEST(Membrane, Meshes)
{
  const LagrangianMesh<2> closed = make_model<2>(component, curve(12), linear, circle)->mesh();
  EXPECT_NEAR(check_mesh(closed, true), 2 * M_PI, 1e-13);
  EXPECT_EQ(closed.n_nodes(), 12u);
  EXPECT_TRUE(closed.closed());
  for (const auto &element : closed.elements())
    EXPECT_EQ(element.frame[0], (dealii::Tensor<1, 2>({1., 0.})));

  double error = 1;
  for (const unsigned int refinements : {0, 1, 2, 3, 4})
    {
      const LagrangianMesh<3> mesh =
        make_model<3>(component, sphere(refinements), neo_hookean)->mesh();
      EXPECT_EQ(mesh.n_elements(), 20u << 2 * refinements);
      EXPECT_TRUE(mesh.closed());
      const double new_error = 1 - check_mesh(mesh) / (16 * M_PI);
      EXPECT_LT(new_error, refinements == 0 ? .5 : error / 3);
      error = new_error;
      EXPECT_GT(worst_shape(mesh), .7);
    }
}

// Surfaces with ends, in space: their normals are where they are said to be.
TEST(Membrane, CylindersAndRectangles)
{
  const auto normal = [](const LagrangianMesh<3> &mesh, const unsigned int e) {
    const auto &facet      = mesh.surface()[e];
    const auto &x          = mesh.nodes();
    dealii::Tensor<1, 3> n = cross_product_3d(x[facet[1]] - x[facet[0]], x[facet[2]] - x[facet[0]]);
    return n / n.norm();
  };
  const LagrangianMesh<3> tube =
    make_model<3>(component,
                  R"({"cylinder": {"centre": [1, 2, 3], "radius": 2, "length": 6, "axis": [0, 5, 0],
                      "cells": [16, 8]}})",
                  neo_hookean)
      ->mesh();
  EXPECT_EQ(tube.n_elements(), 2 * 16 * 8u);
  EXPECT_EQ(tube.n_nodes(), 16 * 9u);
  EXPECT_FALSE(tube.closed());
  EXPECT_NEAR(check_mesh(tube), 6 * 16 * 4 * std::sin(M_PI / 16), 1e-12);
  EXPECT_GT(worst_shape(tube), .55); // right-angled
  for (unsigned int e = 0; e < tube.n_elements(); ++e)
    {
      dealii::Tensor<1, 3> out = tube.elements()[e].centroid - dealii::Point<3>(1, 2, 3);
      EXPECT_LT(std::abs(out[1]), 3);
      out[1] = 0;
      EXPECT_GT(normal(tube, e) * out, .99 * out.norm());
    }

  for (unsigned int a = 0; a < 3; ++a)
    {
      std::array<int, 3> upper{{2, 4, 6}};
      upper[a]        = 0;
      const auto text = [&](const int i) { return std::to_string(upper[i]); };
      const LagrangianMesh<3> sheet =
        make_model<3>(component,
                      R"({"rectangle": {"upper": [)" + text(0) + ", " + text(1) + ", " + text(2) +
                        R"(], "cells": [1, 3]}})",
                      neo_hookean)
          ->mesh();
      EXPECT_EQ(sheet.n_elements(), 6u);
      EXPECT_EQ(sheet.n_nodes(), 8u);
      EXPECT_NEAR(check_mesh(sheet), a == 0 ? 24 : a == 1 ? 12 : 8, 1e-13);
      // Three cells along the later of the two directions.
      EXPECT_NEAR(sheet.nodes()[a == 1 ? 1 : 2][a == 2 ? 1 : 2], a == 2 ? 4 / 3. : 2, 1e-14);
      for (unsigned int e = 0; e < 6; ++e)
        EXPECT_NEAR(normal(sheet, e)[a], 1, 1e-14);
    }
  EXPECT_TRUE(contains(
    error_of<3>(component, R"({"rectangle": {"upper": [1, 1, 1], "cells": [1, 1]}})", neo_hookean),
    "/mesh/rectangle/upper: must be equal to \"lower\" in one direction, that of the normal, and "
    "greater in the two others, found [1, 1, 1] and [0, 0, 0]"));
  EXPECT_TRUE(contains(
    error_of<2>(component, R"({"rectangle": {"cells": [1, 1]}})", linear),
    "/mesh/rectangle: rectangle is a mesh of dimension 2 for dimension 2 or 2 for dimension 3; a "
    "membrane in dimension 2 needs a mesh of dimension 1: closed_curve, open_curve, gmsh, vtk"));
}

// The boundary of the unit tetrahedron, its triangles turned this way and that.
TEST(Membrane, GmshSurfaceIsOriented)
{
  const TemporaryFile file(R"($MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
$EndNodes
$Elements
4
1 2 2 7 1 1 2 3
2 2 2 7 1 1 2 4
3 2 2 7 1 1 3 4
4 2 2 9 1 2 3 4
$EndElements
)");
  const auto model = make_model<3>(component, gmsh(file), neo_hookean);
  EXPECT_TRUE(model->mesh().closed());
  EXPECT_NEAR(model->measure(model->positions), 1. / 6, 1e-14);
  EXPECT_LT(model->centroid(model->positions).distance(dealii::Point<3>(.25, .25, .25)), 1e-14);
  EXPECT_EQ(model->mesh().elements()[3].material_id, 9u);
  EXPECT_TRUE(
    contains(error_of<2>(component, gmsh(file), neo_hookean),
             "holds 4 triangles; a structure of dimension 1 in dimension 2 needs segments"));
}

// Three triangles on one edge are no surface.
TEST(Membrane, GmshSurfaceMayNotBranch)
{
  const TemporaryFile file(R"($MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 0 -1 0
$EndNodes
$Elements
3
1 2 0 1 2 3
2 2 0 1 2 4
3 2 0 1 2 5
$EndElements
)");
  EXPECT_TRUE(contains(error_of<3>(component, gmsh(file), neo_hookean),
                       "3 elements share one face (elements 1, 2, 3)"));
}

TEST(Membrane, SaysWhatIsWrong)
{
  EXPECT_TRUE(contains(error_of<2>(component, sphere(1), neo_hookean),
                       "sphere is a mesh of dimension 2 for dimension 3; a membrane in dimension 2 "
                       "needs a mesh of dimension 1: closed_curve, open_curve, gmsh, vtk"));
  EXPECT_TRUE(contains(error_of<2>(component, curve(9), linear), "lacks \"initial_position\""));
  EXPECT_TRUE(
    contains(error_of<2>(component, curve(9), linear, R"("initial_position": ["s1", "0"])"),
             "/initial_position: does not close"));
  EXPECT_TRUE(contains(error_of<3>(component, sphere(1), linear), "/fibres: is empty"));
}


/// The half axes of what is enclosed, or of the curve itself.
TEST(Membrane, SecondMoments)
{
  const auto ellipse = registry().create<StructureModel<2>>(
    "membrane", R"j({"name": "a", "law": {"neo_hookean": {"shear_modulus": 1}},
    "mesh": {"closed_curve": {"length": 1, "elements": 400}},
    "initial_position": ["3 + 0.8*0.4*cos(2*pi*s1) - 0.6*0.1*sin(2*pi*s1)",
                         "7 + 0.6*0.4*cos(2*pi*s1) + 0.8*0.1*sin(2*pi*s1)"]})j");
  const auto axes = eigenvectors(ellipse->second_moments(ellipse->positions));
  EXPECT_NEAR(std::sqrt(4 * axes[0].first), .4, 1e-4);
  EXPECT_NEAR(std::sqrt(4 * axes[1].first), .1, 1e-4);
  EXPECT_NEAR(std::abs(axes[0].second[0]), .8, 1e-6);
  const auto line = registry().create<StructureModel<2>>(
    "membrane", R"j({"name": "a", "law": {"neo_hookean": {"shear_modulus": 1}},
    "mesh": {"open_curve": {"length": 1, "elements": 3}}, "initial_position": ["2 + s1", 5]})j");
  EXPECT_NEAR(line->second_moments(line->positions)[0][0], 1. / 12, 1e-14);
  const auto sphere = registry().create<StructureModel<3>>(
    "membrane", R"j({"name": "a", "law": {"neo_hookean": {"shear_modulus": 1}},
    "mesh": {"sphere": {"centre": [2, 0, 1], "radius": 0.5, "refinements": 3}},
    "initial_position": ["2 + 2*(s1 - 2)", "s2", "s3"]})j");
  const auto half = eigenvectors(sphere->second_moments(sphere->positions));
  EXPECT_NEAR(std::sqrt(5 * half[0].first), 1, .01);
  EXPECT_NEAR(std::sqrt(5 * half[2].first), .5, .005);
}
