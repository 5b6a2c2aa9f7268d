// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/error.h>
#include <feib/time_integrator/geometry_iteration.h>

#include <gtest/gtest.h>

namespace
{
  using namespace feib;
  using Configuration = GeometryIteration<2>::Configuration;

  /// Two structures.
  Configuration
  start()
  {
    using Places = std::vector<dealii::Point<2>>;
    return {Positions<2>(Places{{0., 0.}, {1., 0.}, {0., 1.}}),
            Positions<2>(Places{{.5, .5}, {.2, .3}})};
  }

  /// Away from where it should be by @p slope times as much, and the other way.
  Configuration
  overshooting(Configuration G, const double slope)
  {
    unsigned int s = 0;
    for (auto &positions : G)
      {
        ++s;
        for (auto &X : positions)
          {
            const dealii::Point<2> fixed(.1 * s, .7);
            X = fixed - slope * s * (X - fixed);
          }
      }
    return G;
  }
} // namespace


TEST(GeometryIteration, ConvergesWhereRepetitionDiverges)
{
  constexpr double tolerance = 1e-9;
  GeometryIteration<2> iteration(tolerance);
  Configuration G = start();
  unsigned int n  = 0;
  while (!iteration.converged(G, overshooting(G, 3)))
    {
      G = iteration.next();
      ASSERT_LT(++n, 12u);
    }
  for (unsigned int s = 0; s < 2; ++s)
    for (const auto &X : G[s])
      EXPECT_LT(X.distance({.1 * (s + 1), .7}), tolerance);
}

TEST(GeometryIteration, WhatDoesNotExistIsNotFound)
{
  GeometryIteration<2> iteration(1e-9);
  Configuration G = start();
  try
    {
      const auto shifted = [](Configuration X) {
        X[0][0][0] += 1;
        return X;
      };
      for (unsigned int i = 0; i < 100; ++i)
        {
          ASSERT_FALSE(iteration.converged(G, shifted(G)));
          G = iteration.next();
        }
      FAIL() << "it goes on and on";
    }
  catch (const RunFailure &failure)
    {
      EXPECT_EQ(std::string(failure.what()).rfind("the geometry at the end of the step was not", 0),
                0u)
        << failure.what();
    }
}
