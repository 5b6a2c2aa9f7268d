// SPDX-License-Identifier: LGPL-2.1-or-later
#include "runs.h"

#include <feib/error.h>
#include <feib/version.h>

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <thread>

namespace feib
{
  namespace fs = std::filesystem;

  namespace
  {
    /// The status of a run that leaves nothing to rely on: killed, told to stop, out of disk.
    const char *const no_result = "no result";


    std::optional<std::string>
    read_file(const fs::path &file)
    {
      std::ifstream stream(file, std::ios::binary);
      std::ostringstream text;
      text << stream.rdbuf();
      if (!stream)
        return {};
      return text.str();
    }


    /// The summary of a run, or null.
    Json
    read_summary(const fs::path &folder)
    {
      const std::optional<std::string> text = read_file(folder / "summary.json");
      const Json summary                    = Json::parse(text.value_or(""), nullptr, false);
      return summary.is_object() ? summary : Json();
    }


    void
    make_folder(const fs::path &folder)
    {
      std::error_code problem;
      fs::create_directories(folder, problem);
      if (problem)
        throw RunFailure("cannot make the folder " + folder.string() + ": " + problem.message());
    }


    /// Keeps other calls out of a folder until this program ends.
    void
    lock(const fs::path &folder)
    {
      const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      if (descriptor < 0 || flock(descriptor, LOCK_EX | LOCK_NB) != 0)
        throw RunFailure(errno == EWOULDBLOCK
                           ? "another feib-study works in " + folder.string()
                           : "cannot lock " + folder.string() + ": " + std::strerror(errno));
    }


    /// The host would not, or could not, take up a run.
    [[noreturn]] void
    refused(const Run &run, const int exit_code, std::string said)
    {
      while (!said.empty() && said.back() == '\n')
        said.pop_back();
      if (exit_code == 2)
        throw Error("the case with " + run.label + " cannot be run:\n" + said);
      throw RunFailure("feib-host does not work with " + run.label + ":\n" +
                       (exit_code < 0 ? strsignal(-exit_code) : said));
    }


    /// What a run that ended says of itself. To be told to stop is no result.
    Outcome
    outcome_of(const int exit_code, Json summary)
    {
      const std::string status = summary.is_object() ? summary.value("status", "") : "";
      const bool ended =
        exit_code == 0 ? status.rfind("completed", 0) == 0 : exit_code == 1 && status == "failed";
      return {ended ? status : no_result, std::move(summary)};
    }
  } // namespace


  Runs::Runs(const Study &study, const StudyCommandLine &command)
    : study(study)
    , command(command)
    , jobs(command.jobs != 0 ? command.jobs
                             : std::max(1u, std::thread::hardware_concurrency() / study.ranks))
  {
    // All combinations, the last axis varying fastest.
    all.emplace_back();
    for (const Axis &axis : study.axes)
      {
        std::vector<Combination> longer;
        for (const Combination &combination : all)
          for (std::size_t i = 0; i < axis.values.size(); ++i)
            {
              longer.push_back(combination);
              longer.back().values.push_back(i);
            }
        all = std::move(longer);
      }
  }


  Run
  Runs::make_run(const Combination &combination, const std::optional<double> value) const
  {
    Run run;
    run.settings   = study.settings;
    const auto add = [&](const std::string &name, const Json &label, const Settings &settings) {
      const std::string entry = name + "=" + shown(label);
      run.label += (run.label.empty() ? "" : ", ") + entry;
      run.folder += (run.folder.empty() ? "" : ",") + folder_name(entry);
      run.settings.insert(run.settings.end(), settings.begin(), settings.end());
    };
    for (std::size_t a = 0; a < study.axes.size(); ++a)
      {
        const Axis::Value &entry = study.axes[a].values[combination.values[a]];
        add(study.axes[a].name, entry.label, entry.settings);
      }
    if (value)
      add(study.bisection->name, *value, study.bisection->settings(*value));
    run.folder = (fs::path(command.output) / "runs" / run.folder).string();
    return run;
  }


  std::vector<std::string>
  Runs::host(const Run &run, const unsigned int ranks) const
  {
    std::vector<std::string> words;
    if (ranks > 1)
      words = {"mpiexec", "-n", std::to_string(ranks)};
    words.push_back((fs::read_symlink("/proc/self/exe").parent_path() / "feib-host").string());
    words.push_back(study.case_file);
    for (const std::string &folder : command.plugin_path)
      words.insert(words.end(), {"--plugin-path", folder});
    for (const auto &[pointer, value] : run.settings)
      words.insert(words.end(), {"--set", pointer + "=" + value.dump()});
    return words;
  }


  std::string
  Runs::record(const Run &run, const int exit_code) const
  {
    Json settings = Json::array();
    for (const auto &[pointer, value] : run.settings)
      settings.push_back({{"pointer", pointer}, {"value", value}});
    const Json record = {{"exit_code", exit_code},
                         {"version", version()},
                         {"ranks", study.ranks},
                         {"settings", settings},
                         {"case", study.case_text}};
    // A comment of the case may hold bytes that are no UTF-8.
    return record.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  }


  const Outcome *
  Runs::find(const Run &run)
  {
    if (const auto known = outcomes.find(run.folder); known != outcomes.end())
      return &known->second;
    const std::optional<std::string> written = read_file(fs::path(run.folder) / "run.json");
    for (const int exit_code : {0, 1})
      if (written == record(run, exit_code))
        if (Json summary = read_summary(run.folder); !summary.is_null())
          {
            ++n_found;
            return &(outcomes[run.folder] = outcome_of(exit_code, std::move(summary)));
          }
    return nullptr;
  }


  void
  Runs::validate()
  {
    std::map<std::size_t, std::function<void()>> refusals; // in the order of the runs
    std::size_t n_runs = 0;
    for (const Combination &combination : all)
      {
        // Values between the ends of a bisection differ from them in nothing that a check can find.
        std::vector<Run> runs;
        if (study.bisection)
          runs = {make_run(combination, study.bisection->lower),
                  make_run(combination, study.bisection->upper)};
        else
          runs = {make_run(combination)};
        for (const Run &run : runs)
          if (++n_runs; find(run) == nullptr)
            {
              Process check{host(run, 1), "", {}};
              check.command.push_back("--validate");
              check.on_end = [&refusals, run, i = n_runs](const int exit_code,
                                                          const std::string &said) {
                if (exit_code != 0)
                  refusals[i] = [=] { refused(run, exit_code, said); };
              };
              queue.add(std::move(check));
            }
      }
    queue.run(jobs);
    if (!refusals.empty())
      refusals.begin()->second();
  }


  void
  Runs::run()
  {
    const fs::path folder = fs::path(command.output) / "runs";
    make_folder(folder);
    lock(folder);
    for (Combination &combination : all)
      proceed(combination);
    queue.run(jobs);
  }


  void
  Runs::proceed(Combination &combination)
  {
    if (!study.bisection)
      {
        const Run run = make_run(combination);
        if (const Outcome *const outcome = find(run))
          combination.outcome = *outcome;
        else
          start(run, combination);
        return;
      }

    bool lost        = false;
    const auto state = study.bisection->follow([&](const double value) -> std::optional<bool> {
      const Outcome *const outcome = find(make_run(combination, value));
      if (outcome == nullptr)
        return {};
      lost = lost || outcome->status == no_result;
      return outcome->completed();
    });
    if (lost)
      combination.outcome.status = no_result;
    else if (state.next)
      start(make_run(combination, *state.next), combination);
    else
      {
        combination.limit          = state.result;
        combination.outcome.status = "failed";
        if (state.completed)
          combination.outcome = *find(make_run(combination, *state.completed));
      }
  }


  void
  Runs::start(const Run &run, Combination &combination)
  {
    const fs::path folder = run.folder;
    make_folder(folder);
    // Those of a run with other settings must not speak for this one, should it be interrupted.
    std::error_code ignored;
    for (const char *const file : {"run.json", "summary.json"})
      fs::remove(folder / file, ignored);

    Process process{host(run, study.ranks), (folder / "host.txt").string(), {}};
    process.command.insert(process.command.end(), {"--output", run.folder, "--overwrite"});
    process.on_end = [this, run, &combination](const int exit_code, const std::string &) {
      finish(run, exit_code);
      proceed(combination);
    };
    queue.add(std::move(process));
  }


  void
  Runs::finish(const Run &run, const int exit_code)
  {
    const fs::path folder = run.folder;
    if (exit_code == 2)
      refused(run, exit_code, read_file(folder / "host.txt").value_or(""));

    Outcome outcome = outcome_of(exit_code, read_summary(folder));

    std::ostringstream line;
    line << '[' << n_done + n_found + n_lost + 1;
    if (!study.bisection)
      line << '/' << all.size();
    line << "] " << run.label << ": " << outcome.status;
    if (outcome.status == no_result)
      {
        ++n_lost;
        line << ", "
             << (exit_code < 0 ? strsignal(-exit_code) : "see " + (folder / "host.txt").string());
        outcome.summary = Json();
      }
    else
      {
        ++n_done;
        write_file(folder / "run.json", record(run, exit_code));
        if (outcome.summary.contains("wall_seconds"))
          line << " in " << std::setprecision(3) << outcome.summary["wall_seconds"].get<double>()
               << " s";
      }
    std::cerr << line.str() << std::endl;
    outcomes[run.folder] = std::move(outcome);
  }


  void
  write_file(const fs::path &file, const std::string &text)
  {
    fs::path part = file;
    part += ".part";
    std::ofstream stream(part, std::ios::binary);
    stream << text;
    stream.close();
    std::error_code problem;
    if (stream)
      fs::rename(part, file, problem);
    if (!stream || problem)
      throw RunFailure("cannot write " + file.string());
  }
} // namespace feib
