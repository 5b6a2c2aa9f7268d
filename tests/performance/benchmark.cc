// SPDX-License-Identifier: LGPL-2.1-or-later
// Seconds of the parts of a step, in Release: location with interpolation, spreading, the load of a
// structure and the fluid's step. The argument is the number of cells in each direction.
#include <feib/fluid_solver.h>
#include <feib/immersed_structure.h>
#include <feib/log.h>
#include <feib/testing/spaces.h>

#include <benchmark/benchmark.h>

namespace
{
  using namespace feib;

  /// A circular membrane with two nodes per cell edge in an N x N box.
  struct Membrane
  {
    explicit Membrane(const unsigned int n)
      : space(feib::testing::make_space<2>("{\"cells\": [" + std::to_string(n) + "," +
                                           std::to_string(n) + "]}"))
      , model(feib::testing::registry().create<StructureModel<2>>(
          "membrane",
          "{\"name\": \"circle\", \"mesh\": {\"closed_curve\": {\"length\": 1.8849555921538759, "
          "\"elements\": " +
            std::to_string(4 * n) +
            "}}, \"initial_position\": [\"0.5+0.3*cos(s1/0.3)\", \"0.5+0.3*sin(s1/0.3)\"], "
            "\"law\": {\"anisotropic_linear\": {\"stiffness\": 1}}}"))
      , coupling(feib::testing::registry().create<CouplingOperator<2>>("variational"))
      , nodes(LagrangianPoints::nodes(model->mesh().n_nodes()))
      , u(space->make_velocity())
      , U(model->mesh().n_nodes())
    {
      coupling->set_geometry(*space, model->mesh(), model->positions, nodes);
    }

    std::unique_ptr<EulerianSpace<2>> space;
    std::unique_ptr<StructureModel<2>> model;
    std::unique_ptr<CouplingOperator<2>> coupling;
    LagrangianPoints nodes;
    VelocityVector u;
    NodalField<2> U;
  };

  void
  locate_and_interpolate(benchmark::State &state)
  {
    Membrane membrane(state.range(0));
    for (auto _ : state)
      {
        membrane.coupling->set_geometry(*membrane.space,
                                        membrane.model->mesh(),
                                        membrane.model->positions,
                                        membrane.nodes);
        membrane.coupling->interpolate(*membrane.space, membrane.u, membrane.U);
      }
    state.counters["points/s"] =
      benchmark::Counter(membrane.U.size() * state.iterations(), benchmark::Counter::kIsRate);
  }

  void
  spread(benchmark::State &state)
  {
    Membrane membrane(state.range(0));
    for (auto _ : state)
      membrane.coupling->spread(*membrane.space, membrane.U, membrane.u);
    state.counters["points/s"] =
      benchmark::Counter(membrane.U.size() * state.iterations(), benchmark::Counter::kIsRate);
  }

  void
  structure_load(benchmark::State &state)
  {
    Membrane membrane(state.range(0));
    for (auto _ : state)
      membrane.model->load(membrane.model->positions, membrane.U);
    state.counters["elements/s"] =
      benchmark::Counter(membrane.U.size() * state.iterations(), benchmark::Counter::kIsRate);
  }

  void
  fluid_step(benchmark::State &state)
  {
    Membrane membrane(state.range(0));
    auto &space = *membrane.space;
    const auto fluid =
      feib::testing::registry().create<FluidSolver<2>>("navier_stokes",
                                                       "{\"density\": 1, \"viscosity\": 0.01}");
    fluid->initialize(space);
    NodalField<2> load;
    membrane.model->load(membrane.model->positions, load);
    double time = 0;
    for (auto _ : state)
      {
        space.older_velocity = space.old_velocity;
        space.old_velocity   = space.velocity;
        VelocityVector rhs   = space.make_velocity();
        membrane.coupling->spread(space, load, rhs);
        fluid->advance(space, {time += 1e-3, 1e-3, rhs});
        space.old_dt = 1e-3;
      }
    state.counters["unknowns"] =
      space.velocity_handler().n_dofs() + space.pressure_handler().n_dofs();
  }
} // namespace

BENCHMARK(locate_and_interpolate)->Arg(32)->Arg(128);
BENCHMARK(spread)->Arg(32)->Arg(128);
BENCHMARK(structure_load)->Arg(32)->Arg(128);
BENCHMARK(fluid_step)->Arg(32)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);

int
main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  feib::log::set_level("off");
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
