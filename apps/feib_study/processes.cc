// SPDX-License-Identifier: LGPL-2.1-or-later
#include "processes.h"

#include <feib/error.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>

extern char **environ;

namespace feib
{
  namespace
  {
    namespace fs = std::filesystem;

    using File = std::unique_ptr<std::FILE, int (*)(std::FILE *)>;

    struct Running
    {
      Process process;
      File output;
    };


    void
    nothing(int)
    {}


    /// While it lives, the end of a child and the signals that ask this program to end are not
    /// acted upon but wait for next().
    class Signals
    {
    public:
      Signals()
      {
        sigemptyset(&awaited);
        sigaddset(&awaited, SIGCHLD);
        // Who starts this program with a signal ignored, as nohup does, means it.
        for (const int number : {SIGINT, SIGTERM, SIGHUP})
          {
            struct sigaction action;
            sigaction(number, nullptr, &action);
            if (action.sa_handler != SIG_IGN)
              sigaddset(&awaited, number);
          }
        sigprocmask(SIG_BLOCK, &awaited, &mask_before);
        // Were it ignored, children would leave no exit code.
        struct sigaction action = {};
        action.sa_handler       = nothing;
        sigaction(SIGCHLD, &action, &child_before);
      }

      ~Signals()
      {
        sigaction(SIGCHLD, &child_before, nullptr);
        sigprocmask(SIG_SETMASK, &mask_before, nullptr);
      }

      int
      next() const
      {
        int number;
        do
          number = sigwaitinfo(&awaited, nullptr);
        while (number < 0); // EINTR: stopped and continued
        return number;
      }

      sigset_t mask_before;

    private:
      sigset_t awaited;
      struct sigaction child_before;
    };


    /// Where MPI keeps temporary files. Programs of Open MPI 4 that share a folder, as they do
    /// unless told otherwise, remove it when they end, under the hands of those that are starting:
    /// each has one of its own, and all are gone with this object.
    class SessionFolders
    {
    public:
      SessionFolders()
      {
        std::error_code problem;
        std::string name = (fs::temp_directory_path(problem) / "feib-study-XXXXXX").string();
        if (!problem && mkdtemp(name.data()) != nullptr)
          parent = name;
      }

      ~SessionFolders()
      {
        std::error_code ignored;
        if (!parent.empty())
          fs::remove_all(parent, ignored);
      }

      SessionFolders(const SessionFolders &)            = delete;
      SessionFolders &operator=(const SessionFolders &) = delete;

      /// A path that was not given before, for MPI to make; empty where nothing can be written.
      std::string
      next()
      {
        return parent.empty() ? "" : (parent / std::to_string(n_given++)).string();
      }

    private:
      fs::path parent;
      unsigned int n_given = 0;
    };


    /// The environment of a program that is not under MPI, whoever started this one; and several
    /// programs under mpiexec at once must not be bound to the same cores.
    std::vector<std::string>
    environment(const std::string &session_folder)
    {
      std::vector<std::string> variables = {"OMPI_MCA_hwloc_base_binding_policy=none",
                                            "OMPI_MCA_rmaps_base_oversubscribe=1"};
      if (!session_folder.empty())
        variables.push_back("OMPI_MCA_orte_top_session_dir=" + session_folder);
      for (char **variable = environ; *variable != nullptr; ++variable)
        {
          const std::string text = *variable;
          bool kept              = true;
          for (const char *const prefix : {"OMPI_COMM",
                                           "OMPI_UNIVERSE_SIZE=",
                                           "OMPI_NUM_APP_CTX=",
                                           "OMPI_APP_CTX_NUM_PROCS=",
                                           "OMPI_FIRST_RANKS=",
                                           "OMPI_FILE_LOCATION=",
                                           "OMPI_MCA_ess",
                                           "OMPI_MCA_initial_wdir=",
                                           "OMPI_MCA_orte",
                                           "OMPI_MCA_pmix",
                                           "OMPI_MCA_hwloc_base_binding_policy=",
                                           "OMPI_MCA_rmaps_base_oversubscribe=",
                                           "PMIX_",
                                           "PMI_",
                                           "PRTE_"})
            kept = kept && text.rfind(prefix, 0) != 0;
          if (kept)
            variables.push_back(text);
        }
      return variables;
    }


    /// The pointers that spawning wants, ended by a null pointer.
    std::vector<char *>
    pointers(std::vector<std::string> &texts)
    {
      std::vector<char *> result;
      for (std::string &text : texts)
        result.push_back(text.data());
      result.push_back(nullptr);
      return result;
    }


    pid_t
    start(Running &running, const std::string &session_folder, const sigset_t &mask)
    {
      Process &process = running.process;
      running.output   = process.output_file.empty()
                           ? File(std::tmpfile(), std::fclose)
                           : File(std::fopen(process.output_file.c_str(), "w"), std::fclose);
      if (!running.output)
        throw RunFailure("cannot write " +
                         (process.output_file.empty() ? "a temporary file" : process.output_file) +
                         ": " + std::strerror(errno));

      posix_spawn_file_actions_t actions;
      posix_spawn_file_actions_init(&actions);
      posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
      posix_spawn_file_actions_adddup2(&actions, fileno(running.output.get()), STDOUT_FILENO);
      posix_spawn_file_actions_adddup2(&actions, fileno(running.output.get()), STDERR_FILENO);
      posix_spawnattr_t attributes;
      posix_spawnattr_init(&attributes);
      posix_spawnattr_setsigmask(&attributes, &mask);
      // A process group of its own: Ctrl-C at the terminal reaches it once, passed on, and not a
      // second time, which would end feib-host before it has written its last state.
      posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);

      std::vector<std::string> variables = environment(session_folder);
      pid_t pid                          = 0;
      const int problem                  = posix_spawnp(&pid,
                                       process.command[0].c_str(),
                                       &actions,
                                       &attributes,
                                       pointers(process.command).data(),
                                       pointers(variables).data());
      posix_spawnattr_destroy(&attributes);
      posix_spawn_file_actions_destroy(&actions);
      if (problem != 0)
        throw RunFailure("cannot start " + process.command[0] + ": " + std::strerror(problem));
      return pid;
    }


    std::string
    content(std::FILE *const file)
    {
      std::string text;
      char buffer[4096];
      std::size_t n;
      std::rewind(file);
      while ((n = std::fread(buffer, 1, sizeof buffer, file)) > 0)
        text.append(buffer, n);
      return text;
    }
  } // namespace


  void
  ProcessQueue::add(Process process)
  {
    waiting.push_back(std::move(process));
  }


  void
  ProcessQueue::run(const unsigned int n)
  {
    const Signals signals;
    SessionFolders session_folders;
    std::map<pid_t, Running> running;
    int received = 0;
    try
      {
        while (!running.empty() || (!waiting.empty() && received == 0))
          {
            while (received == 0 && !waiting.empty() && running.size() < n)
              {
                Running next{std::move(waiting.front()), File(nullptr, std::fclose)};
                waiting.pop_front();
                const pid_t pid = start(next, session_folders.next(), signals.mask_before);
                running.emplace(pid, std::move(next));
              }

            const int number = signals.next();
            if (number != SIGCHLD)
              {
                received = number;
                for (const auto &[pid, process] : running)
                  kill(pid, number);
              }
            // One SIGCHLD may stand for several ends.
            for (auto child = running.begin(); child != running.end();)
              {
                int status;
                if (waitpid(child->first, &status, WNOHANG) != child->first)
                  {
                    ++child;
                    continue;
                  }
                const Running ended = std::move(child->second);
                child               = running.erase(child);
                ended.process.on_end(WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status),
                                     ended.process.output_file.empty() ? content(ended.output.get())
                                                                       : "");
              }
          }
      }
    catch (...)
      {
        for (const auto &[pid, process] : running)
          kill(pid, SIGTERM);
        for (const auto &[pid, process] : running)
          waitpid(pid, nullptr, 0);
        throw;
      }
    if (received != 0)
      throw RunFailure("stopped by a signal; the same command goes on from here");
  }
} // namespace feib
