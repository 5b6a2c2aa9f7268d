// SPDX-License-Identifier: LGPL-2.1-or-later
// Seconds of the parts of a step, in Release: the parts of the couplings, the load of a
// structure and the fluid's step. The argument is the number of cells in each direction.
#include <feib/fluid_solver.h>
#include <feib/immersed_structure.h>
#include <feib/log.h>
#include <feib/testing/spaces.h>

#include <benchmark/benchmark.h>

namespace
{
  using namespace feib;

  /// A circular or spherical membrane with about two nodes per cell edge, in a box of n cells in
  /// each direction.
  template <int dim>
  struct Membrane
  {
    explicit Membrane(const unsigned int n, const std::string &coupling_name = "variational")
      : space(feib::testing::make_space<dim>("{\"cells\": [" + std::to_string(n) + "," +
                                             std::to_string(n) +
                                             (dim == 3 ? "," + std::to_string(n) : "") + "]}"))
      , model(feib::testing::registry().create<StructureModel<dim>>(
          "membrane",
          dim == 2
            ? "{\"name\": \"circle\", \"mesh\": {\"closed_curve\": {\"length\": "
              "1.8849555921538759, "
              "\"elements\": " +
                std::to_string(4 * n) +
                "}}, \"initial_position\": [\"0.5+0.3*cos(s1/0.3)\", \"0.5+0.3*sin(s1/0.3)\"], "
                "\"law\": {\"anisotropic_linear\": {\"stiffness\": 1}}}"
            : "{\"name\": \"sphere\", \"mesh\": {\"sphere\": {\"centre\": [0.5, 0.5, 0.5], "
              "\"radius\": 0.3, \"refinements\": " +
                std::to_string(n < 12   ? 3
                               : n < 24 ? 4
                                        : 5) +
                "}}, \"law\": {\"neo_hookean\": {\"shear_modulus\": 1}}}"))
      , coupling(feib::testing::registry().create<CouplingOperator<dim>>(coupling_name))
      , nodes(LagrangianPoints::nodes(model->mesh().n_nodes()))
      , u(space->make_velocity())
      , U(model->mesh().n_nodes())
    {
      set_geometry();
    }

    void
    set_geometry()
    {
      coupling->set_geometry(*space, model->mesh(), model->positions, nodes);
    }

    /// The pieces that the cells cut the membrane into.
    unsigned int
    n_pieces() const
    {
      unsigned int n = 0;
      for (const auto &facet : model->mesh().surface())
        {
          std::array<dealii::Point<dim>, dim> corners;
          for (unsigned int v = 0; v < dim; ++v)
            corners[v] = model->positions[facet[v]];
          space->forest().cut(corners, [&](unsigned int, const auto &) { ++n; });
        }
      return n;
    }

    std::unique_ptr<EulerianSpace<dim>> space;
    std::unique_ptr<StructureModel<dim>> model;
    std::unique_ptr<CouplingOperator<dim>> coupling;
    LagrangianPoints nodes;
    VelocityVector u;
    NodalField<dim> U;
  };

  /// What the parts of a coupling cost: per piece for a coupling that cuts, else per point.
  template <int dim>
  void
  couple(benchmark::State &state, const std::string &name, const std::string &part)
  {
    Membrane<dim> membrane(state.range(0), name);
    for (auto _ : state)
      if (part == "set_geometry")
        membrane.set_geometry();
      else if (part == "interpolate")
        membrane.coupling->interpolate(*membrane.space, membrane.u, membrane.U);
      else
        membrane.coupling->spread(*membrane.space, membrane.U, membrane.u);
    const double n           = name == "variational" ? membrane.U.size() : membrane.n_pieces();
    state.counters["pieces"] = n;
    state.counters["s/piece"] =
      benchmark::Counter(n * state.iterations(),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  }

  void
  structure_load(benchmark::State &state)
  {
    Membrane<2> membrane(state.range(0));
    for (auto _ : state)
      membrane.model->load(membrane.model->positions, membrane.U);
    state.counters["elements/s"] =
      benchmark::Counter(membrane.U.size() * state.iterations(), benchmark::Counter::kIsRate);
  }

  void
  fluid_step(benchmark::State &state)
  {
    Membrane<2> membrane(state.range(0));
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
        fluid->commit();
        space.old_dt = 1e-3;
      }
    state.counters["unknowns"] =
      space.velocity_handler().n_dofs() + space.pressure_handler().n_dofs();
  }
} // namespace

BENCHMARK(structure_load)->Arg(32)->Arg(128);
BENCHMARK(fluid_step)->Arg(32)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);

int
main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  feib::log::set_level("off");
  for (const std::string name : {"variational", "divergence_free"})
    for (const std::string part : {"set_geometry", "interpolate", "spread"})
      {
        const auto title = [&](const char *dim) { return name + "/" + part + "/" + dim; };
        benchmark::RegisterBenchmark(title("2D").c_str(), couple<2>, name, part)->Arg(128);
        benchmark::RegisterBenchmark(title("3D").c_str(), couple<3>, name, part)->Arg(16);
      }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
