// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/spaces.h>

#include <deal.II/base/mpi.h>

#include <gtest/gtest.h>

#include <map>

namespace
{
  using namespace feib;
  using feib::testing::make_space;

  /// Splits an eighth of the cells, twice: which ones depends on their place and a seed alone.
  template <int dim>
  void
  refine_here_and_there(EulerianSpace<dim> &space, const unsigned int seed)
  {
    for (unsigned int round = 0; round < 2; ++round)
      feib::testing::refine_where(space, [&](const dealii::Point<dim> &x) {
        std::uint64_t hash = 2 * seed + round;
        for (unsigned int a = 0; a < dim; ++a)
          {
            hash = (hash ^ std::uint64_t(x[a] * 4096)) * 0xbf58476d1ce4e5b9;
            hash ^= hash >> 31;
          }
        return hash % 8 == 0;
      });
  }

  template <int dim>
  using Place = std::array<long, dim + 1>; // and the component

  /// What becomes of values that depend on the place alone: by place, in a box that is the unit
  /// cube, of the cells of this rank. Unknowns at the same place must agree.
  template <int dim, class Values>
  std::map<Place<dim>, double>
  distributed(EulerianSpace<dim> &space, const bool periodic, const Values &values)
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    const auto place_of      = [&](const unsigned int c, const unsigned int i) {
      dealii::Point<dim> x = space.cells()[c].lower;
      for (unsigned int a = 0, rest = i; a < dim; ++a, rest /= 3)
        x[a] += space.cells()[c].size[a] * (rest % 3) / 2.;
      return x;
    };
    VelocityVector v           = space.make_velocity();
    const unsigned int n_owned = v.locally_owned_size();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int a = 0; a < dim; ++a)
          if (const unsigned int dof = space.velocity_dofs(c)[a * n + i]; dof < n_owned)
            v.local_element(dof) = values(place_of(c, i), a);
    space.distribute(v, false);
    std::map<Place<dim>, double> result;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int a = 0; a < dim; ++a)
          {
            const dealii::Point<dim> x = place_of(c, i);
            Place<dim> place;
            constexpr long fine = 3840;
            for (unsigned int b = 0; b < dim; ++b)
              place[b] = std::lround(x[b] * fine) % (periodic ? fine : 2 * fine);
            place[dim]         = a;
            const double value = v.local_element(space.velocity_dofs(c)[a * n + i]);
            EXPECT_NEAR(result.emplace(place, value).first->second, value, 1e-12) << x;
          }
    return result;
  }

  /// Values at unconstrained nodes give a field that is one-valued, and the same on any number of
  /// ranks. Meshes are refined across the seam.
  template <int dim>
  void
  check_periodic(const std::string &domain)
  {
    const auto rough = [](const dealii::Point<dim> &x, const unsigned int component) {
      double result = component;
      for (unsigned int a = 0; a < dim; ++a)
        result += std::sin(50 * (a + 1.3) * std::cos(2 * dealii::numbers::PI * x[a]));
      return result;
    };
    unsigned int finest = 0;
    for (unsigned int seed = 0; seed < 6; ++seed)
      {
        SCOPED_TRACE(domain + ", seed " + std::to_string(seed));
        const auto here = make_space<dim>(domain), alone = make_space<dim>(domain, MPI_COMM_SELF);
        refine_here_and_there(*here, seed);
        refine_here_and_there(*alone, seed);
        ASSERT_EQ(here->triangulation().n_global_active_cells(),
                  alone->triangulation().n_global_active_cells());
        for (const auto &cell : alone->cells())
          finest = std::max(finest, cell.level);
        const auto values = distributed(*here, true, rough), all = distributed(*alone, true, rough);
        for (const auto &[place, value] : values)
          ASSERT_NEAR(value, all.at(place), 1e-12);
      }
    EXPECT_EQ(finest, 2u);
  }

  TEST(VelocityConstraints, ArePeriodicAcrossARefinedSeamOnAnyRanks)
  {
    check_periodic<2>(R"({"cells": [8, 6], "periodic": ["x", "y"]})");
    check_periodic<2>(R"({"cells": [2, 2], "periodic": ["x"]})");
    check_periodic<3>(R"({"cells": [4, 4, 4], "periodic": ["x", "y", "z"]})");
    check_periodic<3>(R"({"cells": [3, 2, 4], "periodic": ["x", "z"]})");
  }


  /// Hanging nodes keep what is quadratic, and so do prescribed velocities.
  template <int dim>
  void
  check_quadratic(const std::string &cells, const std::string &value)
  {
    std::string faces;
    for (const std::string direction : {"x", "y", "z"})
      if (direction != "z" || dim == 3)
        for (const std::string side : {"_min", "_max"})
          faces += (faces.empty() ? "\"" : ", \"") + direction + side +
                   "\": {\"velocity\": {\"value\": " + value + "}}";
    const auto space = make_space<dim>("{\"cells\": " + cells + ", \"boundary\": {" + faces + "}}");
    const auto quadratic = [](const dealii::Point<dim> &x, const unsigned int component) {
      return component == 0 ? x[0] * x[dim - 1] - x[1] * x[1] : component + x[0] * x[1];
    };
    for (unsigned int seed = 0; seed < 3; ++seed)
      {
        refine_here_and_there(*space, seed);
        constexpr double fine = 3840;
        for (const auto &[place, value] : distributed(*space, false, quadratic))
          {
            dealii::Point<dim> x;
            for (unsigned int a = 0; a < dim; ++a)
              x[a] = place[a] / fine;
            ASSERT_NEAR(value, quadratic(x, place[dim]), 1e-12) << x;
          }
      }
  }

  TEST(VelocityConstraints, KeepQuadraticVelocities)
  {
    check_quadratic<2>("[5, 4]", R"(["x*y - y^2", "1 + x*y"])");
    check_quadratic<3>("[3, 2, 2]", R"(["x*z - y^2", "1 + x*y", "2 + x*y"])");
  }
} // namespace
