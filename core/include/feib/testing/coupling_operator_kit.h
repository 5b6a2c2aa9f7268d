// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_coupling_operator_kit_h
#define feib_testing_coupling_operator_kit_h

#include <feib/coupling_operator.h>
#include <feib/testing/examples.h>
#include <feib/testing/spaces.h>

#include <gtest/gtest.h>

#include <random>

namespace feib::testing
{
  /// Points within the elements of a mesh, as Gauss points of faces are: two in each, which ride on
  /// its nodes.
  template <int dim>
  LagrangianPoints
  points_within(const LagrangianMesh<dim> &mesh)
  {
    LagrangianPoints points;
    points.nodes_per_point = mesh.structure_dim() + 1;
    for (const auto &element : mesh.elements())
      for (const double share : {.2, .7})
        for (unsigned int k = 0; k < points.nodes_per_point; ++k)
          {
            points.node.push_back(element.nodes[k]);
            points.weight.push_back(k == 0 ? share : (1 - share) / mesh.structure_dim());
          }
    return points;
  }

  /// Every coupling: (J^T f) . v = f . (J v) to round-off, on uniform and refined meshes, periodic
  /// or not, before and after condensing, for structures of dimension m = dim and dim-1; also where
  /// they stand on a wall along which the fluid slips, in which they then stay. @p parameters:
  /// those of the component, JSON. @p within: at points within elements instead of the nodes.
  template <int dim>
  void
  check_duality(const std::string &name,
                const unsigned int m,
                const bool refined,
                const bool periodic,
                const std::string &parameters = "{}",
                const bool standing           = false,
                const bool within             = false)
  {
    SCOPED_TRACE("dim " + std::to_string(dim) + ", m " + std::to_string(m) +
                 (refined ? ", refined" : "") + (periodic ? ", periodic" : "") +
                 (standing ? ", standing on a wall" : "") + (within ? ", points within" : ""));
    const std::string cells = dim == 2 ? "[5, 4]" : "[3, 4, 3]";
    const auto space =
      make_space<dim>("{\"cells\": " + cells + (periodic ? ", \"periodic\": [\"x\"]" : "") +
                      (standing ? ", \"boundary\": {\"y_min\": {\"free_slip\": {}}}}" : "}"));
    if (refined)
      for (unsigned int i = 0; i < 2; ++i)
        refine_where(*space, [](const auto &x) { return x[0] + x[1] < 0.9; });

    // A bent patch; across the seam of the box when that is periodic, once around it when also
    // refined.
    const bool around              = periodic && refined;
    const LagrangianMesh<dim> mesh = make_simplex_mesh<dim>(m, dim == 2 ? 12 : 4);
    Positions<dim> X(mesh);
    for (unsigned int i = 0; i < X.size(); ++i)
      {
        const auto &s      = mesh.nodes()[i];
        const double turns = around ? 2 * dealii::numbers::PI * s[0] : 3 * s[0];
        X[i][0] = (periodic ? .7 : .15) + (around ? 1. : .6) * s[0] + .05 * std::sin(5 * s[1]);
        X[i][1] = .2 + .5 * s[1] + (around ? .1 + .1 * std::sin(turns) : .2 * s[0] * s[0]);
        if constexpr (dim == 3)
          X[i][2] = .3 + .4 * s[2] + .1 * std::cos(turns);
        if (standing) // but for round-off, outside and inside
          X[i][1] = s[1] > 0 ? X[i][1] - .2 : 1e-14 * (i % 3 - 1.);
      }

    const LagrangianPoints points =
      within ? points_within(mesh) : LagrangianPoints::nodes(mesh.n_nodes());
    const auto coupling = registry().create<CouplingOperator<dim>>(name, parameters);
    coupling->set_geometry(*space, mesh, X, points);

    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    VelocityVector v = space->make_velocity();
    for (dealii::types::global_dof_index i = 0; i < v.size(); ++i)
      {
        const double value = uniform(random); // the same on any number of ranks
        if (v.in_local_range(i))
          v(i) = value;
      }
    space->distribute(v, true);
    NodalField<dim> f(points), U;
    for (auto &force : f)
      for (unsigned int a = 0; a < dim; ++a)
        force[a] = uniform(random);

    coupling->interpolate(*space, v, U);
    ASSERT_EQ(U.size(), points.size());
    const double power = f * U,
                 scale = f.sum([&](const unsigned int i) { return f[i].norm() * U[i].norm(); });
    ASSERT_GT(scale, 0.1);
    for (unsigned int i = 0; standing && i < U.size(); ++i)
      EXPECT_EQ(U[i][1] == 0, mesh.nodes()[i][1] == 0) << "node " << i;
    VelocityVector load = space->make_velocity();
    coupling->spread(*space, f, load);
    EXPECT_NEAR(load * v, power, 1e-12 * scale) << "the power of J^T f on v, and of f on J v";
    space->condense(load);
    EXPECT_NEAR(load * v, power, 1e-12 * scale) << "the same after condensing";

    // The entries are those of J: applied to v and summed over the ranks they give U.
    NodalField<dim> by_entries(points);
    for (const MatrixEntry &entry : coupling->entries(*space))
      {
        ASSERT_LT(entry.row, by_entries.size() * dim);
        by_entries[entry.row / dim][entry.row % dim] +=
          entry.value * v.local_element(v.get_partitioner()->global_to_local(entry.column));
      }
    by_entries.compress(space->communicator());
    by_entries.update_ghosts();
    for (unsigned int i = 0; i < f.size(); ++i)
      for (unsigned int a = 0; a < dim; ++a)
        EXPECT_NEAR(by_entries[i][a], U[i][a], 1e-12) << "entries() of point " << i;

    // The total force arrives: the sum over a partition of unity.
    if (!periodic && !standing)
      {
        VelocityVector raw = space->make_velocity();
        coupling->spread(*space, f, raw);
        double total                     = 0;
        const dealii::Tensor<1, dim> sum = f.sum([&](const unsigned int i) { return f[i]; });
        for (unsigned int i = 0; i < raw.locally_owned_size(); ++i)
          total += raw.local_element(i);
        double expected = 0;
        for (unsigned int a = 0; a < dim; ++a)
          expected += sum[a];
        EXPECT_NEAR(dealii::Utilities::MPI::sum(total, MPI_COMM_WORLD), expected, 1e-12 * scale)
          << "the total force";
      }
  }

  /// A point outside the box, or nowhere, is refused on all ranks.
  template <int dim>
  void
  check_refuses_points_outside(const std::string &name, const std::string &parameters = "{}")
  {
    const auto space = make_space<dim>(dim == 2 ? "{\"cells\": [4, 4]}" : "{\"cells\": [2, 2, 2]}");
    const LagrangianMesh<dim> mesh = make_simplex_mesh<dim>(dim - 1, 2);
    const auto coupling            = registry().create<CouplingOperator<dim>>(name, parameters);
    for (const double bad : {1.5, std::nan("")})
      {
        Positions<dim> X(mesh);
        for (unsigned int i = 0; i < X.size(); ++i)
          for (unsigned int a = 0; a < dim; ++a)
            X[i][a] = .2 + .5 * mesh.nodes()[i][a];
        X[X.size() - 1][0] = bad;
        EXPECT_THROW(coupling->set_geometry(*space, mesh, X, LagrangianPoints::nodes(X.size())),
                     RunFailure);
      }
  }

  /// The duality of a structure of dimension m in all settings, at nodes and within elements.
  template <int dim>
  void
  check_all_dualities(const std::string &name, const unsigned int m, const std::string &parameters)
  {
    for (const bool refined : {false, true})
      {
        for (const bool periodic : {false, true})
          for (const bool within : {false, true})
            check_duality<dim>(name, m, refined, periodic, parameters, false, within);
        check_duality<dim>(name, m, refined, m == dim, parameters, true);
      }
  }
} // namespace feib::testing

/// Runs the conformance kit on the coupling operator of this name, for each example of its schema.
#define FEIB_TEST_COUPLING_OPERATOR(name)                                        \
  TEST(CouplingOperatorKit, SpreadIsTheTransposeOfInterpolate)                   \
  {                                                                              \
    feib::testing::for_each_example<feib::CouplingOperator<2>>(                  \
      name, [](const std::string &block) {                                       \
        for (const unsigned int codimension : {0, 1})                            \
          {                                                                      \
            feib::testing::check_all_dualities<2>(name, 2 - codimension, block); \
            feib::testing::check_all_dualities<3>(name, 3 - codimension, block); \
          }                                                                      \
      });                                                                        \
  }                                                                              \
  TEST(CouplingOperatorKit, RefusesPointsOutsideTheBox)                          \
  {                                                                              \
    feib::testing::for_each_example<feib::CouplingOperator<2>>(                  \
      name, [](const std::string &block) {                                       \
        feib::testing::check_refuses_points_outside<2>(name, block);             \
        feib::testing::check_refuses_points_outside<3>(name, block);             \
      });                                                                        \
  }

#endif
