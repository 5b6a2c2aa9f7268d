// SPDX-License-Identifier: LGPL-2.1-or-later
#include "error_norms.h"
#include "json.h"
#include "step_control.h"
#include "structure_summary.h"

#include <feib/expression.h>
#include <feib/ledger.h>
#include <feib/log.h>
#include <feib/output_writer.h>
#include <feib/refinement_strategy.h>
#include <feib/simulation.h>
#include <feib/time_integrator.h>
#include <feib/version.h>

#include <deal.II/base/mpi.h>

#include <sys/resource.h>

#include <chrono>
#include <fstream>
#include <iomanip>
#include <limits>
#include <optional>
#include <set>
#include <sstream>

namespace feib
{
  namespace
  {
    using Clock = std::chrono::steady_clock;

    double
    seconds_since(const Clock::time_point start)
    {
      return std::chrono::duration<double>(Clock::now() - start).count();
    }

    /// The phases a step's time is divided into, as the ledger lists them.
    const char *const phases[] =
      {"fluid", "structure", "coupling", "refinement", "output", "accounting"};

    const char *const axes[] = {"x", "y", "z"};


    template <int dim>
    class SimulationInDimension : public Simulation
    {
    public:
      explicit SimulationInDimension(const Parameters &parameters);

      void run(const Options &options) override;

    private:
      /// Sums over time.
      struct Totals
      {
        double dissipated = 0, convected = 0, numerical = 0, boundary_work = 0, body_work = 0;
        double energy            = 0; // now, on the mesh the next step is taken on
        double remeshing         = 0; // kinetic energy gained by moving u to another mesh
        double linear_iterations = 0, nonlinear_iterations = 0, geometry_iterations = 0;
        double largest_increase          = -std::numeric_limits<double>::infinity();
        double largest_relative_increase = -std::numeric_limits<double>::infinity();
        double largest_closure           = 0;
        unsigned int remeshes            = 0; // changes of the mesh, and what they took
        double remesh_seconds            = 0;
        double smallest_dt               = std::numeric_limits<double>::infinity();
        double largest_dt                = 0;
        std::vector<double> leak, time_error; // per structure, of its measure
      };

      template <class Build>
      void collect(Issues &issues, const Build &build);

      void build_structures(const Parameters &parameters, Issues &issues);

      bool adapt();

      void refine();

      typename TimeIntegrator<dim>::System
      system()
      {
        return {*space, *fluid, structures, timers};
      }

      void initialize();

      StepControl::State control_state();

      /// One step of the control's choice, shortened until it succeeds.
      void advance();

      void take_step(double dt, double new_time);

      void check_state() const;

      /// Throws RunFailure when the energy grows though no work is done.
      void check_energy();

      std::string stability_sentence(double dt);

      void add_ledger_row(double dt, const typename TimeIntegrator<dim>::Report &report);

      void write_outputs(const std::string &directory, bool always);

      Json summary(const std::string &status, const std::string &message) const;

      void write_summary(const std::string &directory,
                         const std::string &status,
                         const std::string &message) const;

      const Parameters parameters;
      std::unique_ptr<EulerianSpace<dim>> space;
      std::unique_ptr<FluidSolver<dim>> fluid;
      std::vector<ImmersedStructure<dim>> structures;
      std::vector<Positions<dim>> initial_positions; // of each structure
      std::unique_ptr<TimeIntegrator<dim>> integrator;
      std::unique_ptr<RefinementStrategy<dim>> refinement;
      std::vector<std::unique_ptr<OutputWriter<dim>>> writers;
      std::unique_ptr<dealii::Function<dim>> exact_velocity, exact_pressure;
      std::unique_ptr<StepControl> control;
      std::string integrator_name;
      double end_time = 0, energy_growth = 0;
      double stability_limit = std::numeric_limits<double>::infinity(); // before the first step
      double energy_unit     = 0; // below which energy is round-off

      Timers timers;
      Ledger ledger;
      Totals totals;
      double displacement_error = -1;
      unsigned int retries      = 0;
      unsigned int step         = 0;
      double time               = 0;
      std::vector<double> step_seconds;
      std::map<std::string, double> seconds_at_last_row;
      std::vector<int> last_written; // per writer, the step
      Clock::time_point start;
    };


    template <int dim>
    template <class Build>
    void
    SimulationInDimension<dim>::collect(Issues &issues, const Build &build)
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


    template <int dim>
    SimulationInDimension<dim>::SimulationInDimension(const Parameters &case_parameters)
      : parameters(case_parameters)
    {
      Issues issues;
      collect(issues, [&] {
        space = std::make_unique<EulerianSpace<dim>>(Domain<dim>(parameters.child("domain")));
      });
      collect(issues,
              [&] { fluid = parameters.child("fluid").template create<FluidSolver<dim>>(); });
      build_structures(parameters, issues);

      const Parameters time_parameters = parameters.child("time");
      end_time                         = time_parameters.number("end");
      energy_growth                    = time_parameters.number("energy_growth");
      integrator_name                  = time_parameters.child("integrator").choice().first;
      collect(issues, [&] {
        if (!space)
          return;
        const auto size = space->domain().upper - space->domain().lower;
        double shortest = size[0];
        for (unsigned int a = 1; a < dim; ++a)
          shortest = std::min(shortest, size[a]);
        control = std::make_unique<StepControl>(time_parameters, shortest);
      });
      collect(issues, [&] {
        integrator = time_parameters.child("integrator").template create<TimeIntegrator<dim>>();
      });
      collect(issues, [&] {
        refinement = parameters.child("refinement").template create<RefinementStrategy<dim>>();
      });
      std::set<std::string> output_names;
      for (const Parameters &output : parameters.children("output"))
        collect(issues, [&] {
          writers.push_back(output.template create<OutputWriter<dim>>());
          const auto [component, block] = output.choice();
          if (block.has("name") &&
              !output_names.insert(component + " " + block.string("name")).second)
            block.fail("name",
                       "found \"" + block.string("name") + "\" a second time; every " + component +
                         " needs a name of its own");
        });

      if (parameters.has("exact"))
        {
          const Parameters exact = parameters.child("exact");
          collect(issues, [&] {
            if (exact.has("velocity"))
              exact_velocity =
                parse_expressions<dim>(exact, "velocity", dim, Variables::space_time);
            else
              exact_velocity = std::make_unique<dealii::Functions::ZeroFunction<dim>>(dim);
          });
          collect(issues, [&] {
            if (exact.has("pressure"))
              exact_pressure = parse_expressions<dim>(exact, "pressure", 1, Variables::space_time);
          });
        }
      if (!issues.empty())
        throw Error(issues);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::build_structures(const Parameters &case_parameters, Issues &issues)
    {
      std::set<std::string> names;
      for (const Parameters &slot : case_parameters.children("structures"))
        collect(issues, [&] {
          ImmersedStructure<dim> structure;
          structure.model = slot.template create<StructureModel<dim>>();
          structure.motion =
            case_parameters.child("coupling").template create<CouplingOperator<dim>>();
          const unsigned int n_nodes          = structure.model->mesh().n_nodes();
          structure.nodes                     = LagrangianPoints::nodes(n_nodes);
          const LagrangianPoints &load_points = structure.model->load_points();
          if (!load_points.are_nodes(n_nodes))
            structure.loading =
              case_parameters.child("coupling").template create<CouplingOperator<dim>>();

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
          initial_positions.push_back(structure.model->positions);
          structures.push_back(std::move(structure));
        });
    }


    template <int dim>
    bool
    SimulationInDimension<dim>::adapt()
    {
      const Timers::Section section(timers, "refinement");
      return refinement->adapt(*space, structures);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::refine()
    {
      if (refinement->interval() == 0 || step % refinement->interval() != 0)
        return;
      const double before                  = fluid->balance(*space).kinetic_energy;
      const Clock::time_point remesh_start = Clock::now();
      if (!adapt())
        return;
      {
        const Timers::Section section(timers, "refinement");
        fluid->project(*space);
      }
      ++totals.remeshes;
      totals.remesh_seconds += seconds_since(remesh_start);
      // Moving the velocity to another mesh is no work of the scheme.
      const double gained = fluid->balance(*space).kinetic_energy - before;
      totals.energy += gained;
      totals.remeshing += gained;
      log::debug("step " + std::to_string(step) + ": " +
                 std::to_string(space->triangulation().n_global_active_cells()) + " cells");
    }


    template <int dim>
    void
    SimulationInDimension<dim>::check_state() const
    {
      // Everything here is the same on all ranks.
      for (const ImmersedStructure<dim> &structure : structures)
        for (unsigned int i = 0; i < structure.model->positions.size(); ++i)
          if (!space->forest().inside(structure.model->positions[i]))
            {
              std::ostringstream message;
              message << "the structure \"" << structure.model->name() << "\" leaves the box: node "
                      << i << " moves to (" << structure.model->positions[i] << ")";
              throw RunFailure(message.str());
            }
      // A periodic box has no outside: there an unstable run shows in elements longer than the box.
      for (const ImmersedStructure<dim> &structure : structures)
        for (const auto &element : structure.model->mesh().elements())
          for (unsigned int k = 1; k <= structure.model->mesh().structure_dim(); ++k)
            for (unsigned int a = 0; a < dim; ++a)
              if (std::abs(structure.model->positions[element.nodes[k]][a] -
                           structure.model->positions[element.nodes[0]][a]) >
                  space->domain().upper[a] - space->domain().lower[a])
                throw RunFailure("the structure \"" + structure.model->name() +
                                 "\" is torn: one of its elements is longer than the box");
      if (!std::isfinite(space->velocity.l2_norm()))
        throw RunFailure("the velocity is not finite");
    }


    template <int dim>
    void
    SimulationInDimension<dim>::initialize()
    {
      adapt();
      fluid->initialize(*space);
      space->old_velocity   = space->velocity;
      space->older_velocity = space->velocity;
      for (ImmersedStructure<dim> &structure : structures)
        {
          structure.motion->set_geometry(*space,
                                         structure.model->mesh(),
                                         structure.model->positions,
                                         structure.nodes);
          structure.motion->interpolate(*space, space->velocity, structure.model->velocities);
        }
      for (const ImmersedStructure<dim> &structure : structures)
        energy_unit += 1e-6 * structure.model->stiffness(structure.model->positions) *
                       structure.model->measure(structure.model->positions);
      totals.leak.assign(structures.size(), 0.);
      totals.time_error.assign(structures.size(), 0.);

      std::ostringstream message;
      message << space->triangulation().n_global_active_cells() << " cells, "
              << space->velocity_handler().n_dofs() << " velocity and "
              << space->pressure_handler().n_dofs() << " pressure unknowns";
      for (const ImmersedStructure<dim> &structure : structures)
        message << "; structure \"" << structure.model->name()
                << "\": " << structure.model->mesh().n_nodes() << " nodes, "
                << structure.model->mesh().n_elements() << " elements";
      log::info(message.str());
      add_ledger_row(0., {});

      const double dt = control->start(control_state());
      stability_limit = integrator->stability_limit(system()).dt;
      if (dt > stability_limit)
        log::warning(stability_sentence(dt));
    }


    template <int dim>
    StepControl::State
    SimulationInDimension<dim>::control_state()
    {
      const double dt = ledger.last("dt");
      return {dt > 0 ? ledger.last("cfl") / dt : fluid->balance(*space).cfl_rate,
              control->adaptive() ? integrator->stability_limit(system()).dt
                                  : std::numeric_limits<double>::infinity(),
              displacement_error};
    }


    template <int dim>
    std::string
    SimulationInDimension<dim>::stability_sentence(const double dt)
    {
      const auto limit = integrator->stability_limit(system());
      std::ostringstream text;
      text << std::setprecision(2) << "dt = " << dt;
      if (dt > limit.dt)
        {
          // Rounded down.
          const double digit = std::pow(10., std::floor(std::log10(limit.dt)) - 1);
          text << " exceeds the estimated limit " << limit.dt << " of " << integrator_name
               << " for structure \"" << limit.structure << "\"; use " << limit.alternative
               << " or dt <= " << std::floor(limit.dt / digit) * digit;
        }
      else if (std::isfinite(limit.dt))
        text << " is below the estimated limit " << limit.dt << " of " << integrator_name
             << " for structure \"" << limit.structure << "\", yet the run is not stable; use "
             << limit.alternative << " or a smaller dt";
      else
        text << " is too large for " << integrator_name
             << ", which has no limit by itself; use implicit convection or a smaller dt";
      return text.str();
    }


    template <int dim>
    void
    SimulationInDimension<dim>::check_energy()
    {
      // What was lost to viscosity, convection and the scheme is energy from nowhere when it is
      // negative; but convection through an open boundary brings some.
      const bool enclosed = space->domain().enclosed();
      const double gained =
        -(totals.dissipated + totals.numerical + (enclosed ? totals.convected : 0.));
      const double scale =
        std::max(std::abs(ledger.value("total_energy", 0)) + std::abs(totals.boundary_work) +
                   std::abs(totals.body_work) + (enclosed ? 0. : std::abs(totals.convected)),
                 energy_unit);
      if (gained > energy_growth * scale)
        {
          std::ostringstream text;
          text << std::setprecision(2) << "the energy has grown by " << 100 * gained / scale
               << " % beyond the work done: " << stability_sentence(ledger.last("dt"));
          throw RunFailure(text.str());
        }
    }


    template <int dim>
    void
    SimulationInDimension<dim>::advance()
    {
      while (true)
        {
          const double dt = control->next_dt();
          std::string reason;
          try
            {
              take_step(dt, control->next_time());
              control->accept(control_state());
              return;
            }
          catch (const RunFailure &failure)
            {
              if (!control->halve())
                throw;
              reason = failure.what();
            }
          ++retries;
          std::ostringstream message;
          message << "the step from time " << time << " with dt = " << dt << " failed: " << reason
                  << "; trying dt = " << control->next_dt();
          log::warning(message.str());
        }
    }


    template <int dim>
    void
    SimulationInDimension<dim>::take_step(const double dt, const double new_time)
    {
      const unsigned int step_before = step;
      const double time_before       = time;
      const double error_before      = displacement_error;
      const Totals totals_before     = totals;
      std::vector<Positions<dim>> positions;
      std::vector<NodalField<dim>> velocities;
      for (const ImmersedStructure<dim> &structure : structures)
        {
          positions.push_back(structure.model->positions);
          velocities.push_back(structure.model->velocities);
        }
      const PressureVector pressure = space->pressure;
      const VelocityVector older    = space->older_velocity;
      space->older_velocity         = space->old_velocity;
      space->old_velocity           = space->velocity;

      try
        {
          auto all          = system();
          const auto report = integrator->step(all, time, dt);
          check_state();
          displacement_error = report.displacement_error;
          if (!control->accurate(displacement_error))
            {
              std::ostringstream message;
              message << "it adds an error of about " << std::setprecision(2) << displacement_error
                      << " to displacements";
              throw RunFailure(message.str());
            }
          ++step;
          time = new_time;
          for (unsigned int s = 0; s < structures.size(); ++s)
            {
              const StructureModel<dim> &model = *structures[s].model;
              if (model.mesh().structure_dim() < dim && !model.mesh().closed())
                continue;
              const double leak = report.exchanges[s].leak;
              totals.leak[s] += leak;
              totals.time_error[s] +=
                model.measure(model.positions) - model.measure(positions[s]) - leak;
            }
          add_ledger_row(dt, report);
          space->old_dt = dt;
          // Schemes may leave the boundary values at another time of the step.
          space->set_time(time);
        }
      catch (const RunFailure &)
        {
          // Back to the last good state.
          step                  = step_before;
          time                  = time_before;
          displacement_error    = error_before;
          totals                = totals_before;
          space->velocity       = space->old_velocity;
          space->old_velocity   = space->older_velocity;
          space->older_velocity = older;
          space->pressure       = pressure;
          for (unsigned int i = 0; i < structures.size(); ++i)
            {
              structures[i].model->positions  = positions[i];
              structures[i].model->velocities = velocities[i];
            }
          throw;
        }
    }


    template <int dim>
    void
    SimulationInDimension<dim>::add_ledger_row(const double dt,
                                               const typename TimeIntegrator<dim>::Report &report)
    {
      Ledger::Row row;
      {
        const Timers::Section section(timers, "accounting");
        const auto balance = fluid->balance(*space);
        double kinetic = balance.kinetic_energy, elastic = 0;
        dealii::Tensor<1, dim> momentum       = balance.momentum;
        dealii::Tensor<1, 3> angular_momentum = balance.angular_momentum;
        for (const ImmersedStructure<dim> &structure : structures)
          {
            const StructureModel<dim> &model = *structure.model;
            elastic += model.energy(model.positions);
            for (unsigned int i = 0; i < model.excess_mass().size(); ++i)
              {
                const dealii::Tensor<1, dim> p = model.excess_mass()[i] * model.velocities[i];
                const dealii::Point<dim> &X    = model.positions[i];
                kinetic += .5 * (p * model.velocities[i]);
                momentum += p;
                angular_momentum[2] += X[0] * p[1] - X[1] * p[0];
                if constexpr (dim == 3)
                  {
                    angular_momentum[0] += X[1] * p[2] - X[2] * p[1];
                    angular_momentum[1] += X[2] * p[0] - X[0] * p[2];
                  }
              }
          }
        totals.dissipated += report.dissipated;
        totals.convected += report.convected;
        totals.numerical += report.numerical;
        totals.boundary_work += report.boundary_work;
        totals.body_work += report.body_work;
        totals.linear_iterations += report.linear_iterations;
        totals.nonlinear_iterations += report.nonlinear_iterations;
        totals.geometry_iterations += report.geometry_iterations;
        const double total = kinetic + elastic;
        if (step > 0)
          {
            const double increase   = total - totals.energy;
            totals.largest_increase = std::max(totals.largest_increase, increase);
            if (totals.energy > 0)
              totals.largest_relative_increase =
                std::max(totals.largest_relative_increase, increase / totals.energy);
            totals.smallest_dt = std::min(totals.smallest_dt, dt);
            totals.largest_dt  = std::max(totals.largest_dt, dt);
          }
        totals.energy        = total;
        const double initial = step > 0 ? ledger.value("total_energy", 0) : total;
        const double closure = total - initial + totals.dissipated + totals.convected +
                               totals.numerical - totals.boundary_work - totals.body_work -
                               totals.remeshing;
        totals.largest_closure = std::max(totals.largest_closure, std::abs(closure));

        row = {{"step", double(step)},
               {"time", time},
               {"dt", dt},
               {"kinetic", kinetic},
               {"elastic", elastic},
               {"dissipated", totals.dissipated},
               {"convected", totals.convected},
               {"numerical", totals.numerical},
               {"boundary_work", totals.boundary_work},
               {"body_work", totals.body_work},
               {"remeshing", totals.remeshing},
               {"total_energy", total},
               {"closure", closure},
               {"largest_velocity", balance.largest_velocity},
               {"divergence", balance.divergence}};
        for (unsigned int a = 0; a < dim; ++a)
          row.emplace_back(std::string("momentum_") + axes[a], momentum[a]);
        for (unsigned int a = (dim == 2 ? 2 : 0); a < 3; ++a)
          row.emplace_back(std::string("angular_momentum_") + axes[a], angular_momentum[a]);
        row.emplace_back("cfl", balance.cfl_rate * dt);
        for (unsigned int s = 0; s < structures.size(); ++s)
          {
            const StructureModel<dim> &model = *structures[s].model;
            const auto exchange =
              step > 0 ? report.exchanges[s] : typename TimeIntegrator<dim>::Exchange();
            row.emplace_back("measure_" + model.name(), model.measure(model.positions));
            row.emplace_back("leak_" + model.name(), totals.leak[s]);
            row.emplace_back("time_error_" + model.name(), totals.time_error[s]);
            row.emplace_back("power_" + model.name(), exchange.power);
            for (unsigned int a = 0; a < dim; ++a)
              row.emplace_back(std::string("force_") + axes[a] + "_" + model.name(),
                               exchange.force[a]);
            for (unsigned int a = (dim == 2 ? 2 : 0); a < 3; ++a)
              row.emplace_back(std::string("torque_") + axes[a] + "_" + model.name(),
                               exchange.torque[a]);
          }
        for (auto &entry : integrator->diagnostics(system(), dt))
          row.push_back(std::move(entry));
        row.emplace_back("displacement_error",
                         std::isfinite(report.displacement_error)
                           ? std::max(0., report.displacement_error)
                           : 0.);
        row.emplace_back("cells", space->triangulation().n_global_active_cells());
        row.emplace_back("linear_iterations", report.linear_iterations);
        row.emplace_back("nonlinear_iterations", report.nonlinear_iterations);
        row.emplace_back("geometry_iterations", report.geometry_iterations);
      }
      for (const char *phase : phases)
        {
          const auto found    = timers.seconds().find(phase);
          const double so_far = found == timers.seconds().end() ? 0. : found->second;
          row.emplace_back(std::string("seconds_") + phase, so_far - seconds_at_last_row[phase]);
          seconds_at_last_row[phase] = so_far;
        }
      for (const auto &[name, value] : row)
        if (!std::isfinite(value))
          throw RunFailure("the ledger's " + name + " is not finite at time " +
                           std::to_string(time));
      ledger.add(row);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::write_outputs(const std::string &directory, const bool always)
    {
      const Timers::Section section(timers, "output");
      const typename OutputWriter<dim>::Snapshot snapshot{
        step, time, directory, *space, structures, ledger};
      for (unsigned int i = 0; i < writers.size(); ++i)
        if ((always || step % writers[i]->interval() == 0) && last_written[i] != int(step))
          {
            writers[i]->write(snapshot);
            last_written[i] = step;
          }
    }


    template <int dim>
    Json
    SimulationInDimension<dim>::summary(const std::string &status, const std::string &message) const
    {
      const MPI_Comm communicator = space->communicator();
      struct rusage usage;
      getrusage(RUSAGE_SELF, &usage);
      const double memory = dealii::Utilities::MPI::sum(usage.ru_maxrss / 1024., communicator);

      std::vector<double> sorted = step_seconds;
      std::sort(sorted.begin(), sorted.end());

      Json result;
      result["status"]           = status;
      result["message"]          = message;
      result["version"]          = version();
      result["ranks"]            = dealii::Utilities::MPI::n_mpi_processes(communicator);
      result["steps"]            = step;
      result["time"]             = time;
      result["wall_seconds"]     = seconds_since(start);
      result["seconds_per_step"] = {{"median", sorted.empty() ? 0. : sorted[sorted.size() / 2]},
                                    {"max", sorted.empty() ? 0. : sorted.back()}};
      result["timers"]           = timers.seconds();
      result["peak_memory_mb"]   = memory;
      Json structure_unknowns    = 0;
      {
        unsigned int n = 0;
        for (const ImmersedStructure<dim> &structure : structures)
          n += dim * structure.model->mesh().n_nodes();
        structure_unknowns = n;
      }
      result["unknowns"] = {{"velocity", space->velocity_handler().n_dofs()},
                            {"pressure", space->pressure_handler().n_dofs()},
                            {"structures", structure_unknowns}};
      result["cells"]    = space->triangulation().n_global_active_cells();
      const double steps = std::max(1u, step);
      // From a cold start, and with solutions to extrapolate.
      const auto iterations_of = [&](const unsigned int row) {
        return row > 0 && row < ledger.n_rows() ? ledger.value("linear_iterations", row) : 0.;
      };
      result["iterations"] = {{"linear_first", iterations_of(1)},
                              {"linear_last", iterations_of(ledger.n_rows() - 1)},
                              {"linear_mean", totals.linear_iterations / steps},
                              {"nonlinear_mean", totals.nonlinear_iterations / steps},
                              {"geometry_mean", totals.geometry_iterations / steps}};
      result["retries"]    = retries;
      result["remeshes"]   = {{"count", totals.remeshes}, {"seconds", totals.remesh_seconds}};
      if (std::isfinite(stability_limit))
        result["stability_limit"] = stability_limit;
      if (step > 0)
        result["dt"] = {{"smallest", totals.smallest_dt}, {"largest", totals.largest_dt}};
      if (ledger.n_rows() > 0)
        result["energy"] = {{"kinetic", ledger.last("kinetic")},
                            {"elastic", ledger.last("elastic")},
                            {"dissipated", ledger.last("dissipated")},
                            {"numerical", ledger.last("numerical")},
                            {"largest_closure", totals.largest_closure},
                            {"total_initial", ledger.value("total_energy", 0)},
                            {"total_final", ledger.last("total_energy")},
                            {"largest_increase", step > 0 ? totals.largest_increase : 0.},
                            {"largest_relative_increase",
                             std::isfinite(totals.largest_relative_increase)
                               ? totals.largest_relative_increase
                               : 0.}};
      result["structures"] = Json::array();
      for (unsigned int s = 0; s < structures.size(); ++s)
        result["structures"].push_back(structure_summary(
          *structures[s].model, initial_positions[s], totals.leak[s], totals.time_error[s]));
      if (exact_velocity)
        {
          const ErrorNorms norms = error_norms(*space, time, *exact_velocity, exact_pressure.get());
          result["errors"]       = {{"velocity_l2", norms.velocity_l2},
                                    {"velocity_h1", norms.velocity_h1}};
          if (exact_pressure)
            result["errors"]["pressure_l2"] = norms.pressure_l2;
        }
      return result;
    }


    template <int dim>
    void
    SimulationInDimension<dim>::write_summary(const std::string &directory,
                                              const std::string &status,
                                              const std::string &message) const
    {
      const Json document    = summary(status, message);
      const std::string file = directory + "/summary.json";
      int failed             = 0;
      if (dealii::Utilities::MPI::this_mpi_process(space->communicator()) == 0)
        {
          std::ofstream stream(file);
          stream << document.dump(2) << '\n';
          stream.close();
          failed = !stream;
        }
      if (dealii::Utilities::MPI::max(failed, space->communicator()) != 0)
        throw RunFailure("cannot write \"" + file + "\"");
    }


    template <int dim>
    void
    SimulationInDimension<dim>::run(const Options &options)
    {
      start = Clock::now();
      last_written.assign(writers.size(), -1);
      const bool speaks = dealii::Utilities::MPI::this_mpi_process(space->communicator()) == 0;
      try
        {
          initialize();
          write_outputs(options.directory, true);
          while (!control->finished())
            {
              const Clock::time_point step_start = Clock::now();
              advance();
              check_energy();
              if (!control->finished())
                refine();
              step_seconds.push_back(seconds_since(step_start));
              write_outputs(options.directory, control->finished());
              if (speaks && options.on_progress)
                options.on_progress(
                  {step, time, end_time, ledger.last("dt"), seconds_since(start)});
              if (!control->finished() && options.stop_requested && options.stop_requested())
                throw RunFailure("stopped by a signal");
            }
        }
      catch (const RunFailure &failure)
        {
          std::ostringstream text;
          text << failure.what() << "; the last good state is step " << step << ", time " << time;
          const std::string message = text.str();
          try
            {
              if (ledger.n_rows() > 0)
                write_outputs(options.directory, true);
              write_summary(options.directory, "failed", message);
            }
          catch (const RunFailure &second)
            {
              throw RunFailure(message + "; and " + second.what());
            }
          throw RunFailure(message);
        }
      write_summary(options.directory, "completed", "");
    }
  } // namespace


  std::unique_ptr<Simulation>
  Simulation::create(const Case &description)
  {
    const Parameters &parameters = description.parameters();
    if (parameters.integer("dimension") == 2)
      return std::make_unique<SimulationInDimension<2>>(parameters);
    return std::make_unique<SimulationInDimension<3>>(parameters);
  }
} // namespace feib
