// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/refinement_strategy_kit.h>

#include <gtest/gtest.h>

FEIB_TEST_REFINEMENT_STRATEGY("uniform");

namespace
{
  using namespace feib;

  template <int dim>
  void
  check(const unsigned int levels, const unsigned int n_cells)
  {
    const auto space =
      feib::testing::make_space<dim>(dim == 2 ? R"({"cells": [3, 2]})" : R"({"cells": [3, 2, 1]})");
    const auto strategy = feib::testing::registry().create<RefinementStrategy<dim>>(
      "uniform", "{\"levels\": " + std::to_string(levels) + "}");
    EXPECT_EQ(strategy->adapt(*space, {}), levels > 0);
    EXPECT_EQ(space->triangulation().n_global_active_cells(), n_cells);
    for (const auto &cell : space->cells())
      EXPECT_EQ(cell.level, levels);
    EXPECT_FALSE(strategy->adapt(*space, {}));
    EXPECT_EQ(strategy->interval(), 0u);
  }

  TEST(Uniform, HalvesEveryCell)
  {
    check<2>(0, 6);
    check<2>(3, 6 * 64);
    check<3>(2, 6 * 64);
  }

  TEST(Uniform, DoesNothingUnlessTold)
  {
    const auto space    = feib::testing::make_space<2>(R"({"cells": [3, 2]})");
    const auto strategy = feib::testing::registry().create<RefinementStrategy<2>>("uniform");
    EXPECT_FALSE(strategy->adapt(*space, {}));
  }
} // namespace
