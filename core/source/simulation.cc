// SPDX-License-Identifier: LGPL-2.1-or-later
#include "json.h"

#include <feib/expression.h>
#include <feib/ledger.h>
#include <feib/log.h>
#include <feib/output_writer.h>
#include <feib/refinement_strategy.h>
#include <feib/simulation.h>
#include <feib/time_integrator.h>
#include <feib/version.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_values.h>

#include <sys/resource.h>

#include <chrono>
#include <fstream>
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
        double dissipated = 0, boundary_work = 0, body_work = 0;
        double linear_iterations = 0, nonlinear_iterations = 0;
        double largest_increase = 0;
      };

      template <class Build>
      void collect(Issues &issues, const Build &build);

      void build_structures(const Parameters &parameters, Issues &issues);

      bool adapt();

      void take_step(double dt);

      void check_state() const;

      void add_ledger_row(double dt, const typename TimeIntegrator<dim>::Report &report);

      void write_outputs(const std::string &directory, bool always);

      Json summary(const std::string &status, const std::string &message) const;

      Json errors() const;

      void write_summary(const std::string &directory,
                         const std::string &status,
                         const std::string &message) const;

      const Parameters parameters;
      std::unique_ptr<EulerianSpace<dim>> space;
      std::unique_ptr<FluidSolver<dim>> fluid;
      std::vector<ImmersedStructure<dim>> structures;
      std::unique_ptr<TimeIntegrator<dim>> integrator;
      std::unique_ptr<RefinementStrategy<dim>> refinement;
      std::vector<std::unique_ptr<OutputWriter<dim>>> writers;
      std::unique_ptr<dealii::Function<dim>> exact_velocity, exact_pressure;
      double time_step = 0, end_time = 0;
      unsigned int n_steps = 0;

      Timers timers;
      Ledger ledger;
      Totals totals;
      double energy_before_step = 0; // on the mesh the step is taken on
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
      time_step                        = time_parameters.number("step");
      end_time                         = time_parameters.number("end");
      collect(issues, [&] {
        // A rest that is a step but for round-off is a whole step.
        const double steps = std::ceil(end_time / time_step - 1e-6);
        if (!(steps <= 1e9))
          time_parameters.fail("step",
                               "the end is " + std::to_string(end_time / time_step) +
                                 " steps away, at most 1e9 are allowed");
        n_steps = std::max(1., steps);
      });
      collect(issues, [&] {
        integrator = time_parameters.child("integrator").template create<TimeIntegrator<dim>>();
      });
      collect(issues, [&] {
        refinement = parameters.child("refinement").template create<RefinementStrategy<dim>>();
      });
      for (const Parameters &output : parameters.children("output"))
        collect(issues, [&] { writers.push_back(output.template create<OutputWriter<dim>>()); });

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
          if (load_points.nodes_per_point != 1 || load_points.size() != n_nodes)
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
          structures.push_back(std::move(structure));
        });
    }


    template <int dim>
    bool
    SimulationInDimension<dim>::adapt()
    {
      const Timers::Section section(timers, "refinement");
      return space->adapt([&](auto &mesh) { refinement->mark(mesh, *space, structures); }, true);
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
    SimulationInDimension<dim>::take_step(const double dt)
    {
      const unsigned int step_before = step;
      const double time_before       = time;
      const Totals totals_before     = totals;
      std::vector<Positions<dim>> positions;
      for (const ImmersedStructure<dim> &structure : structures)
        positions.push_back(structure.model->positions);
      const PressureVector pressure = space->pressure;
      const VelocityVector older    = space->older_velocity;
      space->older_velocity         = space->old_velocity;
      space->old_velocity           = space->velocity;

      try
        {
          typename TimeIntegrator<dim>::System system{*space, *fluid, structures, timers};
          const auto report = integrator->step(system, time, dt);
          check_state();
          ++step;
          time = step == n_steps ? end_time : step * time_step;
          add_ledger_row(dt, report);
          space->old_dt = dt;
        }
      catch (const RunFailure &)
        {
          // Back to the last good state.
          step                  = step_before;
          time                  = time_before;
          totals                = totals_before;
          space->velocity       = space->old_velocity;
          space->old_velocity   = space->older_velocity;
          space->older_velocity = older;
          space->pressure       = pressure;
          for (unsigned int i = 0; i < structures.size(); ++i)
            structures[i].model->positions = positions[i];
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
        double elastic     = 0;
        for (const ImmersedStructure<dim> &structure : structures)
          elastic += structure.model->energy(structure.model->positions);
        if (step > 0)
          {
            totals.dissipated += dt * balance.dissipation;
            totals.boundary_work += dt * balance.boundary_power;
            totals.body_work += dt * balance.body_force_power;
            totals.linear_iterations += report.linear_iterations;
            totals.nonlinear_iterations += report.nonlinear_iterations;
          }
        const double total = balance.kinetic_energy + elastic;
        if (step > 0)
          totals.largest_increase = std::max(totals.largest_increase, total - energy_before_step);
        energy_before_step = total;

        row = {{"step", double(step)},
               {"time", time},
               {"dt", step > 0 ? dt : 0.},
               {"kinetic", balance.kinetic_energy},
               {"elastic", elastic},
               {"dissipated", totals.dissipated},
               {"boundary_work", totals.boundary_work},
               {"body_work", totals.body_work},
               {"total_energy", total},
               {"largest_velocity", balance.largest_velocity},
               {"divergence", balance.divergence}};
        for (const ImmersedStructure<dim> &structure : structures)
          row.emplace_back("measure_" + structure.model->name(),
                           structure.model->measure(structure.model->positions));
        for (unsigned int a = 0; a < dim; ++a)
          row.emplace_back(std::string("momentum_") + axes[a], balance.momentum[a]);
        for (unsigned int a = (dim == 2 ? 2 : 0); a < 3; ++a)
          row.emplace_back(std::string("angular_momentum_") + axes[a], balance.angular_momentum[a]);
        row.emplace_back("cfl", balance.cfl_rate * dt);
        typename TimeIntegrator<dim>::System system{*space, *fluid, structures, timers};
        for (auto &entry : integrator->diagnostics(system, dt))
          row.push_back(std::move(entry));
        row.emplace_back("cells", space->triangulation().n_global_active_cells());
        row.emplace_back("linear_iterations", report.linear_iterations);
        row.emplace_back("nonlinear_iterations", report.nonlinear_iterations);
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
    SimulationInDimension<dim>::errors() const
    {
      // Kinks of exact pressures cut through cells: a fine composite rule.
      const dealii::QIterated<dim> quadrature(dealii::QGauss<1>(3), 4);
      dealii::FEValues<dim> velocity_values(space->mapping(),
                                            space->velocity_handler().get_fe(),
                                            quadrature,
                                            dealii::update_values | dealii::update_gradients |
                                              dealii::update_quadrature_points |
                                              dealii::update_JxW_values);
      dealii::FEValues<dim> pressure_values(space->mapping(),
                                            space->pressure_handler().get_fe(),
                                            quadrature,
                                            dealii::update_values);
      const dealii::FEValuesExtractors::Vector velocities(0);
      const unsigned int n_q = quadrature.size();
      std::vector<dealii::Tensor<1, dim>> u(n_q);
      std::vector<dealii::Tensor<2, dim>> gradients(n_q);
      std::vector<double> p(n_q);
      constexpr double epsilon = 1e-3; // of a cell, to differentiate to fourth order
      // |u|^2, |grad u|^2, int (p - p_h)^2, int (p - p_h), volume
      std::array<double, 5> sums{};

      exact_velocity->set_time(time);
      if (exact_pressure)
        exact_pressure->set_time(time);
      dealii::Vector<double> exact(dim), forward(dim), backward(dim);
      for (const auto &cell : space->velocity_handler().active_cell_iterators())
        if (cell->is_locally_owned())
          {
            velocity_values.reinit(cell);
            velocity_values[velocities].get_function_values(space->velocity, u);
            velocity_values[velocities].get_function_gradients(space->velocity, gradients);
            const typename dealii::DoFHandler<dim>::active_cell_iterator pressure_cell(
              &space->triangulation(), cell->level(), cell->index(), &space->pressure_handler());
            pressure_values.reinit(pressure_cell);
            pressure_values.get_function_values(space->pressure, p);
            const double h = epsilon * cell->extent_in_direction(0);
            for (unsigned int q = 0; q < n_q; ++q)
              {
                const double weight         = velocity_values.JxW(q);
                const dealii::Point<dim> &x = velocity_values.quadrature_point(q);
                exact_velocity->vector_value(x, exact);
                for (unsigned int a = 0; a < dim; ++a)
                  sums[0] += weight * std::pow(u[q][a] - exact[a], 2);
                for (unsigned int b = 0; b < dim; ++b)
                  {
                    dealii::Tensor<1, dim> shift;
                    shift[b] = h;
                    dealii::Tensor<1, dim> derivative;
                    for (const auto &[steps, factor] : {std::pair(1, 8.), std::pair(2, -1.)})
                      {
                        exact_velocity->vector_value(x + steps * shift, forward);
                        exact_velocity->vector_value(x - steps * shift, backward);
                        for (unsigned int a = 0; a < dim; ++a)
                          derivative[a] += factor * (forward[a] - backward[a]) / (12 * h);
                      }
                    for (unsigned int a = 0; a < dim; ++a)
                      sums[1] += weight * std::pow(gradients[q][a][b] - derivative[a], 2);
                  }
                if (exact_pressure)
                  {
                    const double error = p[q] - exact_pressure->value(x);
                    sums[2] += weight * error * error;
                    sums[3] += weight * error;
                  }
                sums[4] += weight;
              }
          }
      for (double &sum : sums)
        sum = dealii::Utilities::MPI::sum(sum, space->communicator());
      if (space->domain().enclosed())
        sums[2] = std::max(0., sums[2] - sums[3] * sums[3] / sums[4]);
      Json result = {{"velocity_l2", std::sqrt(sums[0])}, {"velocity_h1", std::sqrt(sums[1])}};
      if (exact_pressure)
        result["pressure_l2"] = std::sqrt(sums[2]);
      return result;
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
      result["unknowns"]   = {{"velocity", space->velocity_handler().n_dofs()},
                              {"pressure", space->pressure_handler().n_dofs()},
                              {"structures", structure_unknowns}};
      result["cells"]      = space->triangulation().n_global_active_cells();
      const double steps   = std::max(1u, step);
      result["iterations"] = {{"linear_mean", totals.linear_iterations / steps},
                              {"nonlinear_mean", totals.nonlinear_iterations / steps}};
      if (ledger.n_rows() > 0)
        result["energy"] = {{"kinetic", ledger.last("kinetic")},
                            {"elastic", ledger.last("elastic")},
                            {"dissipated", ledger.last("dissipated")},
                            {"total_initial", ledger.value("total_energy", 0)},
                            {"total_final", ledger.last("total_energy")},
                            {"largest_increase", totals.largest_increase}};
      result["structures"] = Json::array();
      for (const ImmersedStructure<dim> &structure : structures)
        {
          const StructureModel<dim> &model = *structure.model;
          const std::string column         = "measure_" + model.name();
          const double measure             = model.measure(model.positions);
          const double initial = ledger.n_rows() > 0 ? ledger.value(column, 0) : measure;
          const dealii::Point<dim> centroid = model.centroid(model.positions);
          dealii::Point<dim> low = model.positions[0], high = model.positions[0];
          for (const auto &X : model.positions)
            for (unsigned int a = 0; a < dim; ++a)
              {
                low[a]  = std::min(low[a], X[a]);
                high[a] = std::max(high[a], X[a]);
              }
          Json centre = Json::array(), extent = Json::array();
          for (unsigned int a = 0; a < dim; ++a)
            {
              centre.push_back(centroid[a]);
              extent.push_back(high[a] - low[a]);
            }
          result["structures"].push_back({{"name", model.name()},
                                          {"measure_initial", initial},
                                          {"measure_final", measure},
                                          {"relative_measure_change", measure / initial - 1},
                                          {"centroid", centre},
                                          {"extent", extent}});
        }
      if (exact_velocity)
        result["errors"] = errors();
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
          adapt();
          fluid->initialize(*space);
          space->old_velocity   = space->velocity;
          space->older_velocity = space->velocity;

          std::ostringstream message;
          message << space->triangulation().n_global_active_cells() << " cells, "
                  << space->velocity_handler().n_dofs() << " velocity and "
                  << space->pressure_handler().n_dofs() << " pressure unknowns";
          for (const ImmersedStructure<dim> &structure : structures)
            message << "; structure \"" << structure.model->name()
                    << "\": " << structure.model->mesh().n_nodes() << " nodes, "
                    << structure.model->mesh().n_elements() << " elements";
          log::info(message.str());

          add_ledger_row(time_step, {});
          write_outputs(options.directory, true);
          while (step < n_steps)
            {
              const Clock::time_point step_start = Clock::now();
              take_step(step + 1 == n_steps ? end_time - time : time_step);
              if (refinement->interval() > 0 && step % refinement->interval() == 0 &&
                  step < n_steps && adapt())
                {
                  // Moving the velocity to another mesh is no work of the scheme.
                  energy_before_step +=
                    fluid->balance(*space).kinetic_energy - ledger.last("kinetic");
                  log::debug("step " + std::to_string(step) + ": " +
                             std::to_string(space->triangulation().n_global_active_cells()) +
                             " cells");
                }
              step_seconds.push_back(seconds_since(step_start));
              write_outputs(options.directory, step == n_steps);
              if (speaks && options.on_progress)
                options.on_progress({step, time, end_time, time_step, seconds_since(start)});
              if (step < n_steps && options.stop_requested && options.stop_requested())
                throw RunFailure("stopped by a signal");
            }
        }
      catch (const RunFailure &failure)
        {
          const std::string message = std::string(failure.what()) +
                                      "; the last good state is step " + std::to_string(step) +
                                      ", time " + std::to_string(time);
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
