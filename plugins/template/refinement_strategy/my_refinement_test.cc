#include <feib/refinement_strategy.h>
#include <feib/testing/spaces.h>

#include <gtest/gtest.h>

TEST(MyRefinement, HalvesTheCellsOfABall)
{
  const auto space = feib::testing::make_space<2>(R"({"cells": [4, 4]})");
  const auto strategy =
    feib::testing::registry().create<feib::RefinementStrategy<2>>("my_refinement",
                                                                  R"({"radius": 0.2})");
  EXPECT_TRUE(strategy->adapt(*space, {}));
  EXPECT_EQ(space->triangulation().n_global_active_cells(), 12u + 4 * 4);
  EXPECT_FALSE(strategy->adapt(*space, {}));
}
