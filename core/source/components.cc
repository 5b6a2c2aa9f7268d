// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components.h"
#include "law_check.h"

#include <feib/expression.h>
#include <feib/registry.h>

#include <set>
#include <sstream>

namespace feib
{
  namespace
  {
    /// Builds one part; its issues join those of the others.
    template <class Build>
    void
    collect(Issues &issues, const Build &build)
    {
      try
        {
          build();
        }
      catch (const Error &error)
        {
          issues.insert(issues.end(), error.issues().begin(), error.issues().end());
        }
    }
  } // namespace


  template <int dim>
  Components<dim>::Components(const Parameters &parameters)
  {
    Issues issues;
    collect(issues, [&] {
      space = std::make_unique<EulerianSpace<dim>>(Domain<dim>(parameters.child("domain")));
    });
    collect(issues, [&] { fluid = parameters.child("fluid").template create<FluidSolver<dim>>(); });
    build_structures(parameters, issues);
    build_time(parameters.child("time"), issues);
    collect(issues, [&] {
      refinement = parameters.child("refinement").template create<RefinementStrategy<dim>>();
    });
    build_outputs(parameters, issues);
    if (!issues.empty())
      throw Error(issues);
  }


  template <int dim>
  void
  Components<dim>::build_time(const Parameters &parameters, Issues &issues)
  {
    integrator_name = parameters.child("integrator").choice().first;
    collect(issues, [&] {
      if (!space)
        return;
      const auto size = space->domain().upper - space->domain().lower;
      double shortest = size[0];
      for (unsigned int a = 1; a < dim; ++a)
        shortest = std::min(shortest, size[a]);
      control = std::make_unique<StepControl>(parameters, shortest);
    });
    collect(issues, [&] {
      integrator = parameters.child("integrator").template create<TimeIntegrator<dim>>();
    });
  }


  template <int dim>
  void
  Components<dim>::build_structures(const Parameters &parameters, Issues &issues)
  {
    std::set<std::string> names;
    for (const Parameters &slot : parameters.children("structures"))
      collect(issues, [&] {
        ImmersedStructure<dim> structure;
        structure.model  = slot.template create<StructureModel<dim>>();
        structure.motion = parameters.child("coupling").template create<CouplingOperator<dim>>();
        const unsigned int n_nodes          = structure.model->mesh().n_nodes();
        structure.nodes                     = LagrangianPoints::nodes(n_nodes);
        const LagrangianPoints &load_points = structure.model->load_points();
        if (!load_points.are_nodes(n_nodes))
          structure.loading = parameters.child("coupling").template create<CouplingOperator<dim>>();

        const Parameters block = slot.choice().second;
        if (structure.model->name() == "fluid")
          block.fail("name", "found \"fluid\", the name of the fluid's own files");
        if (!names.insert(structure.model->name()).second)
          block.fail("name",
                     "found \"" + structure.model->name() +
                       "\" a second time; every structure needs a name of its own");
        if (space)
          for (unsigned int i = 0; i < n_nodes; ++i)
            if (!space->forest().inside(structure.model->positions[i]))
              {
                std::ostringstream message;
                message << "the structure \"" << structure.model->name()
                        << "\" is not inside the box: node " << i << " starts at ("
                        << structure.model->positions[i] << "), the box goes from ("
                        << space->domain().lower << ") to (" << space->domain().upper << ")";
                block.fail(block.has("initial_position") ? "initial_position" : "mesh",
                           message.str());
              }
        check_law(*structure.model, slot);
        initial_positions.push_back(structure.model->positions);
        structures.push_back(std::move(structure));
      });
  }


  template <int dim>
  void
  Components<dim>::build_outputs(const Parameters &parameters, Issues &issues)
  {
    std::set<std::string> names;
    for (const Parameters &output : parameters.children("output"))
      collect(issues, [&] {
        writers.push_back(output.template create<OutputWriter<dim>>());
        const auto [component, block] = output.choice();
        if (block.has("name") && !names.insert(component + " " + block.string("name")).second)
          block.fail("name",
                     "found \"" + block.string("name") + "\" a second time; every " + component +
                       " needs a name of its own");
      });

    if (!parameters.has("exact"))
      return;
    const Parameters exact = parameters.child("exact");
    collect(issues, [&] {
      if (exact.has("velocity"))
        exact_velocity = parse_expressions<dim>(exact, "velocity", dim, Variables::space_time);
      else
        exact_velocity = std::make_unique<dealii::Functions::ZeroFunction<dim>>(dim);
    });
    collect(issues, [&] {
      if (exact.has("pressure"))
        exact_pressure = parse_expressions<dim>(exact, "pressure", 1, Variables::space_time);
    });
  }


  template struct Components<2>;
  template struct Components<3>;
} // namespace feib
