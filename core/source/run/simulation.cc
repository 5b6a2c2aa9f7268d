// SPDX-License-Identifier: LGPL-2.1-or-later
#include "boundary_flux.h"
#include "checkpoint_archive.h"
#include "checkpoints.h"
#include "forecast.h"
#include "initial_state.h"
#include "judge.h"
#include "summary.h"

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
      SimulationInDimension(const Case &description, bool goes_on);

      std::string forecast() override;

      bool run(const Options &options) override;

    private:
      void initialize();

      /// Says what there is to compute.
      void tell_size() const;

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

      void refine();

      bool adapt();

      StepControl::State control_state();

      /// One step of the control's choice, shortened until it succeeds.
      void advance();

      void take_step(double dt, double new_time);

      void write_outputs(const std::string &directory, bool always);

      /// The end of a run that did not get to its end: the last good state, summary, log, as far
      /// as they can be written.
      void give_up(const Options &options, Ending &&ending);

      void end_with(const Options &options, const Ending &ending);

      Components<dim> parts;
      Accounts<dim> accounts;
      Judge<dim> judge;
      Statistics statistics;
      RunRecord record;
      double end_time = 0, given_step = 0; // by the case
      bool flux_told = false;
      bool has_state = false; // to write; a run that could not be taken up leaves all as it was
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
    SimulationInDimension<dim>::SimulationInDimension(const Case &description, const bool goes_on)
      : parts(description.parameters(), goes_on)
      , accounts(parts)
      , judge(parts, accounts, description.parameters().child("time"))
      , statistics(description.parameters())
      , checkpoints(description.parameters().child("checkpoint"))
      , case_text(description.resolved())
      , case_directory(description.parameters().directory())
    {
      const Parameters time = description.parameters().child("time");
      end_time              = time.number("end");
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
      judge.archive_step(archive);
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
      archive("statistics", statistics);
      archive("timers", parts.timers);
      archive("refinement", *parts.refinement);
      archive("control", *parts.control);
      judge.archive(archive);
      archive("record", record);
      archive("failures", failures);
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
      judge.check_parts(record.time);
      ++record.remeshes;
      record.remesh_seconds += seconds_since(remesh_start);
      accounts.add_remeshing(parts.fluid->balance(*parts.space).kinetic_energy - before);
      log::debug("step " + std::to_string(record.step) + ": " +
                 std::to_string(parts.space->triangulation().n_global_active_cells()) + " cells");
    }


    template <int dim>
    void
    SimulationInDimension<dim>::initialize()
    {
      start_together(parts);
      tell_spread_flux();
      find_initial_pressure(parts, given_step);
      judge.begin();
      tell_size();
      accounts.ledger.add(accounts.add(0, 0., 0., {}, {}));
      parts.control->start(control_state());
      record.stability_limit = judge.start();
    }


    template <int dim>
    void
    SimulationInDimension<dim>::resume(const Options &options)
    {
      judge.begin();
      CheckpointReader<dim> reader(*parts.space, options.restart);
      archive(reader);
      seconds_before = record.wall_seconds;
      for (unsigned int i = 0; i < parts.writers.size(); ++i)
        parts.writers[i]->reopen(options.directory, parts.space->communicator());
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
    void
    SimulationInDimension<dim>::advance()
    {
      const double wanted = parts.control->next_dt();
      judge.check_limits(record.time, wanted);
      while (true)
        {
          const double dt = parts.control->next_dt();
          std::string reason;
          try
            {
              take_step(dt, parts.control->next_time());
              parts.control->accept(control_state());
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
              if (judge.grew())
                ++growths;
              if (growths > 8 || !parts.control->halve())
                throw Incurable(reason + judge.cause(record.time, wanted));
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
            judge.verdict.warn("retries",
                               record.time,
                               failures,
                               "more than three steps have failed and were tried again");
        }
      judge.check_result(record.time);
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
          judge.forget_failure();
          inaccurate = false;
          agree(parts.space->communicator(), [&] {
            auto all          = parts.system();
            const auto report = parts.integrator->step(all, record.time, dt);
            judge.check_state();
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
            judge.judge_energies(before, accounts.totals.energy, report);
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
            statistics.add(accounts.ledger);
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
    SimulationInDimension<dim>::end_with(const Options &options, const Ending &ending)
    {
      record.wall_seconds = seconds_before + seconds_since(start);
      write_summary(options.directory, ending, judge.verdict, parts, accounts, statistics, record);
    }


    template <int dim>
    void
    SimulationInDimension<dim>::give_up(const Options &options, Ending &&ending)
    {
      const std::string why = ending.message;
      std::ostringstream text;
      if (has_state)
        text << "; the last good state is step " << record.step << ", time " << record.time;
      else
        text << "; the run did not reach its initial state";
      ending.message += text.str();
      const auto attempt = [&](const std::function<void()> &action) {
        try
          {
            agree(parts.space->communicator(), action);
          }
        catch (const RunFailure &second)
          {
            if (why != second.what()) // what could not be written cannot be written now
              ending.message += std::string("; and ") + second.what();
          }
      };
      if (has_state)
        {
          attempt([&] { write_checkpoint(options); });
          attempt([&] { write_outputs(options.directory, true); });
        }
      attempt([&] { end_with(options, ending); });
      log::status("");
      log::error(ending.message);
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
        text += judge.stability_sentence(given_step) + "\n";
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
          judge.check_end(record.time);
          statistics.check_end(record.time, judge.verdict);
          end_with(options, {end, ""});
          log::status("");
        }
      catch (const Stopped &stop)
        {
          end = Verdict::End::stopped;
          give_up(options, {end, stop.what()});
        }
      catch (const RunFailure &failure)
        {
          end = Verdict::End::failed;
          give_up(options, {end, failure.what()});
        }
      catch (const LoneFailure &failure)
        {
          write_lone_summary(options.directory,
                             {Verdict::End::failed, failure.what()},
                             judge.verdict,
                             record);
          throw;
        }
      log::info(judge.verdict.sentence(end) + ", results in " + options.directory);
      return end == Verdict::End::completed;
    }
  } // namespace


  std::unique_ptr<Simulation>
  Simulation::create(const Case &description, const bool goes_on)
  {
    if (description.parameters().integer("dimension") == 2)
      return std::make_unique<SimulationInDimension<2>>(description, goes_on);
    return std::make_unique<SimulationInDimension<3>>(description, goes_on);
  }
} // namespace feib
