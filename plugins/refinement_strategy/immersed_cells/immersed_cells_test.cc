// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/refinement_strategy_kit.h>

#include <gtest/gtest.h>

#include <random>

FEIB_TEST_REFINEMENT_STRATEGY("immersed_cells");

namespace
{
  using namespace feib;
  using namespace dealii;

  struct Settings
  {
    int level, minimum_level, buffer;

    std::string
    json() const
    {
      return "{\"level\": " + std::to_string(level) +
             ", \"minimum_level\": " + std::to_string(minimum_level) +
             ", \"buffer\": " + std::to_string(buffer) + "}";
    }
  };

  template <int dim>
  std::vector<ImmersedStructure<dim>>
  make_structure(const std::string &component, const std::string &block)
  {
    std::vector<ImmersedStructure<dim>> structures(1);
    structures[0].model = feib::testing::registry().create<StructureModel<dim>>(
      component,
      R"({"name": "body", "law": {"neo_hookean": {"shear_modulus": 1}}, )" + block + "}");
    return structures;
  }

  /// Many points of the structure: the corners of its elements, and at random within.
  template <int dim>
  std::vector<Point<dim>>
  points_of(const StructureModel<dim> &model, const unsigned int n_per_element)
  {
    std::mt19937 random(1);
    std::exponential_distribution<> weight(1);
    std::vector<Point<dim>> points(model.positions.begin(), model.positions.end());
    const unsigned int n = model.mesh().structure_dim() + 1;
    for (const auto &element : model.mesh().elements())
      for (unsigned int i = 0; i < n_per_element; ++i)
        {
          std::vector<double> w(n);
          double sum = 0;
          for (double &value : w)
            sum += value = weight(random);
          Point<dim> x;
          for (unsigned int k = 0; k < n; ++k)
            x += w[k] / sum * model.positions[element.nodes[k]];
          points.push_back(x);
        }
    return points;
  }

  /// The mesh is fine wherever the structure and its buffer are, and fine only because of them.
  template <int dim>
  void
  check_mesh(const EulerianSpace<dim> &space,
             const std::vector<ImmersedStructure<dim>> &structures,
             const Settings &settings,
             const unsigned int n_per_element)
  {
    const Domain<dim> &domain = space.domain();
    Tensor<1, dim> finest, box = domain.upper - domain.lower;
    for (unsigned int d = 0; d < dim; ++d)
      finest[d] = box[d] / domain.cells[d] / (1 << settings.level);
    const std::vector<Point<dim>> points = points_of(*structures[0].model, n_per_element);

    // The width of all cells between two of the finest level and one of level l, in finest cells.
    const auto reach = [&](const int l) {
      double result = settings.buffer;
      for (int k = l; k < settings.level; ++k)
        result += 1 << (settings.level - k);
      return result;
    };
    for (const auto &cell : space.cells())
      {
        // The distance of the points from the cell, and from its parent, in finest cells.
        const int l = cell.level;
        const std::array<double, 2> size{
          {std::pow(2., settings.level - l), std::pow(2., settings.level - l + 1)}};
        std::array<double, 2> nearest{{1e100, 1e100}};
        for (const Point<dim> &x : points)
          {
            std::array<double, 2> distance{{0, 0}};
            for (unsigned int d = 0; d < dim; ++d)
              for (unsigned int who = 0; who < 2; ++who)
                {
                  double lower = (cell.lower[d] - domain.lower[d]) / finest[d];
                  lower        = size[who] * std::floor((lower + .1) / size[who]);
                  double y     = (x[d] - domain.lower[d]) / finest[d];
                  double gap   = 1e100;
                  for (const int shift : {-1, 0, 1})
                    if (shift == 0 || domain.periodic(d))
                      {
                        const double z = y + shift * box[d] / finest[d];
                        gap = std::min(gap, std::max({0., lower - z, z - lower - size[who]}));
                      }
                  distance[who] = std::max(distance[who], gap);
                }
            for (unsigned int who = 0; who < 2; ++who)
              nearest[who] = std::min(nearest[who], distance[who]);
          }
        EXPECT_GE(l, settings.minimum_level);
        EXPECT_LE(l, settings.level);
        if (nearest[0] < settings.buffer - 1e-6)
          {
            EXPECT_EQ(l, settings.level) << cell.lower << " is " << nearest[0] << " cells away";
          }
        if (l > settings.minimum_level)
          {
            // The points are a sample of the structure: half a cell of slack.
            EXPECT_LE(nearest[1], reach(l) + .5) << cell.lower << " has level " << l;
          }
      }

    // Every point is in a cell of the finest level.
    unsigned int n_found = 0;
    for (const Point<dim> &x : points)
      {
        Point<dim> unit;
        const unsigned int c = space.forest().locate(x, unit);
        if (c != CartesianForest<dim>::not_here)
          {
            ++n_found;
            EXPECT_EQ(space.cells()[c].level, static_cast<unsigned int>(settings.level)) << x;
          }
      }
    EXPECT_EQ(Utilities::MPI::sum(n_found, space.communicator()), points.size());
  }

  template <int dim>
  void
  check(const std::string &domain,
        const Settings &settings,
        const std::string &component,
        const std::string &block,
        const unsigned int n_per_element)
  {
    SCOPED_TRACE(component + " " + block + " " + settings.json());
    const auto space = feib::testing::make_space<dim>(domain);
    const auto strategy =
      feib::testing::registry().create<RefinementStrategy<dim>>("immersed_cells", settings.json());
    const auto structures = make_structure<dim>(component, block);

    EXPECT_TRUE(strategy->adapt(*space, structures));
    check_mesh(*space, structures, settings, n_per_element);

    // A fixed point: nothing is marked any more.
    EXPECT_FALSE(space->adapt(
      [&](auto &mesh) {
        strategy->mark(mesh, *space, structures);
        for (const auto &cell : mesh.active_cell_iterators())
          if (cell->is_locally_owned())
            {
              EXPECT_FALSE(cell->refine_flag_set()) << cell->center();
              EXPECT_FALSE(cell->coarsen_flag_set()) << cell->center();
            }
      },
      false));

    // The same mesh on one rank.
    const auto alone = feib::testing::make_space<dim>(domain, MPI_COMM_SELF);
    strategy->adapt(*alone, structures);
    EXPECT_EQ(alone->triangulation().n_global_active_cells(),
              space->triangulation().n_global_active_cells());

    // The refinement follows, and the mesh does not depend on where the structure was before.
    for (Point<dim> &x : structures[0].model->positions)
      x[0] += .11;
    EXPECT_TRUE(strategy->adapt(*space, structures));
    check_mesh(*space, structures, settings, n_per_element);
    const auto fresh = feib::testing::make_space<dim>(domain);
    strategy->adapt(*fresh, structures);
    EXPECT_EQ(fresh->triangulation().n_global_active_cells(),
              space->triangulation().n_global_active_cells());
  }

  std::string
  ellipse(const unsigned int n_elements, const std::string &centre)
  {
    return R"("mesh": {"closed_curve": {"length": 1, "elements": )" + std::to_string(n_elements) +
           R"(}}, "initial_position": [")" + centre +
           R"json( + 0.2 * cos(2 * pi * s1)", "0.5 + 0.15 * sin(2 * pi * s1)"])json";
  }

  TEST(ImmersedCells, FollowsACurve)
  {
    for (const int buffer : {0, 1, 3})
      check<2>(R"({"cells": [4, 3]})", {4, 0, buffer}, "membrane", ellipse(40, "0.4"), 40);
    check<2>(R"({"cells": [4, 3]})", {4, 2, 1}, "membrane", ellipse(40, "0.4"), 40);
  }

  TEST(ImmersedCells, FindsTheCellsOfHugeElements)
  {
    check<2>(R"({"cells": [3, 3], "lower": [-0.5, 0], "upper": [1, 1]})",
             {5, 0, 0},
             "membrane",
             ellipse(3, "0.4"),
             2000);
    check<3>(R"({"cells": [2, 2, 2]})",
             {3, 0, 0},
             "membrane",
             R"("mesh": {"sphere": {"centre": [0.4, 0.5, 0.5], "radius": 0.3, "refinements": 0}})",
             500);
  }

  TEST(ImmersedCells, FillsABody)
  {
    check<2>(R"({"cells": [4, 4]})",
             {4, 0, 1},
             "hyperelastic",
             R"("mesh": {"disc": {"centre": [0.45, 0.5], "radius": 0.2, "rings": 3}})",
             300);
    check<3>(R"({"cells": [2, 2, 2]})",
             {3, 0, 1},
             "hyperelastic",
             R"("mesh": {"ball": {"centre": [0.45, 0.5, 0.5], "radius": 0.25, "refinements": 0}})",
             300);
  }

  TEST(ImmersedCells, FollowsASurface)
  {
    check<3>(R"({"cells": [2, 3, 2]})",
             {3, 1, 1},
             "membrane",
             R"("mesh": {"sphere": {"centre": [0.4, 0.5, 0.5], "radius": 0.2, "refinements": 2}})",
             10);
  }

  TEST(ImmersedCells, CrossesAPeriodicSeam)
  {
    check<2>(
      R"({"cells": [4, 3], "periodic": ["x"]})", {4, 0, 1}, "membrane", ellipse(40, "0.95"), 40);
  }

  TEST(ImmersedCells, AStructureThatLeavesTheWorldIsAFailure)
  {
    const auto space = feib::testing::make_space<2>(R"({"cells": [4, 3], "periodic": ["x", "y"]})");
    const auto strategy =
      feib::testing::registry().create<RefinementStrategy<2>>("immersed_cells", R"({"level": 2})");
    const auto structures = make_structure<2>("membrane", ellipse(40, "0.4"));
    for (const double bad : {1e300, std::nan("")})
      {
        structures[0].model->positions[3][0] = bad;
        EXPECT_THROW(strategy->adapt(*space, structures), RunFailure);
      }
  }

  TEST(ImmersedCells, RefusesAMinimumAboveTheLevel)
  {
    EXPECT_THROW(feib::testing::registry().create<RefinementStrategy<2>>("immersed_cells",
                                                                         Settings{1, 2, 0}.json()),
                 Error);
    EXPECT_THROW(feib::testing::registry().create<RefinementStrategy<2>>("immersed_cells"), Error);
  }
} // namespace
