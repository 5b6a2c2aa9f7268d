// SPDX-License-Identifier: LGPL-2.1-or-later
#include "surface.h"

#include <feib/testing/spaces.h>
#include <feib/testing/structure_force_kit.h>

FEIB_TEST_STRUCTURE_FORCE("contact");

namespace
{
  using namespace feib;
  using feib::testing::derivative;
  using feib::testing::make_space;
  using feib::testing::registry;

  const std::string open_box =
    R"("boundary": {"x_min": {"outflow": {}}, "x_max": {"outflow": {}}})";

  /// A structure in a box, with contact.
  template <int dim>
  struct Setting
  {
    std::unique_ptr<StructureModel<dim>> model;
    std::unique_ptr<EulerianSpace<dim>> space;
    std::unique_ptr<StructureForce<dim>> force;

    Setting(const std::string &kind,
            const std::string &mesh,
            const std::string &contact,
            const std::string &domain = "")
      : model(registry().create<StructureModel<dim>>(
          kind,
          R"({"name": "s", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": )" + mesh + "}"))
      , space(
          make_space<dim>(std::string(dim == 2 ? R"({"cells": [4, 4])" : R"({"cells": [2, 2, 2])") +
                          (domain.empty() ? "" : ", ") + domain + "}"))
      , force(registry().create<StructureForce<dim>>("contact", contact))
    {
      force->attach({model->mesh(), model->positions, {}, {0.}, space->domain()});
    }

    NodalField<dim>
    load(const Positions<dim> &X) const
    {
      NodalField<dim> result(model->mesh());
      force->load(X, result);
      return result;
    }
  };

  /// b(r), as its definition says.
  double
  barrier(const double r)
  {
    return -std::pow(1 - r, 2) * std::log(r);
  }

  std::string
  part(const std::string &name, const std::string &mesh, const std::string &place = "")
  {
    return R"({"name": ")" + name + R"(", "mesh": )" + mesh +
           (place.empty() ? "" : R"(, "initial_position": )" + place) + "}";
  }

  std::string
  parts(const std::string &first, const std::string &second)
  {
    return R"({"parts": {"meshes": [)" + first + ", " + second + "]}}";
  }

  const std::string two_discs =
    parts(part("left", R"({"disc": {"centre": [0.3, 0.5], "radius": 0.15, "rings": 3}})"),
          part("right", R"({"disc": {"centre": [0.62, 0.53], "radius": 0.15, "rings": 4}})"));
  const std::string two_spheres =
    parts(part("left",
               R"({"sphere": {"centre": [0.3, 0.5, 0.5], "radius": 0.15, "refinements": 1}})"),
          part("right",
               R"({"sphere": {"centre": [0.62, 0.53, 0.51], "radius": 0.15, "refinements": 2}})"));

  /// A curve like a hairpin.
  const std::string hairpin =
    parts(part("pin",
               R"({"open_curve": {"length": 1, "elements": 21}})",
               R"j(["0.8 - abs(s1 - 0.5)", "0.5 + 0.06 * tanh(8*(s1 - 0.5))"])j"),
          part("far", R"({"open_curve": {"length": 0.1, "elements": 1}})", R"(["0.1 + s1", 0.1])"));

  template <int dim>
  Positions<dim>
  shaken(const Positions<dim> &X, const double size)
  {
    std::mt19937 generator(5);
    std::uniform_real_distribution<double> number(-size, size);
    Positions<dim> Y = X;
    for (auto &x : Y)
      for (unsigned int a = 0; a < dim; ++a)
        x[a] += number(generator);
    return Y;
  }

  /// Load, derivative and entries are those of the energy; without walls nothing is left in sum.
  template <int dim>
  void
  expect_exact(const Setting<dim> &setting)
  {
    const Positions<dim> X = shaken(setting.model->positions, 4e-3);
    ASSERT_GT(setting.force->energy(X), 1e-6);
    NodalField<dim> way(setting.model->mesh());
    for (unsigned int i = 0; i < way.size(); ++i)
      way[i] = 1e-2 * (shaken(X, 1.)[i] - X[i]);
    const auto moved = [&](const double t) {
      Positions<dim> Y = X;
      for (unsigned int i = 0; i < Y.size(); ++i)
        Y[i] += t * way[i];
      return Y;
    };
    const auto load = setting.load(X);
    EXPECT_NEAR(load * way,
                -derivative([&](const double t) { return setting.force->energy(moved(t)); }, 1e-3),
                1e-8 * std::sqrt((load * load) * (way * way)));
    NodalField<dim> change(setting.model->mesh()), product(setting.model->mesh());
    setting.force->load_derivative(X, way, change);
    const double scale = std::sqrt(change * change);
    EXPECT_NEAR(change * way,
                derivative([&](const double t) { return setting.load(moved(t)) * way; }, 1e-4),
                1e-6 * scale * std::sqrt(way * way));
    MatrixEntries entries;
    setting.force->tangent(X, entries);
    for (const auto &entry : entries)
      product[entry.row / dim][entry.row % dim] -=
        entry.value * way[entry.column / dim][entry.column % dim];
    product.compress(setting.model->mesh().communicator());
    for (unsigned int i = 0; i < product.size(); ++i)
      EXPECT_LT((product[i] - change[i]).norm(), 1e-12 * scale);

    dealii::Tensor<1, dim> force;
    dealii::Tensor<2, dim> torque;
    for (unsigned int i = 0; i < load.size(); ++i)
      {
        force += load[i];
        torque += outer_product(load[i], X[i]) - outer_product(X[i], load[i]);
      }
    EXPECT_LT(force.norm(), 1e-14 * std::max(1., std::sqrt(load * load)));
    EXPECT_LT(torque.norm(), 1e-14 * std::max(1., std::sqrt(load * load)));
  }

  template <int dim>
  std::string
  refusal(const std::string &kind,
          const std::string &mesh,
          const std::string &contact,
          const std::string &domain = "")
  {
    try
      {
        Setting<dim>(kind, mesh, contact, domain);
      }
    catch (const Error &error)
      {
        return error.what();
      }
    return "none";
  }

  /// What is said of a step to other positions.
  template <int dim>
  std::string
  failure(const Setting<dim> &setting, const Positions<dim> &X)
  {
    try
      {
        setting.force->update_state(X);
      }
    catch (const RunFailure &failure)
      {
        return failure.what();
      }
    return "none";
  }
} // namespace


TEST(Contact, ExactAndWithoutForceOrTorqueInSum)
{
  const std::string contact = R"({"range": 0.06, "strength": 2, "walls": false})";
  expect_exact(Setting<2>("hyperelastic", two_discs, contact));
  expect_exact(Setting<3>("membrane", two_spheres, contact));
  expect_exact(
    Setting<2>("membrane",
               hairpin,
               R"({"range": 0.14, "strength": 2, "self_distance": 0.3, "walls": false})"));
}


/// Two parallel sheets are pressed apart by k d b(gap/d) for each measure of each, whatever their
/// elements: what facets, edges and vertices give adds up to one.
TEST(Contact, EnergyDoesNotDependOnTheMesh)
{
  const std::string contact = R"({"range": 0.2, "strength": 3, "walls": false})";
  const double expected     = 2 * 3 * .2 * barrier(.5);
  for (const std::string n : {"5", "16"})
    {
      const Setting<2> curves(
        "membrane",
        parts(part("a", R"({"open_curve": {"length": 0.5, "elements": 9}})", "[\"0.2 + s1\", 0.4]"),
              part("b",
                   R"({"open_curve": {"length": 0.5, "elements": )" + n + "}}",
                   "[\"0.2 + s1\", 0.5]")),
        contact);
      EXPECT_NEAR(curves.force->energy(curves.model->positions), .5 * expected, 1e-12);
      const Setting<3> sheets(
        "membrane",
        parts(part("a",
                   R"({"rectangle": {"lower": [0.2, 0.2, 0.4], "upper": [0.7, 0.7, 0.4],
                                     "cells": [3, 5]}})"),
              part("b",
                   R"({"rectangle": {"lower": [0.2, 0.2, 0.5], "upper": [0.7, 0.7, 0.5],
                                     "cells": [4, )" +
                     n + "]}}")),
        contact);
      EXPECT_NEAR(sheets.force->energy(sheets.model->positions), .25 * expected, 1e-12);
    }
}


TEST(Contact, WallsRepelWhatDoesNotStandOnThem)
{
  const std::string contact = R"({"range": 0.1, "strength": 3})";
  const auto energy         = [&](const std::string &lower, const std::string &domain) {
    const Setting<2> setting("hyperelastic",
                             R"({"rectangle": {"lower": [)" + lower +
                               R"(, 0.4], "upper": [0.6, 0.6], "cells": [5, 3]}})",
                             contact,
                             domain);
    return setting.force->energy(setting.model->positions);
  };
  // The side, and what the corners' nodes stand for of the sides across.
  EXPECT_NEAR(energy("0.05", ""), 3 * .1 * (.2 + .11) * barrier(.5), 1e-12);
  EXPECT_EQ(energy("0", ""), 0);
  EXPECT_EQ(energy("0.05", open_box), 0);
  EXPECT_EQ(energy("0.05", R"("periodic": ["x"])"), 0);
}


/// Across a periodic direction the image that is nearest counts, of a part itself too.
TEST(Contact, ImagesRepel)
{
  const auto energy = [](const std::string &x1, const std::string &x2, const std::string &domain) {
    const Setting<2> setting(
      "hyperelastic",
      parts(part("a", R"({"disc": {"centre": [)" + x1 + R"(, 0.5], "radius": 0.1, "rings": 3}})"),
            part("b", R"({"disc": {"centre": [)" + x2 + R"(, 0.5], "radius": 0.1, "rings": 3}})")),
      R"({"range": 0.1, "strength": 2, "walls": false})",
      domain);
    return setting.force->energy(setting.model->positions);
  };
  const double beside = energy("0.4", "0.65", "");
  EXPECT_GT(beside, 1e-4);
  EXPECT_EQ(energy("0.11", "0.86", ""), 0);
  EXPECT_NEAR(energy("0.11", "0.86", R"("periodic": ["x"])"), beside, 1e-12);

  const Setting<2> long_one("hyperelastic",
                            R"({"rectangle": {"lower": [0.02, 0.4], "upper": [0.97, 0.6],
                                              "cells": [20, 4]}})",
                            R"({"range": 0.1, "strength": 2})",
                            R"("periodic": ["x"])");
  EXPECT_NEAR(long_one.force->energy(long_one.model->positions),
              2 * 2 * .1 * (.2 + .0475) * barrier(.5),
              1e-5);
}


/// A step that brought one part through another fails, whatever it looks like at its end.
TEST(Contact, NothingPasses)
{
  const std::string contact = R"({"range": 0.06, "strength": 2})";
  const Setting<2> discs("hyperelastic", two_discs, contact);
  const auto part_of        = discs.model->mesh().parts();
  Positions<2> X            = discs.model->positions;
  const unsigned int n_left = X.size() - (1 + 3 * 4 * 5);
  const auto left_by        = [&](const double x, const double y) {
    Positions<2> Y = X;
    for (unsigned int i = 0; i < n_left; ++i)
      Y[i] += dealii::Tensor<1, 2>({x, y});
    return Y;
  };
  EXPECT_EQ(failure(discs, left_by(.005, 0)), "none");
  EXPECT_EQ(failure(discs, left_by(0, .3)), "none");
  EXPECT_EQ(failure(discs, left_by(0, 0)), "none");
  EXPECT_NE(failure(discs, left_by(.05, 0)).find("have passed through each other"),
            std::string::npos);
  EXPECT_NE(failure(discs, left_by(.5, 0)).find("have passed through each other"),
            std::string::npos); // it is clear of the other one again
  EXPECT_NE(failure(discs, left_by(-.3, 0)).find("has passed through the wall x_min"),
            std::string::npos);

  // What failed is no new place: the way back is none.
  EXPECT_EQ(failure(discs, left_by(0, 0)), "none");

  // Edges in space meet where no node meets a facet.
  const Setting<3> sheets(
    "membrane",
    parts(part("a",
               R"({"rectangle": {"lower": [0.2, 0.2, 0.4], "upper": [0.7, 0.7, 0.4],
                                 "cells": [1, 1]}})"),
          part("b",
               R"({"rectangle": {"lower": [0.66, 0.1, 0.5], "upper": [0.74, 0.9, 0.5],
                                 "cells": [1, 1]}})")),
    contact);
  Positions<3> Y = sheets.model->positions;
  EXPECT_EQ(failure(sheets, Y), "none");
  for (unsigned int i = 4; i < 8; ++i)
    Y[i][2] -= .15;
  EXPECT_NE(failure(sheets, Y).find("have passed through each other"), std::string::npos);
}


TEST(Contact, ThePlacesOfAStepAreArchived)
{
  const Setting<2> discs("hyperelastic", two_discs, R"({"range": 0.06, "strength": 2})");
  MemoryArchive before;
  before.start_writing();
  discs.force->archive(before);
  Positions<2> X = discs.model->positions;
  for (auto &x : X)
    x[1] += .2;
  EXPECT_EQ(failure(discs, X), "none");
  const std::string other_way = "has passed through the wall y_max";
  for (auto &x : X)
    x[1] += .2;
  EXPECT_NE(failure(discs, X).find(other_way), std::string::npos);
  before.start_reading();
  discs.force->archive(before);
  EXPECT_EQ(failure(discs, discs.model->positions), "none");
}


/// Pairs that are looked at grow as the nodes do, between curves and within one.
TEST(Contact, SearchIsLinear)
{
  std::vector<double> per_node;
  for (const unsigned int n : {100u, 200u, 400u, 800u})
    {
      const std::string mesh =
        R"({"closed_curve": {"length": 1, "elements": )" + std::to_string(n) + "}}";
      const auto model = registry().create<StructureModel<2>>(
        "membrane",
        R"({"name": "s", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": )" +
          parts(part("a", mesh, R"j(["0.5 + 0.2*cos(2*pi*s1)", "0.5 + 0.2*sin(2*pi*s1)"])j"),
                part("b", mesh, R"j(["0.5 + 0.201*cos(2*pi*s1)", "0.5 + 0.201*sin(2*pi*s1)"])j")) +
          "}");
      const auto space = make_space<2>(R"({"cells": [4, 4]})");
      const ContactSurface<2> surface(model->mesh(), model->positions, space->domain(), 8. / n);
      unsigned int n_near = 0;
      const std::size_t all =
        surface.for_each_near(model->positions, 4. / n, [&](const auto &...) { ++n_near; });
      EXPECT_GT(n_near, n == 100 ? 2 * n : 0);
      per_node.push_back(double(all) / surface.nodes.size());
    }
  for (unsigned int k = 1; k < per_node.size(); ++k)
    EXPECT_LT(per_node[k], 1.1 * per_node[k - 1]);
  EXPECT_LT(per_node[0], 50);
}


TEST(Contact, WhatWillNotDo)
{
  const std::string crossing =
    parts(part("a", R"({"disc": {"centre": [0.3, 0.5], "radius": 0.15, "rings": 3}})"),
          part("b", R"({"disc": {"centre": [0.595, 0.5], "radius": 0.15, "rings": 3}})"));
  EXPECT_NE(refusal<2>("hyperelastic", crossing, R"({"range": 0.05, "strength": 1})")
              .find("crosses itself at the start, between node"),
            std::string::npos);
  EXPECT_EQ(refusal<2>("hyperelastic", two_discs, R"({"range": 0.05, "strength": 1})"), "none");
  EXPECT_NE(refusal<2>("hyperelastic",
                       two_discs,
                       R"({"range": 0.05, "strength": 1, "self_distance": 0.09})")
              .find("must be at least 2 ranges, 0.1"),
            std::string::npos);
  EXPECT_NE(refusal<2>(
              "hyperelastic", two_discs, R"({"range": 0.3, "strength": 1})", R"("periodic": ["y"])")
              .find("at most a quarter of the box in a periodic direction, 0.25"),
            std::string::npos);
}
