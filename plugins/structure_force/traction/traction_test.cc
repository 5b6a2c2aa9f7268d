// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/structure_force_kit.h>

FEIB_TEST_STRUCTURE_FORCE("traction");

namespace
{
  using namespace feib;
  using feib::testing::registry;
  using feib::testing::structure_for_forces;

  template <int dim>
  NodalField<dim>
  load(const StructureModel<dim> &model, const std::string &traction)
  {
    const auto force = registry().create<StructureForce<dim>>("traction", traction);
    const auto box   = feib::testing::unit_box<dim>();
    force->attach({model.mesh(), model.positions, {}, {0.}, box});
    NodalField<dim> result(model.mesh());
    force->load(model.positions, result);
    force->external_load(model.positions, result);
    return result;
  }

  /// sum_i load_i . X_i
  template <int dim>
  double
  virial(const StructureModel<dim> &model, const std::string &traction)
  {
    const NodalField<dim> f = load(model, traction);
    return f.sum([&](const unsigned int i) -> double {
      return f[i] * dealii::Tensor<1, dim>(model.positions[i]);
    });
  }
} // namespace


/// A pressure on all of a closed surface: no force in sum, and - p dim V as its virial, so that it
/// pushes inward from outside whatever the kind of structure.
TEST(Traction, PressureOnClosedSurfaces)
{
  for (const char *kind : {"closed curve", "body"})
    {
      const auto model           = structure_for_forces<2>(registry(), kind);
      const std::string traction = R"({"pressure": 3, "on": {"boundary": )" +
                                   std::string(*kind == 'b' ? "true" : "false") + "}}";
      EXPECT_NEAR(virial(*model, traction), -3 * 2 * model->measure(model->positions), 1e-12)
        << kind;
      const NodalField<2> f = load(*model, traction);
      EXPECT_LT(f.sum([&](const unsigned int i) { return f[i]; }).norm(), 1e-14) << kind;
    }
  for (const char *kind : {"surface", "body"})
    {
      const auto model           = structure_for_forces<3>(registry(), kind);
      const std::string traction = R"({"pressure": 3, "on": {"boundary": )" +
                                   std::string(*kind == 'b' ? "true" : "false") + "}}";
      EXPECT_NEAR(virial(*model, traction), -3 * 3 * model->measure(model->positions), 1e-12)
        << kind;
      const NodalField<3> f = load(*model, traction);
      EXPECT_LT(f.sum([&](const unsigned int i) { return f[i]; }).norm(), 1e-14) << kind;
    }
}


/// A dead load in sum: that per measure times the measure.
TEST(Traction, DeadLoadsAddUp)
{
  const auto total = [](const auto &model, const std::string &traction) {
    const auto f = load(model, traction);
    return f.sum([&](const unsigned int i) { return f[i]; });
  };
  const auto curve = structure_for_forces<2>(registry(), "open curve");
  EXPECT_NEAR(total(*curve, R"({"force": [2, -1]})")[0], 2, 1e-13);
  EXPECT_NEAR(total(*curve, R"({"force": [2, -1], "on": {"boundary": true}})")[1], -2, 1e-13);
  EXPECT_NEAR(total(*curve,
                    R"({"force": [2, -1], "on": {"boundary": true, "where": "s1 > 0.5"}})")[1],
              -1,
              1e-13);
  const auto body  = structure_for_forces<2>(registry(), "body");
  double perimeter = 0;
  for (const auto &facet : body->mesh().surface())
    perimeter += body->positions[facet[0]].distance(body->positions[facet[1]]);
  EXPECT_NEAR(total(*body, R"({"force": [2, -1], "on": {"boundary": true}})")[0],
              2 * perimeter,
              1e-13);
  EXPECT_NEAR(total(*body, R"({"force": [2, -1]})")[0], 2 * body->measure(body->positions), 1e-13);
}


/// A load on an end of a body is that on the faces of the end, without a share of the faces beside.
TEST(Traction, DeadLoadsActOnWholeFaces)
{
  const auto body = structure_for_forces<2>(registry(), "body");
  double highest  = -1e300;
  for (const auto &node : body->mesh().nodes())
    highest = std::max(highest, node[1]);
  const auto chosen = [&](const unsigned int i) {
    return body->mesh().nodes()[i][1] > highest - .1;
  };
  double part = 0, all = 0;
  for (const auto &facet : body->mesh().surface())
    {
      const double length = body->mesh().nodes()[facet[0]].distance(body->mesh().nodes()[facet[1]]);
      all += length;
      if (chosen(facet[0]) && chosen(facet[1]))
        part += length;
    }
  ASSERT_GT(part, 0);
  ASSERT_LT(part, all);
  const NodalField<2> f = load(*body,
                               R"({"force": [0, -1], "on": {"boundary": true, "where": "s2 > )" +
                                 std::to_string(highest - .1) + "\"}}");
  EXPECT_NEAR(f.sum([&](const unsigned int i) { return f[i]; })[1], -part, 1e-13);
}


TEST(Traction, WhatWillNotDo)
{
  const auto refusal = [](const std::string &kind, const std::string &traction) {
    const auto model = structure_for_forces<2>(registry(), kind);
    try
      {
        load(*model, traction);
      }
    catch (const Error &error)
      {
        return std::string(error.what());
      }
    return std::string("none");
  };
  EXPECT_NE(refusal("body", R"({"pressure": 1})").find("boundary faces of a body"),
            std::string::npos);
  EXPECT_NE(refusal("body", "{}").find("neither \"force\" nor \"pressure\""), std::string::npos);
  EXPECT_NE(refusal("closed curve", R"({"force": [1, 0], "on": {"boundary": true}})")
              .find("the structure is closed and has no boundary"),
            std::string::npos);
  EXPECT_NE(refusal("body", R"({"force": [1, 0], "on": {"where": "s1 > 9"}})")
              .find("selects no node of the structure"),
            std::string::npos);
  EXPECT_NE(refusal("body", R"({"force": [1, 0], "on": {"materials": [3]}})")
              .find("found 3, but no element of the structure has this material"),
            std::string::npos);
  EXPECT_NE(
    refusal("body", R"j({"force": [1, 0], "on": {"where": "1/(s1 - 0.5)"}})j").find("finite"),
    std::string::npos);
  EXPECT_EQ(refusal("body", R"j({"force": ["log(0.5 - t)", 0]})j"), "none");
  EXPECT_NE(refusal("body", R"({"force": [1, 0], "on": {"materials": [0, "skin"]}})")
              .find("found \"skin\"; the materials of the mesh have no names"),
            std::string::npos);
}
