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
  using Place = std::array<long, dim + 1>; // in the unit cube, and the component

  template <int dim>
  Place<dim>
  place_of(const EulerianSpace<dim> &space,
           const dealii::Point<dim> &x,
           const unsigned int component)
  {
    constexpr long fine = 3840; // quarters of the finest cells are integers
    Place<dim> place;
    for (unsigned int a = 0; a < dim; ++a)
      {
        place[a] = std::lround(x[a] * fine);
        EXPECT_NEAR(place[a], x[a] * fine, 1e-9);
        if (space.domain().periodic(a))
          place[a] %= fine;
      }
    place[dim] = component;
    return place;
  }

  /// The place @p i, lexicographic, of those that divide a cell into @p parts in each direction.
  template <int dim>
  dealii::Point<dim>
  point_of(const EulerianSpace<dim> &space,
           const unsigned int c,
           const unsigned int parts,
           unsigned int i)
  {
    dealii::Point<dim> x = space.cells()[c].lower;
    for (unsigned int a = 0; a < dim; ++a, i /= parts + 1)
      x[a] += space.cells()[c].size[a] * (i % (parts + 1)) / parts;
    return x;
  }

  /// By place, what becomes of values(point, component, global index) at the nodes of this rank's
  /// cells. Unknowns at the same place must agree.
  template <int dim, class Values>
  std::map<Place<dim>, double>
  distributed(EulerianSpace<dim> &space, VelocityVector &v, const Values &values)
  {
    constexpr unsigned int n   = EulerianSpace<dim>::n_nodes;
    v                          = space.make_velocity();
    const unsigned int n_owned = v.locally_owned_size();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int a = 0; a < dim; ++a)
          if (const unsigned int dof = space.velocity_dofs(c)[a * n + i]; dof < n_owned)
            v.local_element(dof) =
              values(point_of(space, c, 2, i), a, v.get_partitioner()->local_to_global(dof));
    space.distribute(v, false);
    std::map<Place<dim>, double> result;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int a = 0; a < dim; ++a)
          {
            const dealii::Point<dim> x = point_of(space, c, 2, i);
            const double value         = v.local_element(space.velocity_dofs(c)[a * n + i]);
            EXPECT_NEAR(result.emplace(place_of(space, x, a), value).first->second, value, 1e-12)
              << x;
          }
    return result;
  }

  /// Where a cell has neighbours that are finer, their nodes lie on its polynomial, whatever the
  /// unconstrained values are.
  template <int dim>
  void
  check_continuity(EulerianSpace<dim> &space)
  {
    VelocityVector v;
    const auto values =
      distributed(space, v, [](const auto &, const unsigned int, const auto index) {
        return std::sin(1000. * index);
      });
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes, n_quarters = dim == 2 ? 25 : 125;
    unsigned int n_hanging = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int q = 0; q < n_quarters; ++q)
        {
          dealii::Point<dim> unit;
          bool boundary = false, node = true;
          for (unsigned int a = 0, rest = q; a < dim; ++a, rest /= 5)
            {
              unit[a]  = rest % 5 / 4.;
              boundary = boundary || rest % 5 % 4 == 0;
              node     = node && rest % 5 % 2 == 0;
            }
          if (!boundary || node)
            continue;
          double shapes[n];
          EulerianSpace<dim>::shape_values(unit, shapes);
          const dealii::Point<dim> x = point_of(space, c, 4, q);
          for (unsigned int a = 0; a < dim; ++a)
            if (const auto there = values.find(place_of(space, x, a)); there != values.end())
              {
                double value = 0;
                for (unsigned int i = 0; i < n; ++i)
                  value += shapes[i] * v.local_element(space.velocity_dofs(c)[a * n + i]);
                ASSERT_NEAR(there->second, value, 1e-12) << x;
                ++n_hanging;
              }
        }
    if (dealii::Utilities::MPI::n_mpi_processes(space.communicator()) == 1)
      {
        EXPECT_GT(n_hanging, 0u);
      }
  }

  /// Values at unconstrained nodes give a field that is continuous, and the same on any number of
  /// ranks. Meshes are refined across the seam. What is not periodic is taken from the lower side.
  template <int dim>
  void
  check_periodic(const std::string &domain)
  {
    const auto rough = [](const dealii::Point<dim> &x, const unsigned int component, auto) {
      double result = component;
      for (unsigned int a = 0; a < dim; ++a)
        result += std::sin(50 * (a + 1.3) * x[a] * x[a]);
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
        check_continuity(*here);
        check_continuity(*alone);
        VelocityVector v;
        const auto values = distributed(*here, v, rough), all = distributed(*alone, v, rough);
        for (const auto &[place, value] : values)
          ASSERT_NEAR(value, all.at(place), 1e-12);
      }
    EXPECT_EQ(finest, 2u);
  }

  TEST(VelocityConstraints, ArePeriodicAcrossARefinedSeamOnAnyRanks)
  {
    check_periodic<2>(R"({"cells": [8, 6], "periodic": ["x", "y"]})");
    check_periodic<2>(R"({"cells": [4, 2], "periodic": ["x"]})");
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
    const auto quadratic = [](const dealii::Point<dim> &x, const unsigned int component, auto) {
      return component == 0 ? x[0] * x[dim - 1] - x[1] * x[1] : component + x[0] * x[1];
    };
    for (unsigned int seed = 0; seed < 3; ++seed)
      {
        const auto space =
          make_space<dim>("{\"cells\": " + cells + ", \"boundary\": {" + faces + "}}");
        refine_here_and_there(*space, seed);
        constexpr double fine = 3840;
        check_continuity(*space);
        VelocityVector v;
        for (const auto &[place, value] : distributed(*space, v, quadratic))
          {
            dealii::Point<dim> x;
            for (unsigned int a = 0; a < dim; ++a)
              x[a] = place[a] / fine;
            ASSERT_NEAR(value, quadratic(x, place[dim], 0), 1e-12) << x;
          }
      }
  }

  TEST(VelocityConstraints, KeepQuadraticVelocities)
  {
    check_quadratic<2>("[10, 8]", R"(["x*y - y^2", "1 + x*y"])");
    check_quadratic<3>("[4, 3, 4]", R"(["x*z - y^2", "1 + x*y", "2 + x*y"])");
  }

  TEST(VelocityConstraints, OfTheTimeBeforeAreNotThoseOfTheBoundaryNow)
  {
    // A wall that starts to move: the fluid was at rest, at the nodes that hang on the wall's too.
    const auto space = make_space<2>(
      R"({"cells": [10, 8], "boundary": {"y_max": {"velocity": {"value": ["t*x - t*x^2", 0]
  }
}
}
})");
    space->set_time(1);
    space->distribute(space->velocity, false);
    refine_here_and_there(*space, 0);
    EXPECT_GT(space->velocity.linfty_norm(), .1);
    EXPECT_EQ(space->old_velocity.linfty_norm(), 0.);
    EXPECT_EQ(space->older_velocity.linfty_norm(), 0.);
  }
} // namespace
