// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/error.h>
#include <feib/lattice.h>
#include <feib/testing/spaces.h>

#include <gtest/gtest.h>

#include <set>

namespace
{
  using namespace feib;
  using feib::testing::make_space;

  /// What is said of a lattice that has no room, or nothing.
  template <int dim>
  std::string
  refusal(const Domain<dim> &box, const unsigned int halvings)
  {
    try
      {
        Lattice<dim>(box, halvings);
        return "";
      }
    catch (const RunFailure &failure)
      {
        return failure.what();
      }
  }
} // namespace


TEST(Lattice, PlacesOfPoints)
{
  const auto space =
    make_space<2>(R"({"lower": [-1, 2], "upper": [2, 3], "cells": [3, 2], "periodic": ["x"]})");
  const Lattice<2> lattice(space->domain(), 2);
  EXPECT_EQ(lattice.extent(0), 12);
  EXPECT_EQ(lattice.extent(1), 8);
  EXPECT_EQ(lattice.n_units(), 96);
  EXPECT_DOUBLE_EQ(lattice.unit()[0], .25);
  EXPECT_DOUBLE_EQ(lattice.unit()[1], .125);
  using Place = Lattice<2>::Place;
  EXPECT_EQ(lattice.unit_around({-.9, 2.99}), (Place{0, 7}));
  EXPECT_EQ(lattice.unit_around({-1.1, 3.01}), (Place{-1, 8}));
  EXPECT_EQ(lattice.nearest({2 - 1e-12, 2.125 + 1e-12}), (Place{12, 1}));

  Place place{-25, 8};
  EXPECT_FALSE(lattice.wrap(place));
  EXPECT_TRUE(lattice.wrap(place, true));
  EXPECT_EQ(place, (Place{11, 8}));
  place = {12, 0};
  EXPECT_TRUE(lattice.wrap(place));
  EXPECT_EQ(place, (Place{0, 0}));
  place = {0, -1};
  EXPECT_FALSE(lattice.wrap(place, true));
}

TEST(Lattice, KeysTellPlacesApart)
{
  // At the ends of the largest lattice there is.
  constexpr std::int64_t most = (1 << 21) - 1;
  std::set<std::uint64_t> keys;
  for (unsigned int i = 0; i < 27; ++i)
    {
      const std::int64_t line[3] = {0, 1, most};
      keys.insert(Lattice<3>::key({line[i % 3], line[i / 3 % 3], line[i / 9]}));
    }
  EXPECT_EQ(keys.size(), 27u);
}

TEST(Lattice, NoRoomForPlaces)
{
  const auto thin = make_space<3>(R"({"upper": [1, 1, 256], "cells": [1, 1, 256]})");
  EXPECT_EQ(refusal(thin->domain(), 12), "");
  EXPECT_EQ(refusal(thin->domain(), 13),
            "along z, 256 base cells of 2^13 units each are 2097152 units, which places of nodes "
            "are counted in; at most 2097151 are possible in 3D: use fewer base cells along z, or "
            "fewer levels");
  const auto flat = make_space<2>(R"({"upper": [1, 512], "cells": [1, 512]})");
  EXPECT_EQ(refusal(flat->domain(), 22), "");
  EXPECT_NE(refusal(flat->domain(), 23)
              .find("along y, 512 base cells of 2^23 units each are "
                    "4294967296 units"),
            std::string::npos);
}

TEST(Lattice, AMeshTooFineLeavesTheOneThatIs)
{
  // Level 11 has places for its nodes, level 12 has not; all ranks say so.
  const auto space = make_space<3>(R"({"upper": [1, 1, 256], "cells": [1, 1, 256]})");
  const auto halve = [&] {
    const double edge = space->smallest_edge();
    return [edge](const dealii::Point<3> &x) { return x[0] < edge && x[1] < edge && x[2] < edge; };
  };
  for (unsigned int level = 1; level <= 11; ++level)
    feib::testing::refine_where(*space, halve());
  EXPECT_EQ(space->smallest_edge(), std::ldexp(1., -11));
  EXPECT_EQ(space->lattice().extent(2), 1 << 20);
  const unsigned int revision = space->revision(), n_dofs = space->velocity_handler().n_dofs();
  EXPECT_THROW(feib::testing::refine_where(*space, halve()), RunFailure);
  EXPECT_EQ(space->revision(), revision);
  EXPECT_EQ(space->velocity_handler().n_dofs(), n_dofs);
  EXPECT_EQ(space->smallest_edge(), std::ldexp(1., -11));
}
