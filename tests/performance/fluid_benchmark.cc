// SPDX-License-Identifier: LGPL-2.1-or-later
// Rates of the fluid's kernels and cycles on one core, with the triad of the same machine for a
// measure. The argument is the number of cells in each direction, and the number of refinements
// around a circle or sphere. DoF/s counts velocity unknowns (for the pressure's cycle pressures);
// B/DoF is the least traffic there can be: indices, what is read, and twice what is written.
#include "operators/fluid_operators.h"
#include "multigrid/stokes_multigrid.h"

#include <feib/testing/spaces.h>

#include <benchmark/benchmark.h>

namespace
{
  using namespace feib;

  template <int dim>
  std::unique_ptr<EulerianSpace<dim>>
  make(const benchmark::State &state)
  {
    const std::string n = std::to_string(state.range(0));
    auto space          = feib::testing::make_space<dim>("{\"cells\": [" + n + "," + n +
                                                (dim == 3 ? "," + n : "") + "]}");
    for (int i = 0; i < state.range(1); ++i)
      feib::testing::refine_where(*space, [&](const auto &x) {
        dealii::Point<dim> centre;
        for (unsigned int a = 0; a < dim; ++a)
          centre[a] = .5;
        return std::abs(x.distance(centre) - .3) < 1.2 * space->smallest_edge();
      });
    return space;
  }

  void
  count(benchmark::State &state, const double unknowns, const double bytes)
  {
    state.counters["DoF"] = unknowns;
    state.counters["DoF/s"] =
      benchmark::Counter(unknowns * state.iterations(), benchmark::Counter::kIsRate);
    if (bytes > 0)
      {
        state.counters["B/DoF"] = bytes / unknowns;
        state.counters["B/s"] =
          benchmark::Counter(bytes * state.iterations(), benchmark::Counter::kIsRate);
      }
  }

  /// a = b + s c on arrays of so many bytes together.
  void
  triad(benchmark::State &state)
  {
    const std::size_t n = state.range(0) / 3 / sizeof(double);
    std::vector<double> a(n, 0.), b(n, 1.), c(n, 2.);
    for (auto _ : state)
      {
        for (std::size_t i = 0; i < n; ++i)
          a[i] = b[i] + 3. * c[i];
        benchmark::DoNotOptimize(a.data());
        benchmark::ClobberMemory();
      }
    // With what a cache reads of a line before it is written.
    state.counters["B/s"] =
      benchmark::Counter(4. * n * sizeof(double) * state.iterations(), benchmark::Counter::kIsRate);
  }

  /// The velocity's operator on the finest level, with independent components; and (coupled) with
  /// the symmetric gradient and the augmentation, as in the cycle.
  template <int dim, typename Number, bool coupled>
  void
  velocity_form(benchmark::State &state)
  {
    const auto space = make<dim>(state);
    const LatticeCells<dim> mesh(*space);
    const MultigridLevel<dim> level(mesh, space->domain(), MPI_COMM_SELF, false, nullptr, nullptr);
    LevelVector<Number> u, result;
    level.reinit_velocity(u);
    level.reinit_velocity(result);
    for (unsigned int i = 0; i < u.size(); ++i)
      u.local_element(i) = level.inactive(i) ? 0. : i % 7;
    level.expand(u);
    for (auto _ : state)
      level.apply_velocity_form({1e3, 1., coupled ? 1. : 0., 0., coupled ? 4. : 0.}, u, result);
    count(state,
          u.size(),
          u.size() * 3. * sizeof(Number) +
            space->cells().size() * EulerianSpace<dim>::n_nodes * sizeof(unsigned int));
  }

  /// The residual of the Stokes equations on the vectors of the space, in double precision.
  template <int dim>
  void
  stokes_residual(benchmark::State &state)
  {
    const auto space = make<dim>(state);
    FluidOperators<dim> operators({1., 1., 0., true, ConvectiveForm::skew_symmetric});
    operators.reinit(*space);
    VelocityVector r = space->make_velocity();
    PressureVector g = space->make_pressure();
    for (auto _ : state)
      operators.subtract_stokes(1e3, space->velocity, space->pressure, r, g);
    count(state,
          r.size(),
          (r.size() + g.size()) * 3. * sizeof(double) +
            space->cells().size() *
              (EulerianSpace<dim>::n_velocity + EulerianSpace<dim>::n_pressure) *
              sizeof(unsigned int));
  }

  /// Linearised convection, as in every iteration of a step.
  template <int dim, ConvectiveForm form>
  void
  convection(benchmark::State &state)
  {
    const auto space = make<dim>(state);
    FluidOperators<dim> operators({1., 1., 0., true, form});
    operators.reinit(*space);
    operators.convection().set_velocity(space->velocity);
    VelocityVector r = space->make_velocity();
    for (auto _ : state)
      operators.convection().add(1., space->velocity, r);
    count(state, r.size(), 0);
  }

  /// A cycle for one block, or the preconditioner with both.
  template <int dim>
  void
  cycle(benchmark::State &state, const std::string &block)
  {
    const auto space = make<dim>(state);
    StokesMultigrid<dim> multigrid;
    // Diffusion over some cells in a step: cycles over all levels.
    const double h = space->smallest_edge();
    multigrid.prepare(*space, {1., 10 * h * h, 10 * h * h, 0.});
    VelocityVector f = space->make_velocity(), u = space->make_velocity();
    PressureVector g = space->make_pressure(), p = space->make_pressure();
    for (unsigned int i = 0; i < f.size(); ++i)
      f.local_element(i) = i % 7 - 3.;
    for (unsigned int i = 0; i < g.size(); ++i)
      g.local_element(i) = i % 5 - 2.;
    space->condense(f);
    for (auto _ : state)
      if (block == "velocity")
        multigrid.solve_velocity(f, u);
      else if (block == "pressure")
        multigrid.solve_pressure(g, p);
      else
        multigrid.solve(f, g, u, p);
    count(state, block == "pressure" ? p.size() : u.size(), 0);
  }

  void
  cycle_2d(benchmark::State &state, const std::string &block)
  {
    cycle<2>(state, block);
  }

  void
  cycle_3d(benchmark::State &state, const std::string &block)
  {
    cycle<3>(state, block);
  }

  /// Levels, transfer and what depends on them, for a new mesh.
  template <int dim>
  void
  set_up(benchmark::State &state)
  {
    const auto space = make<dim>(state);
    for (auto _ : state)
      {
        StokesMultigrid<dim> multigrid;
        multigrid.prepare(*space, {1e3, 1., 1., 0.});
      }
    count(state, space->velocity.size(), 0);
  }

  template <int dim>
  void
  sizes(benchmark::internal::Benchmark *benchmark)
  {
    benchmark->Unit(benchmark::kMillisecond);
    if (dim == 2)
      benchmark->Args({64, 0})->Args({128, 0})->Args({256, 0})->Args({64, 2});
    else
      benchmark->Args({16, 0})->Args({32, 0})->Args({16, 1});
  }
} // namespace

BENCHMARK(triad)->Arg(1 << 18)->Arg(24 << 20)->Arg(240 << 20)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(velocity_form, 2, double, false)->Apply(sizes<2>);
BENCHMARK_TEMPLATE(velocity_form, 2, float, false)->Apply(sizes<2>);
BENCHMARK_TEMPLATE(velocity_form, 2, float, true)->Apply(sizes<2>);
BENCHMARK_TEMPLATE(velocity_form, 3, double, false)->Apply(sizes<3>);
BENCHMARK_TEMPLATE(velocity_form, 3, float, false)->Apply(sizes<3>);
BENCHMARK_TEMPLATE(velocity_form, 3, float, true)->Apply(sizes<3>);
BENCHMARK_TEMPLATE(stokes_residual, 2)->Apply(sizes<2>);
BENCHMARK_TEMPLATE(stokes_residual, 3)->Apply(sizes<3>);
BENCHMARK_TEMPLATE(convection, 2, ConvectiveForm::rotational)->Apply(sizes<2>);
BENCHMARK_TEMPLATE(convection, 3, ConvectiveForm::rotational)->Apply(sizes<3>);
BENCHMARK_TEMPLATE(convection, 2, ConvectiveForm::skew_symmetric)->Apply(sizes<2>);
BENCHMARK_TEMPLATE(convection, 3, ConvectiveForm::skew_symmetric)->Apply(sizes<3>);
BENCHMARK_CAPTURE(cycle_2d, velocity, "velocity")->Apply(sizes<2>);
BENCHMARK_CAPTURE(cycle_2d, pressure, "pressure")->Apply(sizes<2>);
BENCHMARK_CAPTURE(cycle_2d, both, "both")->Apply(sizes<2>);
BENCHMARK_CAPTURE(cycle_3d, velocity, "velocity")->Apply(sizes<3>);
BENCHMARK_CAPTURE(cycle_3d, pressure, "pressure")->Apply(sizes<3>);
BENCHMARK_CAPTURE(cycle_3d, both, "both")->Apply(sizes<3>);
BENCHMARK_TEMPLATE(set_up, 2)->Apply(sizes<2>);
BENCHMARK_TEMPLATE(set_up, 3)->Apply(sizes<3>);
