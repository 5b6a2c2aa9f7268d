// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_trial_h
#define feib_testing_trial_h

#include <feib/case.h>
#include <feib/inertial_load.h>
#include <feib/testing/plugins.h>
#include <feib/time_integrator.h>

namespace feib::testing
{
  /// The components of a case, taken in hand: step() does what a run does in a step, without
  /// refinement, control and output.
  template <int dim>
  class Trial
  {
  public:
    using Report = typename TimeIntegrator<dim>::Report;

    explicit Trial(Case description_, const MPI_Comm communicator = MPI_COMM_WORLD)
      : description(std::move(description_))
      , space(Domain<dim>(description.parameters().child("domain")), communicator)
      , fluid(description.parameters().child("fluid").create<FluidSolver<dim>>())
      , scheme(
          description.parameters().child("time").child("integrator").create<TimeIntegrator<dim>>())
      , dt(description.parameters().child("time").number("step"))
    {
      for (const Parameters &slot : description.parameters().children("structures"))
        {
          structures.emplace_back();
          ImmersedStructure<dim> &structure = structures.back();
          structure.model                   = slot.create<StructureModel<dim>>();
          const Parameters coupling         = description.parameters().child("coupling");
          structure.motion                  = coupling.create<CouplingOperator<dim>>();
          structure.nodes = LagrangianPoints::nodes(structure.model->mesh().n_nodes());
          if (structure.model->load_points().nodes_per_point != 1)
            structure.loading = coupling.create<CouplingOperator<dim>>();
          structure.set_geometry(space, structure.model->positions);
        }
      InertialLoad<dim> inertia(space, structures, 1.);
      fluid->initialize(space, inertia.empty() ? nullptr : &inertia);
      space.old_velocity = space.older_velocity = space.velocity;
      for (ImmersedStructure<dim> &structure : structures)
        structure.motion->interpolate(space, space.velocity, structure.model->velocities);
    }

    typename TimeIntegrator<dim>::System
    system()
    {
      return {space, *fluid, structures, timers};
    }

    /// A step of length dt. When it throws, the state is to be read from an archive.
    Report
    step()
    {
      space.older_velocity = space.old_velocity;
      space.old_velocity   = space.velocity;
      auto all             = system();
      const Report report  = scheme->step(all, time, dt);
      time += dt;
      space.old_dt = dt;
      space.set_time(time);
      fluid->commit();
      return report;
    }

    /// What a run goes on from.
    void
    archive(Archive &archive)
    {
      archive("space", space);
      archive("fluid", *fluid);
      archive("integrator", *scheme);
      for (ImmersedStructure<dim> &structure : structures)
        {
          const std::string name = "structure_" + structure.model->name();
          archive(name, *structure.model);
          archive(name + "_motion", *structure.motion);
          if (structure.loading)
            archive(name + "_loading", *structure.loading);
        }
      archive("now", time);
    }

    /// Elastic energy and kinetic energy of the excess mass of a structure.
    static double
    energy_of(const StructureModel<dim> &model)
    {
      double result = model.energy(model.positions);
      for (unsigned int i = 0; i < model.excess_mass().size(); ++i)
        result += model.excess_mass()[i] / 2 * model.velocities[i].norm_square();
      return result;
    }

    static dealii::Tensor<1, dim>
    momentum_of(const StructureModel<dim> &model)
    {
      dealii::Tensor<1, dim> result;
      for (unsigned int i = 0; i < model.excess_mass().size(); ++i)
        result += model.excess_mass()[i] * model.velocities[i];
      return result;
    }

    /// Of the fluid and all structures.
    double
    energy() const
    {
      double result = fluid->balance(space).kinetic_energy;
      for (const ImmersedStructure<dim> &structure : structures)
        result += energy_of(*structure.model);
      return result;
    }

    dealii::Tensor<1, dim>
    momentum() const
    {
      dealii::Tensor<1, dim> result = fluid->balance(space).momentum;
      for (const ImmersedStructure<dim> &structure : structures)
        result += momentum_of(*structure.model);
      return result;
    }

    const Case description;
    EulerianSpace<dim> space;
    std::unique_ptr<FluidSolver<dim>> fluid;
    std::vector<ImmersedStructure<dim>> structures;
    std::unique_ptr<TimeIntegrator<dim>> scheme;
    Timers timers;
    double dt;
    double time = 0;
  };
} // namespace feib::testing

#endif
