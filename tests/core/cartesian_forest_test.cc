// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/spaces.h>

#include <gtest/gtest.h>

#include <random>

namespace
{
  using namespace feib;

  /// The pieces of a facet lie in their cells, where the facet is, and make up the facet.
  template <int dim>
  void
  check_cut(const EulerianSpace<dim> &space, const std::array<dealii::Point<dim>, dim> &facet)
  {
    double part = 0;
    space.forest().cut(facet, [&](const unsigned int c, const auto &piece) {
      ASSERT_LT(c, space.cells().size());
      ASSERT_GE(piece.size(), dim);
      const auto &cell = space.cells()[c];
      for (const auto &corner : piece)
        {
          double sum = 0;
          dealii::Point<dim> x;
          for (unsigned int k = 0; k < dim; ++k)
            {
              sum += corner.barycentric[k];
              x += corner.barycentric[k] * facet[k];
              EXPECT_GT(corner.barycentric[k], -1e-13);
            }
          EXPECT_NEAR(sum, 1, 1e-13);
          for (unsigned int a = 0; a < dim; ++a)
            {
              EXPECT_GT(corner.unit[a], -1e-13);
              EXPECT_LT(corner.unit[a], 1 + 1e-13);
              const double length = space.domain().upper[a] - space.domain().lower[a];
              double distance     = cell.lower[a] + corner.unit[a] * cell.size[a] - x[a];
              if (space.domain().periodic(a))
                distance -= length * std::round(distance / length);
              EXPECT_NEAR(distance, 0, 1e-13);
            }
        }
      for (unsigned int s = 1; s + dim <= piece.size() + 1; ++s)
        {
          dealii::Tensor<2, dim> barycentric;
          for (unsigned int v = 0; v < dim; ++v)
            for (unsigned int w = 0; w < dim; ++w)
              barycentric[v][w] = piece[v == 0 ? 0 : s + v - 1].barycentric[w];
          part += std::abs(determinant(barycentric));
        }
    });
    EXPECT_NEAR(dealii::Utilities::MPI::sum(part, MPI_COMM_WORLD), 1, 1e-12);
  }

  template <int dim>
  void
  check_cuts(const bool periodic)
  {
    SCOPED_TRACE("dim " + std::to_string(dim));
    const std::string cells = dim == 2 ? "\"cells\": [5, 4]" : "\"cells\": [3, 4, 3]";
    const auto space =
      feib::testing::make_space<dim>("{" + cells + (periodic ? ", \"periodic\": [\"x\"]}" : "}"));
    for (unsigned int i = 0; i < 2; ++i)
      feib::testing::refine_where(*space, [](const auto &x) { return x[0] + x[1] < .9; });
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::uniform_int_distribution<int> lattice(0, 12);
    std::array<dealii::Point<dim>, dim> facet;
    for (unsigned int sample = 0; sample < 400; ++sample)
      {
        // Anywhere; corners of cells; in the plane of a face; on an edge of the box.
        for (auto &corner : facet)
          for (unsigned int a = 0; a < dim; ++a)
            corner[a] = sample % 2 == 0 ? uniform(random) : lattice(random) / 12.;
        if (sample % 4 >= 2)
          for (auto &corner : facet)
            corner[sample / 4 % dim] = facet[0][sample / 4 % dim];
        if (periodic)
          for (auto &corner : facet)
            corner[0] += int(sample % 5) - 2;
        double size = 0;
        for (const auto &corner : facet)
          size = std::max(size, corner.distance(facet[0]));
        if (size == 0)
          continue;
        check_cut<dim>(*space, facet);
      }
  }
} // namespace

TEST(CartesianForest, PiecesMakeUpTheFacet)
{
  for (const bool periodic : {false, true})
    {
      check_cuts<2>(periodic);
      check_cuts<3>(periodic);
    }
}
