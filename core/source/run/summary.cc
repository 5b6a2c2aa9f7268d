// SPDX-License-Identifier: LGPL-2.1-or-later
#include "summary.h"

#include "error_norms.h"
#include "structure_summary.h"

#include <feib/failure.h>
#include <feib/version.h>

#include <deal.II/base/mpi.h>

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace feib
{
  namespace
  {
    /// What the last row of the ledger says of a structure.
    template <int dim>
    void
    add_last_row(Json &summary, const StructureModel<dim> &model, const Ledger &ledger)
    {
      const auto force = [&](const std::string &name) {
        Json components = Json::array();
        for (unsigned int a = 0; a < dim; ++a)
          components.push_back(ledger.last(std::string("force_") + "xyz"[a] + "_" + name));
        return components;
      };
      summary["force"] = force(model.name());
      summary["axes"]  = Json::array();
      for (unsigned int k = 1; k <= dim; ++k)
        summary["axes"].push_back(ledger.last("axis_" + std::to_string(k) + "_" + model.name()));
      summary["forces"] = Json::object();
      for (const std::string &name : model.force_names())
        summary["forces"][name] = {{"energy", ledger.last("energy_" + model.name() + "_" + name)},
                                   {"force", force(model.name() + "_" + name)}};
    }


    template <int dim>
    Json
    energy_summary(const Accounts<dim> &accounts)
    {
      const auto finite    = [](const double value) { return std::isfinite(value) ? value : 0.; };
      const Ledger &ledger = accounts.ledger;
      const auto &totals   = accounts.totals;
      return {{"kinetic", ledger.last("kinetic")},
              {"elastic", ledger.last("elastic")},
              {"potential", ledger.last("potential")},
              {"dissipated", ledger.last("dissipated")},
              {"numerical", ledger.last("numerical")},
              {"unexplained", ledger.last("unexplained")},
              {"inelastic", ledger.last("inelastic")},
              {"largest_closure", totals.largest_closure},
              {"total_initial", ledger.first("total_energy")},
              {"total_final", ledger.last("total_energy")},
              {"largest_increase", finite(totals.largest_increase)},
              {"largest_relative_increase", finite(totals.largest_relative_increase)}};
    }


    template <int dim>
    Json
    unknowns(const Components<dim> &components)
    {
      unsigned int n = 0;
      for (const ImmersedStructure<dim> &structure : components.structures)
        n += dim * structure.model->mesh().n_nodes();
      return {{"velocity", components.space->velocity_handler().n_dofs()},
              {"pressure", components.space->pressure_handler().n_dofs()},
              {"structures", n}};
    }


    /// How the run went, beside its end.
    template <int dim>
    Json
    summary(const Components<dim> &components,
            const Accounts<dim> &accounts,
            const Statistics &statistics,
            const RunRecord &record)
    {
      const EulerianSpace<dim> &space = *components.space;
      const Ledger &ledger            = accounts.ledger;
      const auto &totals              = accounts.totals;
      struct rusage usage;
      getrusage(RUSAGE_SELF, &usage);
      const double memory =
        dealii::Utilities::MPI::sum(usage.ru_maxrss / 1024., space.communicator());

      Json result;
      result["version"]          = version();
      result["ranks"]            = dealii::Utilities::MPI::n_mpi_processes(space.communicator());
      result["steps"]            = record.step;
      result["time"]             = record.time;
      result["wall_seconds"]     = record.wall_seconds;
      result["seconds_per_step"] = {{"median", record.step_seconds.median()},
                                    {"max", record.step_seconds.largest()}};
      result["timers"]           = components.timers.seconds();
      result["peak_memory_mb"]   = memory;
      result["unknowns"]         = unknowns(components);
      result["cells"]            = space.triangulation().n_global_active_cells();
      const double steps         = std::max(1u, record.step);
      // From a cold start, and with solutions to extrapolate.
      result["iterations"] = {{"linear_first", totals.first_linear_iterations},
                              {"linear_last",
                               ledger.n_rows() > 0 ? ledger.last("linear_iterations") : 0.},
                              {"linear_mean", totals.linear_iterations / steps},
                              {"nonlinear_mean", totals.nonlinear_iterations / steps},
                              {"geometry_mean", totals.geometry_iterations / steps}};
      result["retries"]    = record.retries;
      result["remeshes"]   = {{"count", record.remeshes}, {"seconds", record.remesh_seconds}};
      if (std::isfinite(record.stability_limit))
        result["stability_limit"] = record.stability_limit;
      if (record.step > 0)
        result["dt"] = {{"smallest", totals.smallest_dt}, {"largest", totals.largest_dt}};
      if (ledger.n_rows() > 0)
        result["energy"] = energy_summary(accounts);
      result["structures"] = Json::array();
      for (unsigned int s = 0; s < components.structures.size(); ++s)
        {
          const StructureModel<dim> &model = *components.structures[s].model;
          result["structures"].push_back(
            structure_summary(model, totals.leak[s], totals.time_error[s]));
          if (ledger.n_rows() > 0)
            add_last_row(result["structures"].back(), model, ledger);
          if (const auto f = statistics.frequency("lift_" + model.name()))
            result["structures"].back()["strouhal"] = components.coefficients->strouhal(*f);
        }
      if (Json of_window = statistics.to_json(); !of_window.is_null())
        result["statistics"] = std::move(of_window);
      if (components.exact_velocity && ledger.n_rows() > 0)
        {
          const ErrorNorms norms = error_norms(space,
                                               record.time,
                                               *components.exact_velocity,
                                               components.exact_pressure.get());
          result["errors"]       = {{"velocity_l2", norms.velocity_l2},
                                    {"velocity_h1", norms.velocity_h1}};
          if (components.exact_pressure)
            result["errors"]["pressure_l2"] = norms.pressure_l2;
        }
      return result;
    }


    Json
    document(const Ending &ending, const Verdict &verdict)
    {
      return {{"status", verdict.status(ending.how)},
              {"message", ending.message},
              {"warnings", verdict.to_json()}};
    }
  } // namespace


  void
  Durations::add(const double seconds)
  {
    const long place = std::lround(std::log(std::max(seconds, 1e-6) / 1e-6) / .02);
    if (counts.size() <= std::size_t(place))
      counts.resize(place + 1, 0);
    ++counts[place];
    maximum = std::max(maximum, seconds);
  }


  double
  Durations::median() const
  {
    std::uint64_t total = 0, below = 0;
    for (const std::uint64_t count : counts)
      total += count;
    for (std::size_t place = 0; place < counts.size(); ++place)
      if ((below += counts[place]) > total / 2)
        return 1e-6 * std::exp(.02 * place);
    return 0;
  }


  template <int dim>
  void
  write_summary(const std::string &directory,
                const Ending &ending,
                const Verdict &verdict,
                const Components<dim> &components,
                const Accounts<dim> &accounts,
                const Statistics &statistics,
                const RunRecord &record)
  {
    Json result = document(ending, verdict);
    result.update(summary(components, accounts, statistics, record));
    agree(components.space->communicator(), [&] {
      if (dealii::Utilities::MPI::this_mpi_process(components.space->communicator()) != 0)
        return;
      const std::string file = directory + "/summary.json";
      std::ofstream stream(file);
      stream << result.dump(2) << '\n';
      stream.close();
      if (!stream)
        throw RunFailure("cannot write \"" + file + "\"");
    });
  }


  void
  write_lone_summary(const std::string &directory,
                     const Ending &ending,
                     const Verdict &verdict,
                     const RunRecord &record)
  {
    Json result     = document(ending, verdict);
    result["steps"] = record.step;
    result["time"]  = record.time;
    std::ofstream(directory + "/summary.json") << result.dump(2) << '\n';
    std::ofstream(directory + "/log.txt", std::ios::app) << "error: " << ending.message << '\n';
  }


  template void write_summary(const std::string &,
                              const Ending &,
                              const Verdict &,
                              const Components<2> &,
                              const Accounts<2> &,
                              const Statistics &,
                              const RunRecord &);
  template void write_summary(const std::string &,
                              const Ending &,
                              const Verdict &,
                              const Components<3> &,
                              const Accounts<3> &,
                              const Statistics &,
                              const RunRecord &);
} // namespace feib
