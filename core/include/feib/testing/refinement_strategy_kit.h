// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_refinement_strategy_kit_h
#define feib_testing_refinement_strategy_kit_h

#include <feib/refinement_strategy.h>
#include <feib/testing/examples.h>
#include <feib/testing/fields.h>
#include <feib/testing/memory_checkpoint.h>

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <set>

namespace feib::testing
{
  /// The cells of all ranks: lower corner and level.
  template <int dim>
  std::set<std::array<double, dim + 1>>
  cells_of(const EulerianSpace<dim> &space)
  {
    std::vector<std::array<double, dim + 1>> names;
    for (const auto &cell : space.cells())
      {
        names.emplace_back();
        for (unsigned int a = 0; a < dim; ++a)
          names.back()[a] = cell.lower[a];
        names.back()[dim] = cell.level;
      }
    std::set<std::array<double, dim + 1>> result;
    for (const auto &part : dealii::Utilities::MPI::all_gather(space.communicator(), names))
      result.insert(part.begin(), part.end());
    return result;
  }


  /// A small structure in a few cells, and a strategy.
  template <int dim>
  class RefinementTrial
  {
  public:
    RefinementTrial(const std::string &name,
                    const std::string &block,
                    const MPI_Comm communicator = MPI_COMM_WORLD)
      : space(make_space<dim>(open_box<dim>(dim == 2 ? "[2, 2]" : "[1, 1, 1]"), communicator))
      , structures(1)
      , strategy(registry().create<RefinementStrategy<dim>>(name, block))
    {
      structures[0].model = registry().create<StructureModel<dim>>(
        "membrane",
        std::string(R"({"name": "body", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": )") +
          (dim == 2 ? R"j({"closed_curve": {"length": 1, "elements": 20}}, "initial_position":
                         ["0.3 + 0.1 * cos(2*pi*s1)", "0.4 + 0.1 * sin(2*pi*s1)"]})j"
                    : R"({"sphere": {"centre": [0.2, 0.2, 0.3], "radius": 0.06,
                                     "refinements": 0}}})"));
    }

    void
    move_structure(const double shift)
    {
      for (dealii::Point<dim> &x : structures[0].model->positions)
        x[0] += shift;
    }

    /// Fields that no mesh resolves.
    void
    make_rough(const double seed)
    {
      set_velocity(*space, space->velocity, [&](const dealii::Point<dim> &x) {
        return (1 + std::sin(91 * x[0] + seed) * std::cos(57 * x[1])) * exact_velocity<dim>(x);
      });
      for (unsigned int i = 0; i < EulerianSpace<dim>::n_pressure; ++i)
        for (unsigned int c = 0; c < space->cells().size(); ++c)
          {
            const dealii::Point<dim> &x = space->cells()[c].lower;
            space->pressure.local_element(space->pressure_dofs(c)[i]) =
              std::exp(2 * std::sin(17 * x[0] + 31 * x[1] + seed + i));
          }
      space->pressure.update_ghost_values();
    }

    /// Adapts until nothing changes.
    void
    settle()
    {
      constexpr unsigned int most = 20; // levels, one at a time
      unsigned int n              = 0;
      while (n < most && strategy->adapt(*space, structures))
        ++n;
      EXPECT_LT(n, most) << "the mesh changes again and again, though nothing else does";
    }

    /// The levels of the cells at the structure's nodes, each known to the rank that has the cell.
    std::vector<int>
    levels_at_structure() const
    {
      std::vector<int> result;
      for (const dealii::Point<dim> &x : structures[0].model->positions)
        {
          dealii::Point<dim> unit;
          const unsigned int c = space->forest().locate(x, unit);
          const int level = c == CartesianForest<dim>::not_here ? -1 : int(space->cells()[c].level);
          result.push_back(dealii::Utilities::MPI::max(level, space->communicator()));
        }
      return result;
    }

    void
    archive(Archive &archive)
    {
      archive("space", *space);
      archive("strategy", *strategy);
    }

    std::unique_ptr<EulerianSpace<dim>> space;
    std::vector<ImmersedStructure<dim>> structures;
    std::unique_ptr<RefinementStrategy<dim>> strategy;
  };


  /// The first mesh has the cells forecast; without a flow a mesh comes to rest, and is where the
  /// structure went as fine as it would be there from the start.
  template <int dim>
  void
  check_mesh(const std::string &name, const std::string &block)
  {
    RefinementTrial<dim> trial(name, block);
    const double forecast = trial.strategy->forecast_cells(*trial.space, trial.structures);
    trial.strategy->adapt(*trial.space, trial.structures);
    const double n_cells = trial.space->triangulation().n_global_active_cells();
    EXPECT_TRUE(forecast == 0 || forecast == n_cells)
      << "forecast: " << forecast << " cells, made: " << n_cells;
    trial.settle();

    const double shift = dim == 2 ? .31 : .5;
    trial.move_structure(shift);
    trial.settle();
    RefinementTrial<dim> fresh(name, block);
    fresh.move_structure(shift);
    fresh.settle();
    EXPECT_EQ(trial.levels_at_structure(), fresh.levels_at_structure())
      << "cells where the structure is now, and where it had been from the start";
  }


  /// Quadratic velocities and affine pressures are on the new mesh what they were.
  template <int dim>
  void
  check_fields(const std::string &name, const std::string &block)
  {
    RefinementTrial<dim> trial(name, block);
    EulerianSpace<dim> &space = *trial.space;
    const auto half           = [](const dealii::Point<dim> &x) { return .5 * exact_velocity(x); };
    set_velocity(space, space.velocity, exact_velocity<dim>);
    set_velocity(space, space.old_velocity, half);
    set_pressure(space, space.pressure, exact_pressure<dim>);
    for (const double shift : {0., .2})
      {
        trial.move_structure(shift);
        trial.settle();
        EXPECT_LT(distance_at_nodes(space, space.velocity, exact_velocity<dim>), 1e-11);
        EXPECT_LT(distance_at_nodes(space, space.old_velocity, half), 1e-11);
        PressureVector exact = space.make_pressure(), found = space.pressure;
        set_pressure(space, exact, exact_pressure<dim>);
        exact.zero_out_ghost_values();
        found.zero_out_ghost_values();
        exact -= found;
        EXPECT_LT(exact.linfty_norm(), 1e-11);
      }
  }


  /// Whatever the flow, flags are set on locally owned cells only, and levels stay within
  /// minimum_level and maximum_level where the block has such keys.
  template <int dim>
  void
  check_levels(const std::string &name, const std::string &block)
  {
    const Parameters filled = filled_block("refinement", name, block);
    const int least         = filled.has("minimum_level") ? filled.integer("minimum_level") : 0,
              most          = filled.has("maximum_level") ? filled.integer("maximum_level") : 100;
    RefinementTrial<dim> trial(name, block);
    for (unsigned int n = 0; n < (dim == 2 ? 6 : 3); ++n)
      {
        trial.make_rough(n);
        trial.strategy->plan(*trial.space, trial.structures);
        trial.space->adapt(
          [&](auto &mesh) {
            trial.strategy->mark(mesh, *trial.space, trial.structures);
            for (const auto &cell : mesh.active_cell_iterators())
              EXPECT_TRUE(cell->is_locally_owned() ||
                          !(cell->refine_flag_set() || cell->coarsen_flag_set()))
                << "a flag on a cell of another rank, at " << cell->center();
          },
          true);
        for (const auto &cell : trial.space->cells())
          {
            EXPECT_GE(int(cell.level), least) << "the cell at " << cell.lower;
            EXPECT_LE(int(cell.level), most) << "the cell at " << cell.lower;
          }
      }
  }


  /// A run that is taken up from a checkpoint by new objects adapts to the same mesh.
  template <int dim>
  void
  check_refinement_checkpoint(const std::string &name, const std::string &block)
  {
    RefinementTrial<dim> trial(name, block);
    for (unsigned int n = 0; n < 2; ++n)
      {
        trial.make_rough(n);
        trial.strategy->adapt(*trial.space, trial.structures);
      }
    MemoryCheckpoint<dim> checkpoint;
    trial.archive(checkpoint);
    RefinementTrial<dim> resumed(name, block);
    checkpoint.start_reading(*resumed.space);
    resumed.archive(checkpoint);
    for (unsigned int n = 0; n < 2; ++n)
      {
        for (RefinementTrial<dim> *const one : {&trial, &resumed})
          {
            one->move_structure(.1);
            one->make_rough(n + 2);
            one->strategy->adapt(*one->space, one->structures);
          }
        EXPECT_EQ(cells_of(*resumed.space), cells_of(*trial.space));
      }
  }


  /// On several ranks the same cells come out as on one.
  template <int dim>
  void
  check_refinement_ranks(const std::string &name, const std::string &block)
  {
    RefinementTrial<dim> together(name, block), alone(name, block, MPI_COMM_SELF);
    for (unsigned int n = 0; n < 3; ++n)
      {
        for (RefinementTrial<dim> *const one : {&together, &alone})
          {
            if (n > 0)
              one->make_rough(n);
            one->strategy->adapt(*one->space, one->structures);
            one->move_structure(.1);
          }
        EXPECT_EQ(cells_of(*together.space), cells_of(*alone.space));
      }
  }


  /// What every refinement strategy must keep, tried for each example of its schema in 2 and 3
  /// dimensions. Include it in one source of a test program; with navier_stokes, membrane and
  /// neo_hookean among the plugins.
  class RefinementStrategyKit : public ::testing::TestWithParam<std::string>
  {
  protected:
    using Requirement = std::function<void(const std::string &, const std::string &)>;

    void
    check(const Requirement &in_2d, const Requirement &in_3d) const
    {
      for_each_example<RefinementStrategy<2>>(GetParam(), [&](const std::string &block) {
        {
          SCOPED_TRACE("dimension 2");
          in_2d(GetParam(), block);
        }
        SCOPED_TRACE("dimension 3");
        in_3d(GetParam(), block);
      });
    }
  };

  TEST_P(RefinementStrategyKit, ComesToRestAndFollowsStructures)
  {
    check(check_mesh<2>, check_mesh<3>);
  }

  TEST_P(RefinementStrategyKit, KeepsFields)
  {
    check(check_fields<2>, check_fields<3>);
  }

  TEST_P(RefinementStrategyKit, KeepsToItsLevels)
  {
    check(check_levels<2>, check_levels<3>);
  }

  TEST_P(RefinementStrategyKit, GoesOnFromACheckpoint)
  {
    check(check_refinement_checkpoint<2>, check_refinement_checkpoint<3>);
  }

  TEST_P(RefinementStrategyKit, DoesNotDependOnTheNumberOfRanks)
  {
    check(check_refinement_ranks<2>, check_refinement_ranks<3>);
  }
} // namespace feib::testing

/// Runs the conformance kit for the refinement strategy of that name.
#define FEIB_TEST_REFINEMENT_STRATEGY(name) FEIB_TEST_REFINEMENT_STRATEGY_(name, __LINE__)
#define FEIB_TEST_REFINEMENT_STRATEGY_(name, line) FEIB_TEST_REFINEMENT_STRATEGY__(name, line)
#define FEIB_TEST_REFINEMENT_STRATEGY__(name, line)                        \
  namespace feib::testing                                                  \
  {                                                                        \
    INSTANTIATE_TEST_SUITE_P(Line##line,                                   \
                             RefinementStrategyKit,                        \
                             ::testing::Values(std::string(name)),         \
                             [](const auto &info) { return info.param; }); \
  }                                                                        \
  static_assert(true, "")

#endif
