// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components.h"

#include "error_norms.h"
#include "forecast.h"
#include "law_check.h"

#include <feib/expression.h>
#include <feib/lattice.h>
#include <feib/message.h>
#include <feib/registry.h>

#include <cmath>
#include <limits>
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


    /// Refuses cells too small to have places of their own.
    template <int dim>
    void
    check_levels(const Domain<dim> &box, const unsigned int finest_level)
    {
      try
        {
          Lattice<dim>(box, finest_level + 1);
        }
      catch (const RunFailure &failure)
        {
          throw Error("/refinement", failure.what());
        }
    }


    /// Of cells of a level.
    template <int dim>
    double
    shortest_edge(const Domain<dim> &box, const unsigned int level)
    {
      double result = std::numeric_limits<double>::infinity();
      for (unsigned int a = 0; a < dim; ++a)
        result = std::min(result, (box.upper[a] - box.lower[a]) / box.cells[a]);
      return std::ldexp(result, -int(level));
    }
  } // namespace


  template <int dim>
  Components<dim>::Components(const Parameters &parameters, const bool goes_on)
  {
    Issues issues;
    collect(issues, [&] {
      Domain<dim> domain(parameters.child("domain"));
      double n_cells = 1;
      for (const unsigned int n : domain.cells)
        n_cells *= n;
      check_size<dim>(n_cells, domain.pointer + "/cells", parameters.communicator());
      space = std::make_unique<EulerianSpace<dim>>(std::move(domain), parameters.communicator());
    });
    collect(issues, [&] { fluid = parameters.child("fluid").template create<FluidSolver<dim>>(); });
    collect(issues, [&] {
      if (fluid && parameters.has("coefficients"))
        coefficients.emplace(parameters.child("coefficients"), fluid->density());
    });
    collect(issues, [&] {
      if (space && !goes_on && parameters.has("initial_state"))
        earlier_flow =
          std::make_unique<EarlierFlow<dim>>(parameters.child("initial_state"), space->domain());
    });
    collect(issues, [&] {
      refinement = parameters.child("refinement").template create<RefinementStrategy<dim>>();
    });
    const double edge =
      space && refinement ? shortest_edge(space->domain(), refinement->finest_level()) : 0.;
    build_structures(parameters.beside_cells(edge), issues);
    build_time(parameters.child("time"), issues);
    build_outputs(parameters, issues);
    build_exact(parameters, issues);
    if (space)
      {
        const double end                = parameters.child("time").number("end");
        const CheckContext<dim> context = {*space, structures, sample_times(end)};
        make_mesh(context, issues);
        check(context, end, issues);
      }
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
    const double end = parameters.child("time").number("end");
    std::set<std::string> names;
    if (space)
      for (const auto &condition : space->domain().conditions)
        if (!condition.periodic())
          names.insert(condition.name);
    const std::set<std::string> of_faces = names;
    for (const Parameters &slot : parameters.children("structures"))
      collect(issues, [&] {
        ImmersedStructure<dim> structure;
        structure.model  = slot.template create<StructureModel<dim>>();
        structure.motion = parameters.child("coupling").template create<CouplingOperator<dim>>();
        const unsigned int n_nodes = structure.model->mesh().n_nodes();
        structure.nodes            = LagrangianPoints::nodes(n_nodes);
        if (!structure.model->load_points().are_nodes(n_nodes))
          structure.loading = parameters.child("coupling").template create<CouplingOperator<dim>>();

        const Parameters block = slot.choice().second;
        if (structure.model->name() == "fluid")
          block.fail("name", "found \"fluid\", the name of the fluid's own files");
        if (of_faces.count(structure.model->name()) != 0)
          block.fail("name",
                     "found \"" + structure.model->name() +
                       "\", which columns of the ledger for a face of the box are named by");
        if (structure.model->name() == "convection")
          block.fail("name", "found \"convection\", which columns of the ledger are named by");
        if (!names.insert(structure.model->name()).second)
          block.fail("name",
                     "found \"" + structure.model->name() +
                       "\" a second time; every structure, and every structure and force by "
                       "NAME_FORCE, needs a name of its own in the ledger");
        if (space)
          for (unsigned int i = 0; i < n_nodes; ++i)
            if (!space->forest().inside(structure.model->positions[i]))
              {
                std::ostringstream message;
                message << "the structure \"" << structure.model->name()
                        << "\" is not inside the box: node "
                        << structure.model->mesh().node_number(i) << " starts at ("
                        << structure.model->positions[i] << "), the box goes from ("
                        << space->domain().lower << ") to (" << space->domain().upper << ")";
                block.fail(block.has("initial_position") ? "initial_position" : "mesh",
                           message.str());
              }
        if (space && torn(*structure.model))
          block.fail(block.has("initial_position") ? "initial_position" : "mesh",
                     "tears the structure: one of its elements is longer than the box");
        check_density(*structure.model, block);
        check_law(*structure.model, slot);
        build_forces(*structure.model, block, sample_times(end));
        for (const std::string &force : structure.model->force_names())
          if (!names.insert(structure.model->name() + "_" + force).second)
            block.fail("forces",
                       "have a force called \"" + force + "\": the ledger would have \"" +
                         structure.model->name() + "_" + force +
                         "\" twice, as there is another structure, force of one, or part of a "
                         "face by that name");
        structures.push_back(std::move(structure));
      });
  }


  template <int dim>
  void
  Components<dim>::build_forces(StructureModel<dim> &model,
                                const Parameters &block,
                                const std::vector<double> &times)
  {
    if (!block.has("forces") || !space) // without a box its faults are told
      return;
    std::vector<std::unique_ptr<StructureForce<dim>>> forces;
    std::set<std::string> names;
    for (const Parameters &slot : block.children("forces"))
      {
        const auto [component, parameters] = slot.choice();
        forces.push_back(slot.template create<StructureForce<dim>>());
        forces.back()->name = parameters.has("name") ? parameters.word("name") : component;
        if (!names.insert(forces.back()->name).second)
          parameters.fail(parameters.has("name") ? "name" : "",
                          "is a second force called \"" + forces.back()->name +
                            "\"; each force of a structure needs a name of its own");
        forces.back()->attach(
          {model.mesh(), model.positions, model.excess_mass(), times, space->domain()});
      }
    model.set_forces(std::move(forces));
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
        const std::string name        = block.has("name") ? block.string("name") : "";
        writer_names.push_back(component + (name.empty() ? "" : "_" + name));
        if (names.insert(component + " " + name).second)
          return;
        if (name.empty())
          block.fail("", "stands here a second time, and would write the same files");
        block.fail("name",
                   "found \"" + name + "\" a second time; every " + component +
                     " needs a name of its own");
      });
  }


  template <int dim>
  void
  Components<dim>::build_exact(const Parameters &parameters, Issues &issues)
  {
    if (!parameters.has("exact"))
      return;
    const Parameters exact = parameters.child("exact");
    const auto read        = [&](const std::string &key, const unsigned int n, auto &function) {
      collect(issues, [&] {
        auto expressions = parse_expressions<dim>(exact, key, n, Variables::space_time);
        exact_expressions.push_back(expressions.get());
        function = std::move(expressions);
      });
    };
    if (exact.has("velocity"))
      read("velocity", dim, exact_velocity);
    else
      exact_velocity = std::make_unique<dealii::Functions::ZeroFunction<dim>>(dim);
    if (exact.has("pressure"))
      read("pressure", 1, exact_pressure);
  }


  template <int dim>
  void
  Components<dim>::make_mesh(const CheckContext<dim> &context, Issues &issues)
  {
    if (!refinement)
      return;
    const std::size_t n_issues = issues.size();
    collect(issues, [&] {
      refinement->check(context);
      check_levels(space->domain(), refinement->finest_level());
      check_size<dim>(refinement->forecast_cells(*space, structures),
                      "/refinement",
                      space->communicator());
    });
    if (issues.size() > n_issues)
      return;
    const Timers::Section section(timers, "refinement");
    refinement->adapt(*space, structures);
  }


  template <int dim>
  void
  Components<dim>::check(const CheckContext<dim> &context, const double end, Issues &issues)
  {
    const auto add = [&issues](const Issues &more) {
      issues.insert(issues.end(), more.begin(), more.end());
    };
    add(space->check_boundary(context.times));
    if (fluid)
      collect(issues, [&] { fluid->check(context); });
    for (const auto &writer : writers)
      collect(issues, [&] { writer->check(context); });
    for (Expressions<dim> *exact : exact_expressions)
      add(issues_inside(*space, *exact, end));
    // When all else is right: couplings rely on structures inside the box.
    if (issues.empty())
      for (const ImmersedStructure<dim> &structure : structures)
        collect(issues, [&] { check_coupling(structure); });
  }


  template <int dim>
  void
  Components<dim>::check_coupling(const ImmersedStructure<dim> &structure) const
  {
    try
      {
        structure.set_geometry(*space, structure.model->positions);
      }
    catch (const RunFailure &failure)
      {
        throw Error("/coupling",
                    "refuses the structure \"" + structure.model->name() + "\": " + failure.what());
      }
  }


  template <int dim>
  void
  Components<dim>::check_density(const StructureModel<dim> &model, const Parameters &block) const
  {
    const LagrangianMesh<dim> &mesh   = model.mesh();
    const std::vector<double> &masses = model.excess_mass();
    if (!fluid || masses.empty())
      return;
    const std::vector<double> measures = mesh.node_measures();
    for (unsigned int i = 0; i < masses.size(); ++i)
      if (masses[i] <= -fluid->density() * measures[i])
        block.fail("excess_density",
                   "is " + readable(masses[i] / measures[i]) + " at node " +
                     std::to_string(mesh.node_number(i)) + "; it must be greater than " +
                     readable(-fluid->density()) + ", that the structure has a mass");
  }


  template <int dim>
  bool
  Components<dim>::torn(const StructureModel<dim> &model) const
  {
    for (const auto &element : model.mesh().elements())
      for (unsigned int k = 1; k <= model.mesh().structure_dim(); ++k)
        for (unsigned int a = 0; a < dim; ++a)
          if (std::abs(model.positions[element.nodes[k]][a] -
                       model.positions[element.nodes[0]][a]) >
              space->domain().upper[a] - space->domain().lower[a])
            return true;
    return false;
  }


  template struct Components<2>;
  template struct Components<3>;
} // namespace feib
