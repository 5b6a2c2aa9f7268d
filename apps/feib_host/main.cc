// SPDX-License-Identifier: LGPL-2.1-or-later
#include "check_plugin.h"
#include "command_line.h"
#include "output_folder.h"
#include "provenance.h"

#include <feib/log.h>
#include <feib/message.h>
#include <feib/plugin_loader.h>
#include <feib/schema.h>
#include <feib/simulation.h>
#include <feib/version.h>

#include <deal.II/base/mpi.h>

#include <boost/serialization/utility.hpp>
#include <nlohmann/json.hpp>

#include <signal.h>
#include <unistd.h>

#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <map>
#include <random>
#include <sstream>

namespace
{
  using namespace feib;

  /// What asks a program to end: a person, a batch system before or at its limit of time, a
  /// terminal that is closed.
  constexpr std::pair<int, const char *> signals[] = {{SIGINT, "INT"},
                                                      {SIGTERM, "TERM"},
                                                      {SIGHUP, "HUP"},
                                                      {SIGUSR1, "USR1"},
                                                      {SIGUSR2, "USR2"},
                                                      {SIGXCPU, "XCPU"}};

  volatile sig_atomic_t signal_received   = 0;
  volatile sig_atomic_t checkpoint_wanted = 0;
  volatile sig_atomic_t running           = 0;
  volatile sig_atomic_t silent            = 0; // a rank that does not speak

  /// For handlers of signals, where little is allowed.
  void
  say(const char *const text)
  {
    if (silent == 0 && write(STDERR_FILENO, text, std::strlen(text)) < 0)
      return;
  }


  /// Asks the run for a checkpoint (USR1), or to stop; before a run, and with a second signal, ends
  /// the program at once. XCPU comes every second once its limit is reached, and is not meant anew.
  extern "C" void
  on_signal(const int number)
  {
    if (number == SIGUSR1)
      {
        checkpoint_wanted = 1;
        return;
      }
    if (running != 0 && signal_received == 0)
      {
        signal_received = number;
        return;
      }
    if (running != 0 && number == SIGXCPU)
      return;
    say("error: stopped by the signal ");
    for (const auto &[known, name] : signals)
      if (known == number)
        say(name);
    say(running != 0 ? " at once, the second one\n" : " before the run began\n");
    _exit(128 + number);
  }


  /// From the first moment. Who started the program with nohup does not want it to end with the
  /// terminal.
  void
  handle_signals()
  {
    struct sigaction action = {}, before = {};
    action.sa_handler = on_signal;
    action.sa_flags   = SA_RESTART;
    sigset_t set;
    sigemptyset(&set);
    for (const auto &[number, name] : signals)
      {
        sigaction(number, nullptr, &before);
        if (number != SIGHUP || before.sa_handler != SIG_IGN)
          sigaction(number, &action, nullptr);
        sigaddset(&set, number);
      }
    sigprocmask(SIG_UNBLOCK, &set, nullptr);
    // A file beyond the limit of sizes is a failure with its name; who listens no more ends
    // nothing.
    for (const int number : {SIGXFSZ, SIGPIPE})
      signal(number, SIG_IGN);
  }


  bool
  speaks()
  {
    return dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
  }


  void
  print(const std::string &text)
  {
    if (speaks())
      std::cout << text << std::flush;
  }


  void
  complain(const std::string &text)
  {
    log::status("");
    if (speaks())
      std::cerr << readable_lines(text) << std::flush;
  }


  /// For a program started without mpirun. Open MPI would start a daemon first, for processes that
  /// never come, and look for a quarter of a second for networks to them. Without a daemon all
  /// programs share a folder for their temporary files, which whichever ends first removes, and the
  /// others can open no file: each gets its own, which Open MPI removes as well.
  void
  stand_alone()
  {
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    if (getenv("PMIX_RANK") != nullptr || getenv("PMI_RANK") != nullptr)
      return;
    setenv("OMPI_MCA_pml", "ob1", 0);
    std::error_code problem;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(problem);
    std::random_device random;
    std::ostringstream name;
    name << "feib-host." << getpid() << '.' << std::hex << random() << random();
    if (!problem)
      setenv("OMPI_MCA_orte_top_session_dir", (folder / name.str()).c_str(), 0);
  }


  /// What rank 0 finds, known to all.
  std::string
  on_rank_0(const std::function<std::string()> &find)
  {
    return dealii::Utilities::MPI::broadcast(MPI_COMM_WORLD, speaks() ? find() : std::string());
  }


  std::string
  plugin_table(const PluginLoader &loader, const std::vector<std::string> &path)
  {
    std::ostringstream text;
    text << "Looked in:\n";
    for (const std::string &directory : path)
      text << "  " << directory << '\n';
    text << "Plugins:\n";
    for (const PluginLoader::Result &plugin : loader.results())
      if (plugin.accepted)
        {
          text << "  " << plugin.plugin << " " << plugin.version << "  (" << plugin.file << ")\n";
          for (const std::string &component : plugin.components)
            text << "    " << component << '\n';
        }
    std::string skipped;
    for (const PluginLoader::Result &plugin : loader.results())
      if (!plugin.accepted)
        skipped += "  " + plugin.file + ": " + plugin.reason + "\n";
    return text.str() + (skipped.empty() ? "" : "Skipped:\n" + skipped);
  }


  /// Takes the folder of the results for this process. Throws Error where that must not be.
  void
  claim(const CommandLine &command)
  {
    const std::string problem = on_rank_0([&] {
      return command.restart.empty() ? output_folder::refusal(command.output, command.overwrite)
                                     : output_folder::claim(command.output);
    });
    if (!problem.empty())
      throw Error(problem);
  }


  /// Refuses to put a run in the place of the one it begins with.
  void
  check_beginning(const Parameters &parameters, const std::string &directory)
  {
    if (!parameters.has("initial_state"))
      return;
    const Parameters block = parameters.child("initial_state");
    const std::string run  = block.path("run");
    const std::string same = on_rank_0([&] {
      std::error_code none;
      return std::string(std::filesystem::equivalent(run, directory, none) ? "same" : "");
    });
    if (!same.empty())
      block.fail("run",
                 "is the output folder: this run would replace the one it begins with; choose "
                 "another with --output");
  }


  std::string
  duration(const double seconds)
  {
    const auto whole = static_cast<unsigned long>(seconds + 0.5);
    std::ostringstream text;
    if (whole >= 3600)
      text << whole / 3600 << " h " << whole / 60 % 60 << " min";
    else if (whole >= 60)
      text << whole / 60 << " min " << whole % 60 << " s";
    else
      text << whole << " s";
    return text.str();
  }


  void
  show(const Progress &progress)
  {
    const double share = std::min(1., progress.time / progress.end);
    std::ostringstream line;
    line << std::fixed << std::setprecision(1) << std::setw(5) << 100 * share << " %  step "
         << progress.step << std::defaultfloat << std::setprecision(4) << "  time " << progress.time
         << " of " << progress.end;
    if (share > 0)
      line << "  " << duration(progress.wall_seconds * (1 - share) / share) << " left";
    log::status(line.str());
  }


  /// What any rank was told.
  Request
  requested()
  {
    const int mine    = signal_received != 0 ? 2 : checkpoint_wanted != 0 ? 1 : 0;
    checkpoint_wanted = 0;
    const int any     = dealii::Utilities::MPI::max(mine, MPI_COMM_WORLD);
    return any == 2 ? Request::stop : any == 1 ? Request::checkpoint : Request::none;
  }


  /// The summary of a run that ended before it could write one, by what perhaps only this rank has
  /// met.
  void
  leave_summary(const std::string &directory, const std::string &what)
  {
    const std::string file = directory + "/summary.json";
    std::error_code problem;
    if (std::filesystem::exists(file, problem))
      return;
    const std::string part =
      file + "." + std::to_string(dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD));
    {
      const nlohmann::ordered_json summary = {{"status", "failed"}, {"message", what}};
      std::ofstream stream(part);
      stream << summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
    }
    std::filesystem::rename(part, file, problem);
  }


  /// What an exception says.
  std::string
  words(const std::exception_ptr &exception)
  {
    try
      {
        std::rethrow_exception(exception);
      }
    catch (const std::bad_alloc &)
      {
        return "out of memory";
      }
    catch (const std::exception &failure)
      {
        return failure.what();
      }
    catch (...)
      {
        return "something that is no std::exception was thrown";
      }
  }


  /// An exception that perhaps only this rank has met: the others would wait for ever.
  int
  give_up(const std::string &what)
  {
    log::status("");
    if (speaks())
      log::error(what); // into the file as well
    else
      std::cerr << readable_lines("error: " + what) << std::endl;
    if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) > 1)
      MPI_Abort(MPI_COMM_WORLD, 1);
    return 1;
  }


  /// Whether the end was reached.
  bool
  run(Simulation &simulation,
      const CommandLine &command,
      const Case &description,
      const std::map<std::string, std::string> &versions,
      const std::string &checkpoint)
  {
    running            = 1;
    const bool goes_on = !checkpoint.empty();
    const auto or_fail = [](const std::string &problem) {
      if (!problem.empty())
        throw RunFailure(problem);
    };
    or_fail(on_rank_0([&] { return output_folder::make(command.output); }));
    claim(command); // as another may have made it meanwhile
    or_fail(on_rank_0(
      [&] { return output_folder::begin(command.output, description.resolved(), goes_on); }));
    log::open_file(command.output + "/log.txt", goes_on);
    log::info("Feib " + version() + ", " + (goes_on ? "from " + checkpoint : command.case_file) +
              ", results in " + command.output);
    try
      {
        return simulation.run({command.output, show, requested, versions, checkpoint});
      }
    catch (const RunFailure &failure)
      {
        leave_summary(command.output, failure.what());
        throw;
      }
    catch (...)
      {
        // Perhaps of this rank alone: here, before anything is destroyed that asks the others.
        const std::string what = words(std::current_exception());
        leave_summary(command.output, what);
        give_up(what);
        return false;
      }
  }


  /// Loads the plugins of the folders. Ranks with other plugins than rank 0 would wait for it, or
  /// it for them.
  void
  load_plugins(PluginLoader &loader, const std::vector<std::string> &path)
  {
    std::pair<std::string, std::string> found; // plugins, problem
    try
      {
        for (const std::string &directory : path)
          loader.load_directory(directory);
      }
    catch (const Error &error)
      {
        found.second = error.what();
      }
    for (const PluginLoader::Result &plugin : loader.results())
      if (plugin.accepted)
        found.first += plugin.plugin + " " + plugin.version + ", ";
    const auto all = dealii::Utilities::MPI::all_gather(MPI_COMM_WORLD, found);
    for (unsigned int rank = 0; rank < all.size(); ++rank)
      {
        if (!all[rank].second.empty())
          throw Error(all[rank].second);
        if (all[rank].first != all[0].first)
          throw Error("rank " + std::to_string(rank) + " finds the plugins " + all[rank].first +
                      "and rank 0 finds " + all[0].first + "which must be the same");
      }
  }


  /// Rank 0 writes, and all learn of an error.
  int
  write_new_plugin(const NewPlugin &plugin, const Registry &registry)
  {
    std::string written;
    const std::string problem = on_rank_0([&]() -> std::string {
      try
        {
          written = write(plugin, registry);
        }
      catch (const Error &error)
        {
          return error.issues()[0].message;
        }
      return "";
    });
    if (!problem.empty())
      throw Error(problem);
    return print(written), 0;
  }


  /// Returns the exit code. Throws Error and RunFailure on all ranks alike.
  int
  execute(const CommandLine &command)
  {
    if (command.show_help)
      return print(CommandLine::help()), 0;
    if (command.version)
      return print("feib-host " + version() + "\n"), 0;
    log::set_level(command.log_level);

    const std::vector<std::string> path = PluginLoader::search_path(command.plugin_path);
    Registry registry;
    PluginLoader loader(registry);
    if (!command.check_plugin.empty())
      loader.load(command.check_plugin);
    load_plugins(loader, path);
    if (!command.check_plugin.empty())
      return check_plugin(loader, registry, print) ? 0 : 2;
    if (command.list_plugins)
      return print(plugin_table(loader, path)), 0;
    for (const PluginLoader::Result &plugin : loader.results())
      if (!plugin.accepted)
        log::debug(plugin.file + " skipped: " + plugin.reason);

    if (!command.describe.empty())
      {
        const Registry::Entry entry = registry.find(command.describe);
        const Schema schema(entry.schema);
        return print(command.json ? schema.text() + "\n"
                                  : entry.kind + "/" + entry.name + ", from " + entry.plugin +
                                      "\n" + schema.describe()),
               0;
      }
    if (command.schema)
      return print(Schema::compose(registry).text() + "\n"), 0;

    if (!command.new_plugin.kind.empty())
      return write_new_plugin(command.new_plugin, registry);

    if (!command.validate)
      claim(command);

    CheckpointInfo checkpoint;
    if (!command.restart.empty())
      checkpoint = CheckpointInfo::newest(command.restart, MPI_COMM_WORLD);
    const bool goes_on     = !checkpoint.folder.empty();
    const std::string name = goes_on ? command.restart + "/resolved.json" : command.case_file;
    const std::string text = goes_on ? checkpoint.case_text : Case::read(command.case_file);
    std::unique_ptr<Case> description;
    std::unique_ptr<Simulation> simulation;
    std::map<std::string, std::string> used;
    try
      {
        description =
          std::make_unique<Case>(text, name, registry, command.settings, checkpoint.case_directory);
        used = provenance(loader, *description);
        if (goes_on)
          checkpoint.check(*description, used);
        if (!goes_on && !command.validate)
          check_beginning(description->parameters(), command.output);
        simulation = Simulation::create(*description, goes_on);
      }
    catch (const Error &error)
      {
        complain(Case::format(error.issues(), text, name, command.settings));
        return 2;
      }
    if (command.validate)
      return print(name + " is valid\n" + simulation->forecast()), 0;
    return run(*simulation, command, *description, used, checkpoint.folder) ? 0 : 1;
  }
} // namespace


int
main(int argc, char **argv)
{
  handle_signals();
  stand_alone();
  // The libraries underneath have options of their own with the same names: they get to see none.
  int only_the_name = 1;
  dealii::Utilities::MPI::MPI_InitFinalize mpi(only_the_name, argv, 1);
  handle_signals(); // MPI may have taken some
  silent = !speaks();
  try
    {
      return execute(CommandLine(argc, argv));
    }
  catch (const Error &error)
    {
      for (const Issue &issue : error.issues())
        complain("error: " + (issue.pointer.empty() ? "" : issue.pointer + ": ") + issue.message +
                 "\n");
      return 2;
    }
  catch (const RunFailure &failure)
    {
      log::status("");
      log::error(failure.what());
      return 1;
    }
  catch (...)
    {
      return give_up(words(std::current_exception()));
    }
}
