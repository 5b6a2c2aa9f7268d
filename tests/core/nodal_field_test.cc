// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/lagrangian_points.h>
#include <feib/testing/spaces.h>

#include <gtest/gtest.h>

using namespace feib;

/// A node of a curve gets a part of each of the elements that meet there, wherever they are.
TEST(NodalField, CompressAddsUpWhatTheRanksHaveAdded)
{
  const LagrangianMesh<2> mesh = feib::testing::make_simplex_mesh<2>(1, 7);
  NodalField<2> lengths(mesh);
  const auto [first, last] = mesh.local_elements();
  if (dealii::Utilities::MPI::n_mpi_processes(mesh.communicator()) > 1)
    {
      ASSERT_LT(last - first, mesh.n_elements());
    }
  for (unsigned int e = first; e < last; ++e)
    for (unsigned int k = 0; k < 2; ++k)
      {
        lengths[mesh.elements()[e].nodes[k]][0] += mesh.elements()[e].measure / 2;
        lengths[mesh.elements()[e].nodes[k]][1] += 1;
      }
  lengths.compress(mesh.communicator());
  lengths.update_ghosts();
  ASSERT_EQ(lengths.size(), 8u);
  for (unsigned int i = 0; i < lengths.size(); ++i)
    {
      const bool end = i == 0 || i + 1 == lengths.size();
      EXPECT_NEAR(lengths[i][0], end ? 1. / 14 : 1. / 7, 1e-15);
      EXPECT_EQ(lengths[i][1], end ? 1 : 2);
    }
  NodalField<2> none;
  none.compress(mesh.communicator());
  EXPECT_TRUE(none.empty());
}


/// Every node counts once, on however many ranks there are copies of it.
TEST(NodalField, SumsAreOverAllNodesAndTheSameOnAllRanks)
{
  const LagrangianMesh<2> mesh = feib::testing::make_simplex_mesh<2>(2, 2);
  Positions<2> X(mesh);
  NodalField<2> f(mesh);
  for (unsigned int i = 0; i < X.size(); ++i)
    {
      X[i] = mesh.nodes()[i];
      f[i] = 2. * X[i];
    }
  EXPECT_EQ(X.sum([](unsigned int) { return 1.; }), 9);
  EXPECT_EQ(f.sum([&](const unsigned int i) { return f[i]; }), (dealii::Tensor<1, 2>({9., 9.})));
  EXPECT_EQ(f * f, 4 * 2 * 3 * 1.25);
  EXPECT_EQ(X.largest([&](const unsigned int i) { return X[i][0] - X[i][1]; }), 1);
  EXPECT_EQ(X.largest([&](const unsigned int i) { return -X[i].norm(); }), 0);
  EXPECT_EQ(Positions<2>().largest([](unsigned int) { return 1.; }),
            -std::numeric_limits<double>::infinity());
  unsigned int n_owned = 0;
  for (const unsigned int i : X.owned())
    n_owned += i < X.size();
  EXPECT_GT(n_owned, 0u);
}


TEST(NodalField, IsMadeFromMeshesPointsAndPlaces)
{
  const LagrangianMesh<3> mesh = feib::testing::make_simplex_mesh<3>(2, 2);
  const NodalField<3> zero(mesh);
  EXPECT_EQ(zero.size(), mesh.n_nodes());
  for (const auto &value : zero)
    EXPECT_EQ(value.norm(), 0);
  Positions<3> X = mesh.nodes();
  EXPECT_EQ(X[3], mesh.nodes()[3]);

  LagrangianPoints middles;
  middles.nodes_per_point = 2;
  middles.node            = {0, 1, 1, 4};
  middles.weight          = {.5, .5, .5, .5};
  EXPECT_EQ(NodalField<3>(middles).size(), 2u);
  EXPECT_EQ(middles.positions(X)[1], X[1] + (X[4] - X[1]) / 2.);

  const Positions<3> before = X;
  EXPECT_TRUE(X == before);
  X[2][1] += 1;
  EXPECT_TRUE(X != before);
}


TEST(NodalField, IsBroughtBackByAnArchive)
{
  NodalField<2> field(3), other(5);
  field[1][0]                   = .1;
  const NodalField<2> was_there = field;
  MemoryArchive archive;
  archive("field", field);
  archive.start_reading();
  archive("field", other);
  EXPECT_TRUE(other == was_there);
}
