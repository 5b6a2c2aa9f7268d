// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/coupling_operator_kit.h>

FEIB_TEST_COUPLING_OPERATOR("regularised_delta")

namespace
{
  using namespace feib;
  using feib::testing::make_space;

  const char *const kernels[] =
    {"ib_3", "ib_4", "cosine", "bspline_3", "bspline_4", "bspline_5", "bspline_6"};

  std::string
  block(const std::string &kernel, const std::string &spacing, const bool reproducing)
  {
    return "{\"kernel\": \"" + kernel + "\", \"spacing\": \"" + spacing +
           "\", \"reproducing\": " + (reproducing ? "true}" : "false}");
  }

  /// A box, all of whose sides are open.
  template <int dim>
  std::unique_ptr<EulerianSpace<dim>>
  open_space(const unsigned int cells, const bool refined, const MPI_Comm communicator)
  {
    std::string boundary, sizes;
    for (unsigned int a = 0; a < dim; ++a)
      {
        const std::string comma = a == 0 ? "" : ", ", x(1, "xyz"[a]);
        boundary +=
          comma + "\"" + x + "_min\": {\"outflow\": {}}, \"" + x + "_max\": {\"outflow\": {}}";
        sizes += comma + std::to_string(cells + a);
      }
    auto space = make_space<dim>("{\"cells\": [" + sizes + "], \"boundary\": {" + boundary + "}}",
                                 communicator);
    for (unsigned int i = 0; refined && i < 2; ++i)
      feib::testing::refine_where(*space, [](const auto &x) { return x[0] + x[1] < 0.8; });
    return space;
  }

  /// A velocity with the values of a field at all nodes.
  template <int dim, typename Field>
  VelocityVector
  nodal_values(const EulerianSpace<dim> &space, const Field &field)
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    VelocityVector u         = space.make_velocity();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < n; ++i)
        {
          dealii::Point<dim> x = space.cells()[c].lower;
          for (unsigned int a = 0, rest = i; a < dim; ++a, rest /= 3)
            x[a] += space.cells()[c].size[a] * (rest % 3) / 2.;
          for (unsigned int a = 0; a < dim; ++a)
            if (const auto dof = space.velocity_dofs(c)[a * n + i]; dof < u.locally_owned_size())
              u.local_element(dof) = field(x)[a];
        }
    space.distribute(u, false);
    return u;
  }

  template <int dim>
  dealii::Tensor<1, dim>
  linear(const dealii::Point<dim> &x)
  {
    dealii::Tensor<1, dim> u;
    for (unsigned int a = 0; a < dim; ++a)
      u[a] = 1. + a + 2 * x[a] - 3 * x[(a + 1) % dim];
    return u;
  }

  template <int dim>
  dealii::Tensor<1, dim>
  curved(const dealii::Point<dim> &x)
  {
    dealii::Tensor<1, dim> u;
    for (unsigned int a = 0; a < dim; ++a)
      u[a] = std::sin(4 * x[a] + a) * std::cos(3 * x[(a + 1) % dim]);
    return u;
  }

  /// Points from lower to upper in each direction.
  template <int dim>
  struct Points
  {
    Points(const double lower, const double upper)
      : mesh(feib::testing::make_simplex_mesh<dim>(dim, dim == 2 ? 9 : 5))
      , X(mesh)
    {
      for (unsigned int i = 0; i < X.size(); ++i)
        for (unsigned int a = 0; a < dim; ++a)
          X[i][a] = lower + (upper - lower) * mesh.nodes()[i][a];
    }

    std::unique_ptr<CouplingOperator<dim>>
    coupled(const EulerianSpace<dim> &space, const std::string &parameters) const
    {
      auto coupling =
        feib::testing::registry().create<CouplingOperator<dim>>("regularised_delta", parameters);
      coupling->set_geometry(space, mesh, X, LagrangianPoints::nodes(X.size()));
      return coupling;
    }

    /// The largest error of J u, u that of the nodes.
    template <typename Field>
    double
    error(const EulerianSpace<dim> &space, const std::string &parameters, const Field &field) const
    {
      NodalField<dim> U;
      coupled(space, parameters)->interpolate(space, nodal_values(space, field), U);
      return U.largest([&](const unsigned int i) { return (U[i] - field(X[i])).norm(); });
    }

    LagrangianMesh<dim> mesh;
    Positions<dim> X;
  };

  /// On any mesh, up to the corners of the box.
  template <int dim>
  void
  check_reproduction(const unsigned int cells)
  {
    const Points<dim> points(0, 1);
    for (const bool refined : {false, true})
      {
        const auto space = open_space<dim>(cells, refined, MPI_COMM_WORLD);
        for (const std::string kernel : {kernels[0], kernels[1], kernels[2], kernels[5]})
          for (const std::string spacing : {"nodes", "cells"})
            {
              SCOPED_TRACE(kernel + ", " + spacing + (refined ? ", refined" : ""));
              EXPECT_LT(points.error(*space, block(kernel, spacing, true), linear<dim>), 1e-11);
            }
      }
  }

  /// The sums of the rows of J, all 1, in a box that is periodic in all directions and smaller than
  /// some of the kernels.
  template <int dim>
  void
  check_sums(const std::string &domain)
  {
    const auto space = make_space<dim>(domain);
    const Points<dim> points(-.3, .9);
    for (const std::string kernel : kernels)
      for (const std::string spacing : {"nodes", "cells"})
        {
          SCOPED_TRACE(kernel + ", " + spacing);
          NodalField<dim> sums(points.mesh);
          for (const MatrixEntry &entry :
               points.coupled(*space, block(kernel, spacing, false))->entries(*space))
            sums[entry.row / dim][entry.row % dim] += entry.value;
          sums.compress(MPI_COMM_WORLD);
          sums.update_ghosts();
          for (const auto &sum : sums)
            for (unsigned int a = 0; a < dim; ++a)
              EXPECT_NEAR(sum[a], 1, 1e-12);
        }
  }

  template <int dim>
  void
  check_ranks(const unsigned int cells)
  {
    const Points<dim> points(.2, .9);
    for (const bool refined : {false, true})
      {
        NodalField<dim> U, alone;
        for (const bool all : {false, true})
          {
            const auto space =
              open_space<dim>(cells, refined, all ? MPI_COMM_WORLD : MPI_COMM_SELF);
            points.coupled(*space, "{\"reproducing\": true}")
              ->interpolate(*space, nodal_values(*space, curved<dim>), all ? U : alone);
          }
        for (unsigned int i = 0; i < U.size(); ++i)
          EXPECT_LT((U[i] - alone[i]).norm(), 1e-13);
      }
  }
} // namespace

TEST(RegularisedDelta, ReproducesLinearFieldsOnAnyMeshAndBesideWalls)
{
  check_reproduction<2>(5);
  check_reproduction<3>(2);
}

/// So do the classical kernels with no first moment, on equal cells and where no wall is near.
TEST(RegularisedDelta, KernelsWithNoFirstMomentReproduceLinearFieldsFarFromWalls)
{
  const auto space = open_space<2>(16, false, MPI_COMM_WORLD);
  const Points<2> points(.3, .7);
  for (const std::string kernel : kernels)
    for (const std::string spacing : {"nodes", "cells"})
      {
        SCOPED_TRACE(kernel + ", " + spacing);
        const double error = points.error(*space, block(kernel, spacing, false), linear<2>);
        EXPECT_EQ(error < 1e-12, kernel != "cosine") << error;
      }
}

TEST(RegularisedDelta, WeightsSumUpToOneAcrossPeriodicSides)
{
  check_sums<2>("{\"cells\": [4, 5], \"upper\": [1, 2], \"periodic\": [\"x\", \"y\"]}");
  check_sums<3>("{\"cells\": [2, 3, 2], \"periodic\": [\"x\", \"y\", \"z\"]}");
}

TEST(RegularisedDelta, DoesNotDependOnRanks)
{
  check_ranks<2>(6);
  check_ranks<3>(3);
}

/// The load of a uniform force is that of the finite element space with cells, and the same at all
/// nodes with nodes.
TEST(RegularisedDelta, AUniformForceIsSharedAsTheNodesCount)
{
  constexpr unsigned int n_cells = 4, n = EulerianSpace<2>::n_nodes;
  const auto space = make_space<2>("{\"cells\": [4, 4], \"periodic\": [\"x\", \"y\"]}");
  for (const bool of_nodes : {false, true})
    for (const std::string kernel : kernels)
      {
        SCOPED_TRACE(kernel + (of_nodes ? ", nodes" : ", cells"));
        // One point in each spacing, off the nodes; those at the upper ends are at the lower too.
        const LagrangianMesh<2> mesh =
          feib::testing::make_simplex_mesh<2>(2, of_nodes ? 2 * n_cells : n_cells);
        Positions<2> X(mesh);
        NodalField<2> f(mesh);
        for (unsigned int i = 0; i < X.size(); ++i)
          {
            const auto &s = mesh.nodes()[i];
            X[i]          = s + dealii::Point<2>(.07, .03);
            if (s[0] < 1 && s[1] < 1)
              f[i][0] = of_nodes ? .25 : 1;
          }
        const auto coupling = feib::testing::registry().create<CouplingOperator<2>>(
          "regularised_delta", block(kernel, of_nodes ? "nodes" : "cells", false));
        coupling->set_geometry(*space, mesh, X, LagrangianPoints::nodes(X.size()));
        VelocityVector load = space->make_velocity();
        coupling->spread(*space, f, load);
        space->condense(load); // nodes at one end of the box have what both have
        load.update_ghost_values();
        for (unsigned int c = 0; c < space->cells().size(); ++c)
          for (unsigned int i = 0; i < n; ++i)
            if (const auto dof = space->velocity_dofs(c)[i];
                !space->constraints().is_constrained(load.get_partitioner()->local_to_global(dof)))
              {
                const double share = (i % 3 == 1 ? 2. : 1.) * (i / 3 == 1 ? 2. : 1.) / 9;
                EXPECT_NEAR(load.local_element(dof), of_nodes ? .25 : share, 1e-12)
                  << "node " << i << " of a cell at " << space->cells()[c].lower;
              }
      }
}

/// On all ranks, whichever has the cells.
TEST(RegularisedDelta, RefusesWallsAndCellsOfOtherSizesInTheKernelsReach)
{
  const auto accepts = [](const EulerianSpace<2> &space,
                          const double lower,
                          const double upper,
                          const std::string &parameters) {
    try
      {
        Points<2>(lower, upper).coupled(space, parameters);
        return std::string();
      }
    catch (const RunFailure &failure)
      {
        return std::string(failure.what());
      }
  };
  const auto space       = open_space<2>(8, false, MPI_COMM_WORLD); // 8 and 9 cells
  const std::string wall = "nearer to a side of the box than the kernel of the coupling reaches";
  // ib_4: 4 half cells or 2 cells; where the kernel ends at the wall it is inside.
  EXPECT_EQ(accepts(*space, .25, .75, "{}"), "");
  EXPECT_NE(accepts(*space, .24, .75, "{}").find(wall), std::string::npos);
  EXPECT_NE(accepts(*space, .25, .76, "{}").find(wall), std::string::npos);
  EXPECT_EQ(accepts(*space, .125, .875, "{\"spacing\": \"nodes\"}"), "");
  EXPECT_NE(accepts(*space, .12, .5, "{\"spacing\": \"nodes\"}").find(wall), std::string::npos);
  EXPECT_EQ(accepts(*space, 0, 1, "{\"reproducing\": true}"), "");

  feib::testing::refine_where(*space, [](const auto &x) { return x[0] < .5; });
  const std::string size = "reaches cells of another size";
  EXPECT_EQ(accepts(*space, .13, .37, "{}"), "");
  EXPECT_NE(accepts(*space, .13, .38, "{}").find(size), std::string::npos);
  EXPECT_NE(accepts(*space, .74, .75, "{}").find(size), std::string::npos);
  EXPECT_EQ(accepts(*space, .75, .75, "{}"), "");
  EXPECT_EQ(accepts(*space, .13, .75, "{\"reproducing\": true}"), "");
}
