// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/refinement_strategy_kit.h>

#include <deal.II/base/quadrature_lib.h>

#include <gtest/gtest.h>

#include <functional>
#include <set>

FEIB_TEST_REFINEMENT_STRATEGY("error_indicator");

namespace
{
  using namespace feib;
  using namespace dealii;
  using feib::testing::cells_of;

  template <int dim>
  using Field = std::function<double(const Point<dim> &)>;

  template <int dim>
  std::unique_ptr<RefinementStrategy<dim>>
  make_strategy(const std::string &settings)
  {
    return feib::testing::registry().create<RefinementStrategy<dim>>("error_indicator",
                                                                     "{" + settings + "}");
  }

  /// Cell by cell the L2 projection of f: the basis of the pressure is orthonormal.
  template <int dim>
  void
  set_pressure(EulerianSpace<dim> &space, const Field<dim> &f)
  {
    const QGauss<dim> rule(3);
    space.pressure.zero_out_ghost_values();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < space.n_pressure; ++i)
        {
          double value = 0;
          for (unsigned int q = 0; q < rule.size(); ++q)
            {
              Point<dim> x = space.cells()[c].lower;
              for (unsigned int a = 0; a < dim; ++a)
                x[a] += rule.point(q)[a] * space.cells()[c].size[a];
              value += rule.weight(q) * f(x) *
                       space.pressure_handler().get_fe().shape_value(i, rule.point(q));
            }
          space.pressure.local_element(space.pressure_dofs(c)[i]) = value;
        }
  }

  /// A space from which the fluid can flow out everywhere: no velocity is prescribed.
  template <int dim>
  std::unique_ptr<EulerianSpace<dim>>
  make_open_space(std::string domain, const MPI_Comm communicator = MPI_COMM_WORLD)
  {
    std::string faces;
    for (const std::string direction : {"x", "y", "z"})
      if ((direction != "z" || dim == 3) && domain.find("\"" + direction + "\"") == domain.npos)
        for (const std::string side : {"_min", "_max"})
          faces += (faces.empty() ? "\"" : ", \"") + direction + side + "\": {\"outflow\": {}}";
    domain.insert(domain.rfind('}'), ", \"boundary\": {" + faces + "}");
    return feib::testing::make_space<dim>(domain, communicator);
  }

  /// Component k of the velocity is (k + 1) f at the nodes, but where nodes hang it is continuous.
  template <int dim>
  void
  set_velocity(EulerianSpace<dim> &space, const Field<dim> &f)
  {
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < space.n_velocity; ++i)
        {
          Point<dim> x      = space.cells()[c].lower;
          unsigned int node = i % space.n_nodes;
          for (unsigned int a = 0; a < dim; ++a, node /= 3)
            x[a] += .5 * (node % 3) * space.cells()[c].size[a];
          space.velocity.local_element(space.velocity_dofs(c)[i]) = (i / space.n_nodes + 1) * f(x);
        }
    space.velocity.zero_out_ghost_values();
    space.distribute(space.velocity, true);
  }

  /// What an indicator looks at.
  template <int dim>
  void
  set_solution(EulerianSpace<dim> &space, const std::string &indicator, const Field<dim> &f)
  {
    if (indicator == "kelly")
      set_velocity(space, f);
    else
      set_pressure(space, f);
  }

  /// Lower corner and level of a cell.
  template <int dim>
  using Name = std::array<double, dim + 1>;

  template <int dim>
  Name<dim>
  name_of(const Point<dim> &lower, const unsigned int level)
  {
    Name<dim> name;
    for (unsigned int a = 0; a < dim; ++a)
      name[a] = lower[a];
    name[dim] = level;
    return name;
  }

  template <int dim>
  std::set<Name<dim>>
  over_all_ranks(const std::vector<Name<dim>> &names, const MPI_Comm communicator)
  {
    std::set<Name<dim>> result;
    for (const auto &part : Utilities::MPI::all_gather(communicator, names))
      result.insert(part.begin(), part.end());
    return result;
  }

  /// The cells that the strategy marks to be split; the mesh stays as it is.
  template <int dim>
  std::set<Name<dim>>
  split_cells(EulerianSpace<dim> &space, RefinementStrategy<dim> &strategy)
  {
    std::vector<Name<dim>> names;
    strategy.plan(space, {});
    space.adapt(
      [&](auto &mesh) {
        strategy.mark(mesh, space, {});
        for (const auto &cell : mesh.active_cell_iterators())
          {
            if (cell->is_locally_owned() && cell->refine_flag_set())
              names.push_back(name_of<dim>(cell->vertex(0), space.level(*cell)));
            cell->clear_refine_flag();
            cell->clear_coarsen_flag();
          }
      },
      false);
    return over_all_ranks<dim>(names, space.communicator());
  }

  template <int dim>
  std::array<unsigned int, 2>
  coarsest_and_finest(const EulerianSpace<dim> &space)
  {
    std::array<unsigned int, 2> result{{100, 0}};
    for (const Name<dim> &name : cells_of(space))
      {
        result[0] = std::min<unsigned int>(result[0], name[dim]);
        result[1] = std::max<unsigned int>(result[1], name[dim]);
      }
    return result;
  }

  /// The squared indicators of the cells of a space of one rank, from the definition: every pair of
  /// cells whose sides overlap, also across the seams of a periodic box.
  template <int dim>
  std::vector<double>
  indicators_by_definition(const EulerianSpace<dim> &space, const bool kelly)
  {
    const Domain<dim> &domain = space.domain();
    const auto &cells         = space.cells();
    const QGauss<dim> rule(3);
    // The pressure or the normal derivative of the velocity, of a cell at a place x.
    const auto evaluate = [&](const unsigned int c, const unsigned int a, const Point<dim> &x) {
      Tensor<1, dim> result;
      Point<dim> unit;
      for (unsigned int b = 0; b < dim; ++b)
        unit[b] = (x[b] - cells[c].lower[b]) / cells[c].size[b];
      if (!kelly)
        {
          for (unsigned int i = 0; i < space.n_pressure; ++i)
            result[0] += space.pressure.local_element(space.pressure_dofs(c)[i]) *
                         space.pressure_handler().get_fe().shape_value(i, unit);
          return result;
        }
      // Central differences of quadratic functions are exact.
      for (const int side : {-1, 1})
        {
          Point<dim> place = unit;
          place[a] += .25 * side;
          std::array<double, EulerianSpace<dim>::n_nodes> values;
          space.shape_values(place, values.data());
          for (unsigned int i = 0; i < space.n_velocity; ++i)
            result[i / space.n_nodes] += side / (.5 * cells[c].size[a]) *
                                         values[i % space.n_nodes] *
                                         space.velocity.local_element(space.velocity_dofs(c)[i]);
        }
      return result;
    };

    std::vector<double> result(cells.size(), 0.);
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int below = 0; below < cells.size(); ++below)
        for (unsigned int above = 0; above < cells.size(); ++above)
          for (const double shift : {0., domain.upper[a] - domain.lower[a]})
            {
              if ((shift > 0 && !domain.periodic(a)) ||
                  std::abs(cells[below].lower[a] + cells[below].size[a] - cells[above].lower[a] -
                           shift) > 1e-9)
                continue;
              Point<dim> lower;
              Tensor<1, dim> size;
              double area = 1;
              for (unsigned int b = 0; b < dim; ++b)
                if (b != a)
                  {
                    lower[b] = std::max(cells[below].lower[b], cells[above].lower[b]);
                    size[b]  = std::min(cells[below].lower[b] + cells[below].size[b],
                                       cells[above].lower[b] + cells[above].size[b]) -
                              lower[b];
                    area *= size[b] > 1e-9 ? size[b] : 0.;
                  }
              if (area == 0)
                continue;
              double integral = 0;
              for (unsigned int q = 0; q < rule.size(); ++q)
                {
                  Point<dim> x = lower;
                  for (unsigned int b = 0; b < dim; ++b)
                    x[b] += rule.point(q)[b] * size[b];
                  Point<dim> y = x;
                  x[a]         = cells[below].lower[a] + cells[below].size[a];
                  y[a]         = cells[above].lower[a];
                  integral += rule.weight(q) * area *
                              (evaluate(below, a, x) - evaluate(above, a, y)).norm_square();
                }
              result[below] += size.norm() * integral;
              result[above] += size.norm() * integral;
            }
    return result;
  }

  /// Rough everywhere, without any pattern.
  template <int dim>
  double
  noise(const Point<dim> &x)
  {
    double sum = 0;
    for (unsigned int a = 0; a < dim; ++a)
      sum += (17.3 + 9.1 * a) * x[a];
    return std::exp(2 * std::sin(sum)) * (1 + std::sin(3.7 * sum));
  }

  template <int dim>
  std::string
  seamed_box()
  {
    return dim == 2 ? R"({"cells": [7, 5], "upper": [1.5, 1], "periodic": ["x"]})"
                    : R"({"cells": [4, 3, 3], "upper": [1.5, 1, 1.2], "periodic": ["x"]})";
  }

  /// Hanging faces inside the box and across its seam.
  template <int dim>
  void
  refine_some(EulerianSpace<dim> &space)
  {
    feib::testing::refine_where(space, [](const auto &x) { return x[0] < .4 && x[1] < .7; });
    if (dim == 2)
      feib::testing::refine_where(space, [](const auto &x) { return x[0] < .3 && x[1] < .3; });
  }

  /// The smallest indicator among the largest ones that together hold the fraction of the sum (of
  /// the number when @p by_number).
  double
  threshold(std::vector<double> indicators, const double fraction, const bool by_number)
  {
    std::sort(indicators.rbegin(), indicators.rend());
    double total = 0, sum = 0;
    for (const double indicator : indicators)
      total += by_number ? 1 : indicator;
    for (const double indicator : indicators)
      if ((sum += by_number ? 1 : indicator) >= fraction * total)
        return indicator;
    return 0;
  }

  template <int dim>
  void
  check_marks(const std::string &indicator, const bool by_number, const double fraction)
  {
    SCOPED_TRACE(std::to_string(dim) + "D " + indicator + " " + std::to_string(fraction));
    const auto strategy = make_strategy<dim>(
      "\"maximum_level\": 5, \"coarsen_fraction\": 0, \"indicator\": \"" + indicator +
      "\", \"marking\": \"" + (by_number ? "fixed_fraction" : "doerfler") +
      "\", \"refine_fraction\": " + std::to_string(fraction));
    const auto space = make_open_space<dim>(seamed_box<dim>());
    const auto alone = make_open_space<dim>(seamed_box<dim>(), MPI_COMM_SELF);
    for (EulerianSpace<dim> *s : {space.get(), alone.get()})
      {
        refine_some(*s);
        set_solution<dim>(*s, indicator, noise<dim>);
      }

    const std::vector<double> indicators = indicators_by_definition(*alone, indicator == "kelly");
    const double least                   = threshold(indicators, fraction, by_number);
    const std::set<Name<dim>> split      = split_cells(*space, *strategy);
    unsigned int n_above = 0, n_below = 0;
    const auto &cells = alone->cells();
    for (unsigned int c = 0; c < cells.size(); ++c)
      {
        const bool is_split = split.count(name_of<dim>(cells[c].lower, cells[c].level)) != 0;
        // Indicators within one percent are treated alike.
        if (indicators[c] >= least)
          {
            ++n_above;
            EXPECT_TRUE(is_split) << cells[c].lower << ": " << indicators[c] << " above " << least;
          }
        else if (indicators[c] < least / 1.02)
          {
            // It may have to, for a smaller neighbour that is split.
            const bool finest = cells[c].level == (dim == 2 ? 2 : 1);
            n_below += finest;
            EXPECT_FALSE(finest && is_split)
              << cells[c].lower << ": " << indicators[c] << " below " << least;
          }
      }
    EXPECT_GT(n_above, 0u);
    EXPECT_GT(n_below, 0u);

    // The same on one rank, marks and mesh.
    EXPECT_EQ(split_cells(*alone, *strategy), split);
    strategy->adapt(*alone, {});
    EXPECT_TRUE(strategy->adapt(*space, {}));
    EXPECT_EQ(cells_of(*alone), cells_of(*space));
  }

  TEST(ErrorIndicator, SplitsTheCellsThatHoldTheFraction)
  {
    for (const std::string indicator : {"pressure_jump", "kelly"})
      {
        for (const double fraction : {.2, .5, .8})
          check_marks<2>(indicator, false, fraction);
        check_marks<2>(indicator, true, .1);
        check_marks<3>(indicator, false, .3);
        check_marks<3>(indicator, true, .1);
      }
  }

  TEST(ErrorIndicator, SplitsNoMoreThanThoseCells)
  {
    // All cells of one size, so that no neighbour has to be split.
    const auto space = feib::testing::make_space<2>(seamed_box<2>(), MPI_COMM_SELF);
    set_pressure<2>(*space, noise<2>);
    const std::vector<double> indicators = indicators_by_definition(*space, false);
    const double total = std::accumulate(indicators.begin(), indicators.end(), 0.);
    for (const double fraction : {.1, .3, .5, .7})
      {
        const auto strategy = make_strategy<2>("\"maximum_level\": 3, \"refine_fraction\": " +
                                               std::to_string(fraction));
        const auto split    = split_cells(*space, *strategy);
        std::vector<double> held;
        for (unsigned int c = 0; c < indicators.size(); ++c)
          if (split.count(name_of<2>(space->cells()[c].lower, 0)) != 0)
            held.push_back(indicators[c]);
        EXPECT_EQ(held.size(), split.size());
        EXPECT_GE(std::accumulate(held.begin(), held.end(), 0.), fraction * total);
        // Without the smallest, and what is treated like it, they hold too little.
        const double least = *std::min_element(held.begin(), held.end());
        double more        = 0;
        for (const double indicator : held)
          more += indicator > 1.01 * least ? indicator : 0.;
        EXPECT_LT(more, fraction * total);
      }
  }

  TEST(ErrorIndicator, TreatsSymmetricCellsAlike)
  {
    for (const double fraction : {.1, .3, .5, .7, .9})
      {
        const auto strategy = make_strategy<2>("\"maximum_level\": 4, \"refine_fraction\": " +
                                               std::to_string(fraction));
        const auto space    = feib::testing::make_space<2>(R"({"cells": [8, 8]})");
        for (unsigned int i = 0; i < 3; ++i)
          {
            set_pressure<2>(*space, [](const Point<2> &x) {
              return std::tanh((x.distance(Point<2>(.5, .5)) - .3) / .1);
            });
            EXPECT_TRUE(strategy->adapt(*space, {}));
          }
        const std::set<Name<2>> cells = cells_of(*space);
        for (const Name<2> &cell : cells)
          {
            const double size = 1. / (8 << int(cell[2]));
            EXPECT_EQ(cells.count({{1 - size - cell[0], cell[1], cell[2]}}), 1u);
            EXPECT_EQ(cells.count({{cell[1], cell[0], cell[2]}}), 1u);
          }
      }
  }

  template <int dim>
  void
  check_levels(const std::string &indicator)
  {
    const auto strategy = make_strategy<dim>(
      R"("minimum_level": 1, "maximum_level": 3, "indicator": ")" + indicator + "\"");
    const auto space =
      make_open_space<dim>(dim == 2 ? R"({"cells": [3, 3]})" : R"({"cells": [2, 2, 2]})");
    // A kink (a step) at an odd place.
    const auto solve = [&] {
      set_solution<dim>(*space, indicator, [&](const Point<dim> &x) {
        const double distance = x.distance(Point<dim>()) - .71;
        return indicator == "kelly" ? std::abs(distance) : distance < 0 ? 0. : 1.;
      });
    };
    using Levels = std::array<unsigned int, 2>;

    // Nothing is known at the start.
    EXPECT_TRUE(strategy->adapt(*space, {}));
    EXPECT_EQ(coarsest_and_finest(*space), (Levels{{1, 1}}));
    EXPECT_FALSE(strategy->adapt(*space, {}));
    // One level at a time, up to the finest.
    unsigned int before = 1;
    for (unsigned int i = 0; i < 8; ++i)
      {
        solve();
        strategy->adapt(*space, {});
        const Levels levels = coarsest_and_finest(*space);
        EXPECT_EQ(levels[0], 1u);
        EXPECT_LE(levels[1], std::min(before + 1, 3u));
        before = levels[1];
      }
    EXPECT_EQ(before, 3u);
    // The whole mesh, a level at a time, when the solution is smooth again.
    for (const unsigned int finest : {2, 1, 1})
      {
        set_pressure<dim>(*space, [](const Point<dim> &x) { return 3 + x[0] - 2 * x[1]; });
        set_velocity<dim>(*space, [](const Point<dim> &) { return 7.; });
        EXPECT_EQ(strategy->adapt(*space, {}), finest < before);
        EXPECT_EQ(coarsest_and_finest(*space), (Levels{{1, finest}}));
        before = finest;
      }
  }

  TEST(ErrorIndicator, KeepsToItsLevels)
  {
    for (const std::string indicator : {"pressure_jump", "kelly"})
      {
        check_levels<2>(indicator);
        check_levels<3>(indicator);
      }
  }

  TEST(ErrorIndicator, MergesWhatWasTooFineFromTheStart)
  {
    const auto strategy = make_strategy<2>(R"("maximum_level": 1)");
    const auto space    = feib::testing::make_space<2>(R"({"cells": [2, 2]})");
    for (unsigned int i = 0; i < 3; ++i)
      feib::testing::refine_where(*space, [](const auto &) { return true; });
    set_pressure<2>(*space, noise<2>);
    EXPECT_TRUE(strategy->adapt(*space, {}));
    EXPECT_EQ(coarsest_and_finest(*space)[1], 1u);
  }

  template <int dim>
  void
  check_limit(const unsigned int limit)
  {
    const auto strategy = make_strategy<dim>(
      R"("maximum_level": 6, "refine_fraction": 0.7, "coarsen_fraction": 0, "maximum_cells": )" +
      std::to_string(limit));
    const std::string box = dim == 2 ? R"({"cells": [7, 5]})" : R"({"cells": [4, 3, 3]})";
    const auto space      = feib::testing::make_space<dim>(box);
    const auto free       = feib::testing::make_space<dim>(box);
    const auto without =
      make_strategy<dim>(R"("maximum_level": 6, "refine_fraction": 0.7, "coarsen_fraction": 0)");
    for (unsigned int i = 0; i < 5; ++i)
      {
        set_pressure<dim>(*space, noise<dim>);
        strategy->adapt(*space, {});
        ASSERT_LE(space->triangulation().n_global_active_cells(), limit);
        if (free->triangulation().n_global_active_cells() <= limit)
          {
            set_pressure<dim>(*free, noise<dim>);
            without->adapt(*free, {});
          }
      }
    // The limit was met, and used.
    EXPECT_GT(free->triangulation().n_global_active_cells(), limit);
    EXPECT_GT(space->triangulation().n_global_active_cells(), .9 * limit);
  }

  TEST(ErrorIndicator, KeepsToItsNumberOfCells)
  {
    check_limit<2>(500);
    check_limit<3>(1500);
  }


  template <int dim>
  std::vector<ImmersedStructure<dim>>
  make_structure()
  {
    const std::string mesh =
      dim == 2 ?
               R"json({"closed_curve": {"length": 1, "elements": 40}}, "initial_position":
                               ["0.3 + 0.1 * cos(2 * pi * s1)", "0.5 + 0.1 * sin(2 * pi * s1)"])json"
               : R"({"sphere": {"centre": [0.3, 0.5, 0.5], "radius": 0.15, "refinements": 2}})";
    std::vector<ImmersedStructure<dim>> structures(1);
    structures[0].model = feib::testing::registry().create<StructureModel<dim>>(
      "membrane",
      R"({"name": "body", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": )" + mesh + "}");
    return structures;
  }

  template <int dim>
  void
  check_structure_level()
  {
    const int level = dim == 2 ? 4 : 3;
    const auto strategy =
      make_strategy<dim>("\"maximum_level\": " + std::to_string(level) +
                         ", \"maximum_cells\": 1, \"structure_level\": " + std::to_string(level));
    const auto structures = make_structure<dim>();
    const std::string box = dim == 2 ? R"({"cells": [4, 3]})" : R"({"cells": [2, 2, 2]})";
    const auto space      = feib::testing::make_space<dim>(box);
    std::set<Name<dim>> before;
    for (const double shift : {0., .4})
      {
        for (Point<dim> &x : structures[0].model->positions)
          x[0] += shift;
        EXPECT_TRUE(strategy->adapt(*space, structures));
        unsigned int n_found = 0;
        for (const Point<dim> &x : structures[0].model->positions)
          {
            Point<dim> unit;
            const unsigned int c = space->forest().locate(x, unit);
            if (c == CartesianForest<dim>::not_here)
              continue;
            ++n_found;
            EXPECT_EQ(space->cells()[c].level, level);
          }
        EXPECT_EQ(Utilities::MPI::sum(n_found, space->communicator()),
                  structures[0].model->positions.size());
        // Without a solution nothing else is refined.
        const auto same = feib::testing::registry().create<RefinementStrategy<dim>>(
          "immersed_cells", "{\"buffer\": 0, \"level\": " + std::to_string(level) + "}");
        const auto fresh = feib::testing::make_space<dim>(box);
        same->adapt(*fresh, structures);
        if (shift == 0)
          {
            EXPECT_EQ(cells_of(*fresh), cells_of(*space));
          }
        else
          {
            // Behind the structure cells grow by one level each time.
            EXPECT_LT(cells_of(*fresh).size(), cells_of(*space).size());
            int n_more = 0;
            while (strategy->adapt(*space, structures))
              ++n_more;
            EXPECT_GT(n_more, 0);
            EXPECT_LT(n_more, level);
            EXPECT_EQ(cells_of(*fresh), cells_of(*space));
          }
      }
  }

  TEST(ErrorIndicator, KeepsTheCellsOfStructuresFine)
  {
    check_structure_level<2>();
    check_structure_level<3>();
  }


  template <int dim>
  void
  check_following(const std::string &indicator)
  {
    const int finest    = dim == 2 ? 4 : 2;
    const auto strategy = make_strategy<dim>(
      "\"indicator\": \"" + indicator +
      "\", \"coarsen_fraction\": 0.1, \"maximum_level\": " + std::to_string(finest));
    const auto space =
      make_open_space<dim>(dim == 2 ? R"({"cells": [8, 4]})" : R"({"cells": [8, 2, 2]})");
    for (const double place : {.22, .78})
      {
        for (int i = 0; i < 2 * finest; ++i)
          {
            set_solution<dim>(*space, indicator, [&](const Point<dim> &x) {
              return std::tanh((x[0] - place) / .02);
            });
            strategy->adapt(*space, {});
          }
        // The finest cells are at the front alone, and all cells there are; those far away are
        // coarse.
        for (const Name<dim> &cell : cells_of(*space))
          {
            const double size = 1. / (8 << int(cell[dim]));
            const double gap  = std::max({cell[0] - place, place - cell[0] - size, 0.});
            if (gap == 0)
              {
                EXPECT_EQ(cell[dim], finest) << cell[0];
              }
            if (gap > .3)
              {
                EXPECT_EQ(cell[dim], 0) << cell[0];
              }
          }
      }
  }

  TEST(ErrorIndicator, FollowsAFront)
  {
    for (const std::string indicator : {"pressure_jump", "kelly"})
      {
        check_following<2>(indicator);
        check_following<3>(indicator);
      }
  }


  /// The L2 norm of p - f or of u - f (1, 2, ...).
  template <int dim>
  double
  error(const EulerianSpace<dim> &space, const std::string &indicator, const Field<dim> &f)
  {
    const QGauss<dim> rule(5);
    double sum = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int q = 0; q < rule.size(); ++q)
        {
          const auto &cell = space.cells()[c];
          Point<dim> x     = cell.lower;
          double volume    = 1;
          for (unsigned int a = 0; a < dim; ++a)
            {
              x[a] += rule.point(q)[a] * cell.size[a];
              volume *= cell.size[a];
            }
          if (indicator == "kelly")
            {
              std::array<double, EulerianSpace<dim>::n_nodes> values;
              space.shape_values(rule.point(q), values.data());
              Tensor<1, dim> difference;
              for (unsigned int k = 0; k < dim; ++k)
                difference[k] = -(k + 1.) * f(x);
              for (unsigned int i = 0; i < space.n_velocity; ++i)
                difference[i / space.n_nodes] +=
                  values[i % space.n_nodes] *
                  space.velocity.local_element(space.velocity_dofs(c)[i]);
              sum += rule.weight(q) * volume * difference.norm_square();
            }
          else
            {
              double difference = -f(x);
              for (unsigned int i = 0; i < space.n_pressure; ++i)
                difference += space.pressure.local_element(space.pressure_dofs(c)[i]) *
                              space.pressure_handler().get_fe().shape_value(i, rule.point(q));
              sum += rule.weight(q) * volume * difference * difference;
            }
        }
    return std::sqrt(Utilities::MPI::sum(sum, space.communicator()));
  }

  /// A boundary layer around a circle (sphere).
  template <int dim>
  void
  check_error(const std::string &indicator)
  {
    const Field<dim> f = [](const Point<dim> &x) {
      return std::tanh((x.distance(Point<dim>()) - .6) / .03);
    };
    const auto box = [](const unsigned int n) {
      const std::string N = std::to_string(n);
      return "{\"cells\": [" + N + ", " + N + (dim == 3 ? ", " + N : "") + "]}";
    };
    const unsigned int n_base = dim == 2 ? 8 : 4;
    const auto strategy       = make_strategy<dim>(
      "\"maximum_level\": 5, \"maximum_cells\": " + std::to_string(2000 * (dim - 1)) +
      ", \"indicator\": \"" + indicator + "\"");
    const auto adapted = make_open_space<dim>(box(n_base));
    for (unsigned int i = 0; i < 10; ++i)
      {
        set_solution(*adapted, indicator, f);
        strategy->adapt(*adapted, {});
      }
    set_solution(*adapted, indicator, f);
    adapted->velocity.update_ghost_values();

    const double n_cells = adapted->triangulation().n_global_active_cells();
    const auto uniform   = make_open_space<dim>(box(std::ceil(std::pow(n_cells, 1. / dim) - 1e-9)));
    ASSERT_GE(uniform->triangulation().n_global_active_cells(), n_cells);
    set_solution(*uniform, indicator, f);
    uniform->velocity.update_ghost_values();
    const double ratio = error(*adapted, indicator, f) / error(*uniform, indicator, f);
    if (Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::printf("%dD, %s, %d cells: error %.2e, %.3f times that of %d equal cells\n",
                  dim,
                  indicator.c_str(),
                  int(n_cells),
                  error(*adapted, indicator, f),
                  ratio,
                  int(uniform->triangulation().n_global_active_cells()));
    else
      error(*adapted, indicator, f);
    EXPECT_LT(ratio, .5);
  }

  TEST(ErrorIndicator, BeatsTheUniformMeshOfAsManyCells)
  {
    for (const std::string indicator : {"pressure_jump", "kelly"})
      {
        check_error<2>(indicator);
        check_error<3>(indicator);
      }
  }


  TEST(ErrorIndicator, RefusesWhatCannotBe)
  {
    for (const std::string settings : {R"("maximum_level": 2, "minimum_level": 3)",
                                       R"("maximum_level": 2, "structure_level": 3)",
                                       R"("maximum_level": 2, "coarsen_fraction": 0.6)",
                                       R"("minimum_level": 2)"})
      EXPECT_THROW(make_strategy<2>(settings), Error) << settings;
    EXPECT_EQ(
      make_strategy<2>(R"("maximum_level": 2, "structure_level": 2, "interval": 7)")->interval(),
      7u);
  }
} // namespace
