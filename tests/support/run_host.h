// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_tests_run_host_h
#define feib_tests_run_host_h

#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

/// Helpers for tests that run feib-host as a user does.
namespace feib::testing
{
  /// A folder of this test's own, removed at its end.
  class TemporaryFolder
  {
  public:
    TemporaryFolder()
    {
      std::string name = (std::filesystem::temp_directory_path() / "feib-test-XXXXXX").string();
      if (mkdtemp(name.data()) == nullptr)
        throw std::runtime_error("cannot make a temporary folder");
      path = name;
    }

    ~TemporaryFolder()
    {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }

    TemporaryFolder(const TemporaryFolder &)            = delete;
    TemporaryFolder &operator=(const TemporaryFolder &) = delete;

    /// The path of a file in the folder.
    std::string
    operator/(const std::string &name) const
    {
      return (path / name).string();
    }

    /// Writes a file into the folder and returns its path.
    std::string
    write(const std::string &name, const std::string &text) const
    {
      std::ofstream(path / name) << text;
      return *this / name;
    }

    std::filesystem::path path;
  };


  inline std::string
  shell_quoted(const std::string &text)
  {
    std::string quoted = "'";
    for (const char c : text)
      quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
  }


  struct RunResult
  {
    int exit_code;
    std::string output; // standard output and standard error
  };


  /// Runs a shell command, in @p folder when one is given.
  inline RunResult
  run_command(const std::string &command, const std::string &folder = "")
  {
    const std::string all = (folder.empty() ? "" : "cd " + shell_quoted(folder) + " && ") + "( " +
                            command + " ) 2>&1 </dev/null";
    FILE *const pipe = popen(all.c_str(), "r");
    if (pipe == nullptr)
      throw std::runtime_error("cannot run " + command);
    RunResult result;
    char buffer[4096];
    std::size_t n;
    while ((n = fread(buffer, 1, sizeof buffer, pipe)) > 0)
      result.output.append(buffer, n);
    const int status = pclose(pipe);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return result;
  }


  /// The command that starts feib-host on @p ranks ranks. Its environment is cleaned of what a test
  /// program that is itself under MPI would hand on.
  inline std::string
  host_command(const unsigned int ranks = 1)
  {
    const std::string clean =
      "unset $(env | grep -oE '^(OMPI_COMM|OMPI_MCA_(ess|orte|pmix)|PMIX|PRTE)[A-Za-z0-9_]*'); ";
    return clean +
           (ranks == 1
              ? ""
              : std::string(FEIB_MPIEXEC) + " -np " + std::to_string(ranks) + " --oversubscribe ") +
           shell_quoted(FEIB_HOST);
  }


  /// Runs feib-host with the arguments (quoted for a shell where they need it).
  inline RunResult
  run_host(const std::string &arguments,
           const unsigned int ranks  = 1,
           const std::string &folder = "")
  {
    return run_command(host_command(ranks) + " " + arguments, folder);
  }


  inline std::string
  read_file(const std::string &name)
  {
    std::ifstream file(name);
    std::ostringstream text;
    text << file.rdbuf();
    if (!file)
      throw std::runtime_error("cannot read " + name);
    return text.str();
  }


  /// Reads a JSON file, e.g. DIR/summary.json.
  inline nlohmann::json
  read_json(const std::string &name)
  {
    return nlohmann::json::parse(read_file(name));
  }
} // namespace feib::testing

#endif
