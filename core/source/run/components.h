// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_components_h
#define feib_components_h

#include "coefficients.h"
#include "earlier_flow.h"
#include "step_control.h"

#include <feib/output_writer.h>
#include <feib/refinement_strategy.h>
#include <feib/time_integrator.h>

#include <memory>
#include <optional>

namespace feib
{
  /// What a case names, built and put together.
  template <int dim>
  struct Components
  {
    /// Builds all, makes the first mesh and checks what a schema cannot. Throws Error with all
    /// issues. @p goes_on: from a checkpoint, without the earlier flow. Collective.
    Components(const Parameters &parameters, bool goes_on);

    typename TimeIntegrator<dim>::System
    system()
    {
      return {*space, *fluid, structures, timers};
    }

    std::unique_ptr<EulerianSpace<dim>> space;
    std::unique_ptr<FluidSolver<dim>> fluid;
    std::vector<ImmersedStructure<dim>> structures;
    std::unique_ptr<TimeIntegrator<dim>> integrator;
    std::string integrator_name;
    std::unique_ptr<RefinementStrategy<dim>> refinement;
    std::vector<std::unique_ptr<OutputWriter<dim>>> writers;
    std::vector<std::string> writer_names; // component, and name where there is one
    std::unique_ptr<dealii::Function<dim>> exact_velocity, exact_pressure; // null when not given
    std::optional<Coefficients<dim>> coefficients;                         // none when not given
    std::unique_ptr<const EarlierFlow<dim>> earlier_flow;                  // null when not given
    std::unique_ptr<StepControl> control;
    Timers timers;

    /// Whether an element of a structure is longer than the box, as after an unstable step in a
    /// periodic one.
    bool torn(const StructureModel<dim> &model) const;

  private:
    void build_time(const Parameters &parameters, Issues &issues);
    void build_structures(const Parameters &parameters, Issues &issues);
    void build_forces(StructureModel<dim> &model,
                      const Parameters &block,
                      const std::vector<double> &times);
    void check_density(const StructureModel<dim> &model, const Parameters &block) const;
    void build_outputs(const Parameters &parameters, Issues &issues);
    void build_exact(const Parameters &parameters, Issues &issues);
    void make_mesh(const CheckContext<dim> &context, Issues &issues);
    void check(const CheckContext<dim> &context, double end, Issues &issues);
    void check_coupling(const ImmersedStructure<dim> &structure) const;

    std::vector<Expressions<dim> *> exact_expressions; // those of the two that the case gives
  };
} // namespace feib

#endif
