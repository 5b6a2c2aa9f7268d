// SPDX-License-Identifier: LGPL-2.1-or-later
#include "boundary_flux.h"
#include "checkpoint.h"
#include "energy_check.h"
#include "forecast.h"
#include "resolution.h"
#include "structure_checks.h"
#include "summary.h"
#include "verdict.h"

#include <feib/failure.h>
#include <feib/inertial_load.h>
#include <feib/log.h>
#include <feib/simulation.h>

#include <deal.II/base/mpi.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <iomanip>
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


    /// To two digits.
    double
    rounded_down(const double value)
    {
      const double digit = std::pow(10., std::floor(std::log10(value)) - 1);
      return std::floor(value / digit * (1 + 1e-12)) * digit;
    }


    /// A signal asked the run to end.
    struct Stopped : RunFailure
    {
      Stopped()
        : RunFailure("stopped by a signal")
      {}
    };


    template <int dim>
    class SimulationInDimension : public Simulation
    {
    public:
      explicit SimulationInDimension(const Case &description);

      std::string forecast() override;

      bool run(const Options &options) override;

    private:
      void initialize();

      /// Says what there is to compute.
      void tell_size() const;

      /// What the checks of the run compare with: the structures as the case gives them.
      void note_beginning();

      /// The state of the run after a step, but for what is below.
      void archive_step(Archive &archive);

      /// All that a run goes on from.
      void archive(Archive &archive);

      void write_checkpoint(const Options &options);

      void resume(const Options &options);

      /// Steps, until the end.
      void loop(const Options &options);

      /// Says once that a net flux was spread.
      void tell_spread_flux();

      /// Makes the velocities of the start fit each other.
      void start_together();

      /// The pressure of the initial state.
      void find_initial_pressure();

      void refine();

      bool adapt();

      StepControl::State control_state();

      /// One step of the control's choice, shortened until it succeeds.
      void advance();

      void take_step(double dt, double new_time);

      void check_state() const;

      /// Warns of a step to be taken that exceeds a limit.
      void check_limits(double dt);

      /// Warns of what is doubtful in the state reached.
      void check_result();

      /// What a failure with steps up to @p dt from the present state comes from.
      std::string cause(double dt);

      /// Warns of flows too rough for the mesh, which have lost what they were.
      void check_resolution();

      /// Warns of momentum that changes though nothing in a periodic box can change it.
      void check_momentum();

      std::string stability_sentence(double dt);

      void write_outputs(const std::string &directory, bool always);

      /// The end of a run that did not get to its end: the last good state, summary, log, as far
      /// as they can be written.
      void give_up(const Options &options, Verdict::End how, const std::string &why);

      void
      write_summary(const std::string &directory, Verdict::End how, const std::string &message);

      /// What one rank alone can write.
      void write_lone_summary(const std::string &directory, const std::string &message) const;

      Components<dim> parts;
      Accounts<dim> accounts;
      Verdict verdict;
      RunRecord record;
      double end_time = 0, energy_growth = 0, measure_tolerance = 0;
      double given_step = 0; // by the case
      bool flux_told    = false;
      bool has_state    = false; // to write; a run that could not be taken up leaves all as it was
      std::unique_ptr<EnergyCheck<dim>> energy_check; // from the initial state on
      std::vector<double> initial_measures;           // of each structure
      double calm_limit         = 0;                  // of the step, when energy last did not grow
      double displacement_error = -1;
      bool inaccurate           = false;       // whether the last step failed for accuracy alone
      unsigned int failures     = 0;           // steps that failed for another reason
      unsigned int growths      = 0;           // of these, because the energy grew
      std::map<std::string, int> last_written; // per writer, the step
      Checkpoints checkpoints;
      const std::string case_text, case_directory;
      MemoryArchive before_step; // to be undone with
      Clock::time_point start;
      double seconds_before = 0; // of the run, before it was taken up again
    };


    template <int dim>
    SimulationInDimension<dim>::SimulationInDimension(const Case &description)
      : parts(description.parameters())
      , accounts(parts)
      , checkpoints(description.parameters().child("checkpoint"))
      , case_text(description.resolved())
      , case_directory(description.parameters().directory())
    {
      const Parameters time = description.parameters().child("time");
      end_time              = time.number("end");
      energy_growth         = time.number("energy_growth");
      measure_tolerance     = time.number("measure_tolerance");
      given_step            = time.number("step");
    }


    template <int dim>
    void
    SimulationInDimension<dim>::archive_step(Archive &archive)
    {
      archive("space", *parts.space);
      archive("fluid", *parts.fluid);
      archive("integrator", *parts.integrator);
      for (ImmersedStructure<dim> &structure : parts.structures)
        {
          const std::string name = "structure_" + structure.model->name();
          archive(name, *structure.model);
          archive(name + "_motion", *structure.motion);
          if (structure.loading)
            archive(name + "_loading", *structure.loading);
        }
      archive("totals", accounts.totals);
      archive("energy_check", energy_check->totals);
      archive("step", record.step);
      archive("time", record.time);
      archive("displacement_error", displacement_error);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::archive(Archive &archive)
    {
      archive_step(archive);
      archive("accounts", accounts);
      archive("timers", parts.timers);
      archive("refinement", *parts.refinement);
      archive("control", *parts.control);
      archive("verdict", verdict);
      archive("record", record);
      archive("failures", failures);
      archive("calm_limit", calm_limit);
      archive("growths", growths);
      archive("flux_told", flux_told);
      archive("last_written", last_written);
      // A run may go on with other outputs.
      for (unsigned int i = 0; i < parts.writers.size(); ++i)
        if (const std::string name = "output_" + parts.writer_names[i];
            !archive.reading() || archive.has(name))
          archive(name, *parts.writers[i]);
    }


    template <int dim>
    bool
    SimulationInDimension<dim>::adapt()
    {
      const Timers::Section section(parts.timers, "refinement");
      return parts.refinement->adapt(*parts.space, parts.structures);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::refine()
    {
      if (record.step == 0 || parts.refinement->interval() == 0 ||
          record.step % parts.refinement->interval() != 0)
        return;
      const double before                  = parts.fluid->balance(*parts.space).kinetic_energy;
      const Clock::time_point remesh_start = Clock::now();
      if (!adapt())
        return;
      {
        const Timers::Section section(parts.timers, "refinement");
        InertialLoad<dim> inertia(*parts.space, parts.structures, 1.);
        const bool heavy = !inertia.empty();
        if (heavy)
          for (const ImmersedStructure<dim> &structure : parts.structures)
            structure.set_geometry(*parts.space, structure.model->positions);
        parts.fluid->project(*parts.space, heavy ? &inertia : nullptr);
      }
      ++record.remeshes;
      record.remesh_seconds += seconds_since(remesh_start);
      accounts.add_remeshing(parts.fluid->balance(*parts.space).kinetic_energy - before);
      log::debug("step " + std::to_string(record.step) + ": " +
                 std::to_string(parts.space->triangulation().n_global_active_cells()) + " cells");
    }


    template <int dim>
    void
    SimulationInDimension<dim>::check_state() const
    {
      // Everything here is the same on all ranks.
      for (const ImmersedStructure<dim> &structure : parts.structures)
        for (unsigned int i = 0; i < structure.model->positions.size(); ++i)
          if (!parts.space->forest().inside(structure.model->positions[i]))
            {
              std::ostringstream message;
              message << "the structure \"" << structure.model->name() << "\" leaves the box: node "
                      << structure.model->mesh().node_number(i) << " moves to ("
                      << structure.model->positions[i] << ")";
              throw RunFailure(message.str());
            }
      // A periodic box has no outside: there an unstable run shows in elements longer than the box.
      for (const ImmersedStructure<dim> &structure : parts.structures)
        if (parts.torn(*structure.model))
          throw RunFailure("the structure \"" + structure.model->name() +
                           "\" is torn: one of its elements is longer than the box");
      if (!std::isfinite(parts.space->velocity.l2_norm()))
        throw RunFailure("the velocity is not finite");
    }


    template <int dim>
    void
    SimulationInDimension<dim>::start_together()
    {
      EulerianSpace<dim> &space = *parts.space;
      for (const ImmersedStructure<dim> &structure : parts.structures)
        structure.set_geometry(space, structure.model->positions);
      // Excess mass has a velocity of its own, which becomes that of the fluid as in an inelastic
      // collision: schemes that damp nothing would have the difference alternate for ever.
      InertialLoad<dim> inertia(space, parts.structures, 1.);
      parts.fluid->initialize(space, inertia.empty() ? nullptr : &inertia);
      tell_spread_flux();
      space.old_velocity   = space.velocity;
      space.older_velocity = space.velocity;
      for (ImmersedStructure<dim> &structure : parts.structures)
        structure.motion->interpolate(space, space.velocity, structure.model->velocities);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::find_initial_pressure()
    {
      EulerianSpace<dim> &space = *parts.space;
      VelocityVector load       = space.make_velocity();
      NodalField<dim> force;
      for (const ImmersedStructure<dim> &structure : parts.structures)
        {
          structure.model->load(structure.model->positions, force);
          structure.spreading().spread(space, force, load);
        }
      InertialLoad<dim> inertia(space, parts.structures, 1.);
      parts.fluid->find_pressure(space,
                                 {0., given_step, load, inertia.empty() ? nullptr : &inertia});
    }


    template <int dim>
    void
    SimulationInDimension<dim>::initialize()
    {
      start_together();
      find_initial_pressure();
      note_beginning();
      tell_size();
      accounts.ledger.add(accounts.add(0, 0., 0., {}, {}));
      parts.control->start(control_state());
      record.stability_limit = parts.integrator->stability_limit(parts.system()).dt;
      calm_limit             = record.stability_limit;
      check_meshes(parts, 0., verdict);
      check_structures(parts, 0., verdict);
      check_overlap(parts, 0., verdict);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::note_beginning()
    {
      energy_check = std::make_unique<EnergyCheck<dim>>(parts, energy_growth);
      for (const ImmersedStructure<dim> &structure : parts.structures)
        initial_measures.push_back(structure.model->measure(structure.model->positions));
    }


    template <int dim>
    void
    SimulationInDimension<dim>::resume(const Options &options)
    {
      note_beginning();
      CheckpointReader<dim> reader(*parts.space, options.restart);
      archive(reader);
      seconds_before = record.wall_seconds;
      for (unsigned int i = 0; i < parts.writers.size(); ++i)
        parts.writers[i]->reopen(options.directory);
      tell_size();
      std::ostringstream message;
      message << "going on from step " << record.step << ", time " << record.time;
      log::info(message.str());
    }


    template <int dim>
    void
    SimulationInDimension<dim>::write_checkpoint(const Options &options)
    {
      const Timers::Section section(parts.timers, "output");
      record.wall_seconds         = seconds_before + seconds_since(start);
      const MPI_Comm communicator = parts.space->communicator();
      const Json manifest         = {
                {"case", Json::parse(case_text)},
                {"case_directory", std::filesystem::absolute(case_directory).lexically_normal().string()},
                {"versions", options.versions},
                {"step", record.step},
                {"time", record.time},
                {"ranks", dealii::Utilities::MPI::n_mpi_processes(communicator)}};
      checkpoints.write(
        options.directory, record.step, manifest, communicator, [&](const std::string &folder) {
          CheckpointWriter<dim> writer(*parts.space, folder);
          archive(writer);
          writer.finish();
        });
    }


    template <int dim>
    void
    SimulationInDimension<dim>::tell_size() const
    {
      std::ostringstream message;
      message << parts.space->triangulation().n_global_active_cells() << " cells, "
              << parts.space->velocity_handler().n_dofs() << " velocity and "
              << parts.space->pressure_handler().n_dofs() << " pressure unknowns";
      for (const ImmersedStructure<dim> &structure : parts.structures)
        message << "; structure \"" << structure.model->name()
                << "\": " << structure.model->mesh().n_nodes() << " nodes, "
                << structure.model->mesh().n_elements() << " elements";
      log::info(message.str());
    }


    template <int dim>
    StepControl::State
    SimulationInDimension<dim>::control_state()
    {
      const double dt = accounts.ledger.last("dt");
      return {dt > 0 ? accounts.ledger.last("cfl") / dt
                     : parts.fluid->balance(*parts.space).cfl_rate,
              parts.control->adaptive() ? parts.integrator->stability_limit(parts.system()).dt
                                        : std::numeric_limits<double>::infinity(),
              displacement_error};
    }


    template <int dim>
    std::string
    SimulationInDimension<dim>::stability_sentence(const double dt)
    {
      auto limit = parts.integrator->stability_limit(parts.system());
      // A state that has begun to go wrong has limits of its own.
      if (dt > calm_limit)
        limit.dt = std::max(limit.dt, calm_limit);
      std::ostringstream text;
      text << std::setprecision(2) << "dt = " << dt;
      if (dt > limit.dt)
        {
          text << " exceeds the estimated limit " << limit.dt << " of " << parts.integrator_name
               << " for structure \"" << limit.structure << "\"; use " << limit.alternative
               << " or dt <= " << rounded_down(limit.dt);
        }
      else if (std::isfinite(limit.dt))
        text << " is below the estimated limit " << limit.dt << " of " << parts.integrator_name
             << " for structure \"" << limit.structure << "\", yet the run is not stable; use "
             << limit.alternative << " or a smaller dt";
      else
        text << " is too large for " << parts.integrator_name
             << ", which has no limit by itself; use a smaller dt";
      return text.str();
    }


    template <int dim>
    void
    SimulationInDimension<dim>::check_limits(const double dt)
    {
      const double limit = accounts.smallest_limit();
      if (dt > limit * (1 + 1e-12))
        verdict.warn("step_limit", record.time, dt / limit, stability_sentence(dt));
    }


    template <int dim>
    void
    SimulationInDimension<dim>::check_result()
    {
      // Explicit schemes gain a little by theory.
      constexpr double tolerated_gain = .1;
      if (const auto [part, name] = energy_check->unexplained(); part > .01)
        verdict.warn("unexplained_energy",
                     record.time,
                     part,
                     "nothing explains some of the energy of the structure \"" + name +
                       "\": the stress of its law is not the derivative of its energy");
      if (const auto [part, name] = energy_check->gained(); part > tolerated_gain)
        {
          std::ostringstream text;
          text << std::setprecision(2) << "the structure \"" << name << "\" has gained "
               << 100 * part << " % of the work of its load from the time scheme: "
               << stability_sentence(accounts.ledger.last("dt"));
          verdict.warn("structure_growth", record.time, part, text.str());
        }
      const auto &totals = accounts.totals;
      for (unsigned int s = 0; s < parts.structures.size(); ++s)
        {
          const double error =
            std::abs(totals.leak[s] + totals.time_error[s]) / initial_measures[s];
          if (error > measure_tolerance)
            {
              std::ostringstream text;
              text << std::setprecision(2) << "the structure \""
                   << parts.structures[s].model->name() << "\" has changed its measure by "
                   << 100 * error << " %, " << 100 * totals.leak[s] / initial_measures[s]
                   << " % by flux through it and "
                   << 100 * totals.time_error[s] / initial_measures[s] << " % by the time scheme";
              verdict.warn("measure", record.time, error, text.str());
            }
        }
      check_structures(parts, record.time, verdict);
      check_resolution();
    }


    template <int dim>
    void
    SimulationInDimension<dim>::check_resolution()
    {
      const double cell_reynolds = parts.fluid->density() *
                                   accounts.ledger.last("largest_velocity") *
                                   parts.space->smallest_edge() / parts.fluid->viscosity();
      // Where viscosity rules, what is rough decays, and what structures push is rough beside them.
      constexpr double inertial = 30, rough = .26;
      if (cell_reynolds < inertial)
        return;
      const double part = roughness(*parts.space);
      if (part < rough)
        return;
      std::ostringstream text;
      text << std::setprecision(2) << 100 * part
           << " % of what the velocity varies within cells is rougher than they resolve, at a cell "
              "Reynolds number of "
           << cell_reynolds << ": the mesh is too coarse for the flow";
      verdict.warn("resolution", record.time, part, text.str());
    }


    template <int dim>
    std::string
    SimulationInDimension<dim>::cause(const double dt)
    {
      check_limits(dt);
      if (energy_check->grew || dt > accounts.smallest_limit())
        return ": " + stability_sentence(dt);
      return "";
    }


    template <int dim>
    void
    SimulationInDimension<dim>::check_momentum()
    {
      const Domain<dim> &box = parts.space->domain();
      double volume          = 1;
      for (unsigned int a = 0; a < dim; ++a)
        {
          if (!box.periodic(a))
            return;
          volume *= box.upper[a] - box.lower[a];
        }
      if (accounts.totals.body_work != 0)
        return;
      const Ledger &ledger = accounts.ledger;
      double square        = 0;
      for (const char *const name : {"momentum_x", "momentum_y", "momentum_z"})
        if (name[9] != 'z' || dim == 3)
          square += std::pow(ledger.last(name) - ledger.first(name), 2);
      // That of the energy there was, if all moved together.
      const double scale =
        std::sqrt(2 * parts.fluid->density() * volume * ledger.first("total_energy"));
      const double drift = std::sqrt(square);
      // Flows on meshes much too coarse for them lose their momentum while their energy falls as it
      // should.
      constexpr double tolerated = 1e-2;
      if (drift > tolerated * scale)
        {
          std::ostringstream text;
          text
            << std::setprecision(2) << "momentum has changed by " << 100 * drift / scale
            << " % of what the energy could carry, though nothing acts on this periodic box: the "
               "mesh is too coarse for the flow";
          verdict.warn("momentum", record.time, drift / scale, text.str());
        }
    }


    template <int dim>
    void
    SimulationInDimension<dim>::advance()
    {
      const double wanted = parts.control->next_dt();
      check_limits(wanted);
      while (true)
        {
          const double dt = parts.control->next_dt();
          std::string reason;
          try
            {
              take_step(dt, parts.control->next_time());
              parts.control->accept(control_state());
              if (energy_check->totals.growth == 0)
                calm_limit = accounts.smallest_limit();
              break;
            }
          catch (const Incurable &)
            {
              throw;
            }
          catch (const RunFailure &failure)
            {
              reason = failure.what();
              // Where the energy grows again and again, shorter steps now and then do not help.
              if (energy_check->grew)
                ++growths;
              if (growths > 8 || !parts.control->halve())
                throw Incurable(reason + cause(wanted));
            }
          ++record.retries;
          // That a step is shortened for accuracy is what adaptive control is for.
          if (!inaccurate)
            ++failures;
          std::ostringstream message;
          message << "the step from time " << record.time << " with dt = " << dt
                  << " failed: " << reason << "; trying dt = " << parts.control->next_dt();
          log::warning(message.str());
          if (!inaccurate && failures > 3)
            verdict.warn("retries",
                         record.time,
                         failures,
                         "more than three steps have failed and were tried again");
        }
      check_result();
    }


    template <int dim>
    void
    SimulationInDimension<dim>::take_step(const double dt, const double new_time)
    {
      std::vector<Positions<dim>> positions;
      for (const ImmersedStructure<dim> &structure : parts.structures)
        positions.push_back(structure.model->positions);
      before_step.start_writing();
      archive_step(before_step);
      parts.space->older_velocity = parts.space->old_velocity;
      parts.space->old_velocity   = parts.space->velocity;

      try
        {
          energy_check->grew = false;
          inaccurate         = false;
          agree(parts.space->communicator(), [&] {
            auto all          = parts.system();
            const auto report = parts.integrator->step(all, record.time, dt);
            check_state();
            displacement_error = report.displacement_error;
            if (!parts.control->accurate(displacement_error))
              {
                std::ostringstream message;
                message << "it adds an error of about " << std::setprecision(2)
                        << displacement_error << " to displacements";
                inaccurate = true;
                throw RunFailure(message.str());
              }
            ++record.step;
            record.time           = new_time;
            const double before   = accounts.totals.energy;
            const Ledger::Row row = accounts.add(record.step, record.time, dt, report, positions);
            energy_check->judge(before, accounts.totals.energy, report);
            accounts.ledger.add(row);
            parts.space->old_dt = dt;
            // Schemes may leave the boundary values at another time of the step.
            parts.space->set_time(record.time);
            parts.fluid->commit();
          });
        }
      catch (const RunFailure &)
        {
          before_step.start_reading();
          archive_step(before_step);
          throw;
        }
    }


    template <int dim>
    void
    SimulationInDimension<dim>::write_outputs(const std::string &directory, const bool always)
    {
      const Timers::Section section(parts.timers, "output");
      const typename OutputWriter<dim>::Snapshot snapshot{
        record.step, record.time, directory, *parts.space, parts.structures, accounts.ledger};
      for (unsigned int i = 0; i < parts.writers.size(); ++i)
        {
          const auto last = last_written.find(parts.writer_names[i]);
          if ((!always && record.step % parts.writers[i]->interval() != 0) ||
              (last != last_written.end() && last->second == int(record.step)))
            continue;
          parts.writers[i]->write(snapshot);
          last_written[parts.writer_names[i]] = record.step;
        }
    }


    template <int dim>
    void
    SimulationInDimension<dim>::write_summary(const std::string &directory,
                                              const Verdict::End how,
                                              const std::string &message)
    {
      record.wall_seconds = seconds_before + seconds_since(start);
      Json document       = {{"status", verdict.status(how)},
                             {"message", message},
                             {"warnings", verdict.to_json()}};
      document.update(summary(parts, accounts, record));
      const std::string file = directory + "/summary.json";
      int failed             = 0;
      if (dealii::Utilities::MPI::this_mpi_process(parts.space->communicator()) == 0)
        {
          std::ofstream stream(file);
          stream << document.dump(2) << '\n';
          stream.close();
          failed = !stream;
        }
      if (dealii::Utilities::MPI::max(failed, parts.space->communicator()) != 0)
        throw RunFailure("cannot write \"" + file + "\"");
    }


    template <int dim>
    void
    SimulationInDimension<dim>::write_lone_summary(const std::string &directory,
                                                   const std::string &message) const
    {
      const Json document = {{"status", verdict.status(Verdict::End::failed)},
                             {"message", message},
                             {"warnings", verdict.to_json()},
                             {"steps", record.step},
                             {"time", record.time}};
      std::ofstream(directory + "/summary.json") << document.dump(2) << '\n';
      std::ofstream(directory + "/log.txt", std::ios::app) << "error: " << message << '\n';
    }


    template <int dim>
    void
    SimulationInDimension<dim>::loop(const Options &options)
    {
      const StepControl &control = *parts.control;
      const bool speaks =
        dealii::Utilities::MPI::this_mpi_process(parts.space->communicator()) == 0;
      while (!control.finished())
        {
          const Clock::time_point step_start = Clock::now();
          agree(parts.space->communicator(), [&] {
            refine();
            advance();
            check_momentum();
            tell_spread_flux();
            record.step_seconds.add(seconds_since(step_start));
            write_outputs(options.directory, false);
          });
          const Request request = options.requested ? options.requested() : Request::none;
          if (request != Request::none || control.finished() ||
              checkpoints.due(record.step, parts.space->communicator()))
            agree(parts.space->communicator(), [&] { write_checkpoint(options); });
          if (speaks && options.on_progress)
            options.on_progress({record.step,
                                 record.time,
                                 end_time,
                                 accounts.ledger.last("dt"),
                                 seconds_since(start)});
          if (!control.finished() && request == Request::stop)
            throw Stopped();
        }
      agree(parts.space->communicator(), [&] { write_outputs(options.directory, true); });
    }


    template <int dim>
    void
    SimulationInDimension<dim>::give_up(const Options &options,
                                        const Verdict::End how,
                                        const std::string &why)
    {
      const std::string &directory = options.directory;
      std::ostringstream text;
      text << why;
      if (has_state)
        text << "; the last good state is step " << record.step << ", time " << record.time;
      else
        text << "; the run did not reach its initial state";
      std::string message = text.str();
      const auto attempt  = [&](const std::function<void()> &action) {
        try
          {
            agree(parts.space->communicator(), action);
          }
        catch (const RunFailure &second)
          {
            if (why != second.what()) // what could not be written cannot be written now
              message += std::string("; and ") + second.what();
          }
      };
      if (has_state)
        {
          attempt([&] { write_checkpoint(options); });
          attempt([&] { write_outputs(directory, true); });
        }
      attempt([&] { write_summary(directory, how, message); });
      log::status("");
      log::error(message);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::tell_spread_flux()
    {
      if (flux_told || parts.space->spread_flux() == 0)
        return;
      flux_told = true;
      log::info(spread_flux_text(*parts.space));
    }


    template <int dim>
    std::string
    SimulationInDimension<dim>::forecast()
    {
      std::string text = size_text(*parts.space, parts.structures);
      if (parts.space->spread_flux() != 0)
        text += spread_flux_text(*parts.space) + "\n";
      const auto limit = parts.integrator->stability_limit(parts.system());
      if (given_step > limit.dt)
        text += stability_sentence(given_step) + "\n";
      else if (std::isfinite(limit.dt))
        {
          std::ostringstream line;
          line << std::setprecision(2) << "the estimated limit of " << parts.integrator_name
               << " for structure \"" << limit.structure << "\" is dt = " << limit.dt << '\n';
          text += line.str();
        }
      return text;
    }


    template <int dim>
    bool
    SimulationInDimension<dim>::run(const Options &options)
    {
      start            = Clock::now();
      Verdict::End end = Verdict::End::completed;
      try
        {
          agree(parts.space->communicator(), [&] {
            if (options.restart.empty())
              initialize();
            else
              resume(options);
            has_state = true;
            if (!options.restart.empty())
              return;
            write_outputs(options.directory, true);
          });
          if (options.restart.empty())
            agree(parts.space->communicator(), [&] { write_checkpoint(options); });
          loop(options);
          check_overlap(parts, record.time, verdict);
          write_summary(options.directory, end, "");
          log::status("");
        }
      catch (const Stopped &stop)
        {
          end = Verdict::End::stopped;
          give_up(options, end, stop.what());
        }
      catch (const RunFailure &failure)
        {
          end = Verdict::End::failed;
          give_up(options, end, failure.what());
        }
      catch (const LoneFailure &failure)
        {
          write_lone_summary(options.directory, failure.what());
          throw;
        }
      log::info(verdict.sentence(end) + ", results in " + options.directory);
      return end == Verdict::End::completed;
    }
  } // namespace


  std::unique_ptr<Simulation>
  Simulation::create(const Case &description)
  {
    if (description.parameters().integer("dimension") == 2)
      return std::make_unique<SimulationInDimension<2>>(description);
    return std::make_unique<SimulationInDimension<3>>(description);
  }
} // namespace feib
