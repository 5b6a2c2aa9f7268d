// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kernel.h"

#include <gtest/gtest.h>

#include <cmath>

using feib::Kernel;

namespace
{
  const char *const all[] =
    {"ib_3", "ib_4", "cosine", "bspline_3", "bspline_4", "bspline_5", "bspline_6"};

  /// sum_j phi(r - j) g(r - j) over the integers.
  template <typename Function>
  double
  sum(const Kernel &phi, const double r, const Function &g)
  {
    double result = 0;
    for (int j = -5; j <= 5; ++j)
      result += phi(r - j) * g(r - j);
    return result;
  }
} // namespace

TEST(Kernel, IsEvenPositiveWithinItsRadiusAndAPartitionOfUnity)
{
  for (const char *const name : all)
    {
      SCOPED_TRACE(name);
      const Kernel phi(name);
      EXPECT_EQ(phi(phi.radius()), 0);
      EXPECT_EQ(phi(-phi.radius() - .3), 0);
      for (double r = -.5; r < .5; r += .0101)
        {
          EXPECT_NEAR(sum(phi, r, [](double) { return 1.; }), 1, 1e-13);
          for (int j = -5; j <= 5; ++j)
            {
              EXPECT_EQ(phi(r - j), phi(j - r));
              EXPECT_EQ(phi(r - j) > 0, std::abs(r - j) < phi.radius()) << r - j;
            }
        }
    }
}

TEST(Kernel, AllButTheCosineHaveNoFirstMoment)
{
  const auto first = [](const Kernel &phi) {
    double largest = 0;
    for (double r = -.5; r < .5; r += .0101)
      largest = std::max(largest, std::abs(sum(phi, r, [](const double s) { return s; })));
    return largest;
  };
  for (const char *const name : all)
    {
      const bool kept = name != std::string("cosine");
      EXPECT_EQ(first(Kernel(name)) < 1e-13, kept) << name;
    }
  EXPECT_GT(first(Kernel("cosine")), 1e-3);
}

/// What Peskin and Roma's kernels are made for: the sum of squares, and equal sums over even and
/// odd nodes.
TEST(Kernel, ThoseOfTheImmersedBoundaryMethodKeepTheirOtherConditions)
{
  for (double r = -.5; r < .5; r += .0101)
    {
      const Kernel four("ib_4"), three("ib_3");
      EXPECT_NEAR(sum(four, r, [&](const double s) { return four(s); }), 3. / 8, 1e-13);
      EXPECT_NEAR(sum(three, r, [&](const double s) { return three(s); }), 1. / 2, 1e-13);
      double even = 0;
      for (int j = -4; j <= 4; j += 2)
        even += four(r - j);
      EXPECT_NEAR(even, .5, 1e-13);
    }
}

TEST(Kernel, HasKnownValues)
{
  EXPECT_NEAR(Kernel("ib_3")(0), 2. / 3, 1e-15);
  EXPECT_NEAR(Kernel("ib_4")(0), .5, 1e-15);
  EXPECT_NEAR(Kernel("cosine")(1), .25, 1e-15);
  EXPECT_NEAR(Kernel("bspline_3")(1), 1. / 8, 1e-15);
  EXPECT_NEAR(Kernel("bspline_4")(0), 2. / 3, 1e-15);
  EXPECT_NEAR(Kernel("bspline_5")(2), 1. / 384, 1e-15);
  EXPECT_NEAR(Kernel("bspline_6")(0), 11. / 20, 1e-15);
}
