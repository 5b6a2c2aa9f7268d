// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_study_processes_h
#define feib_study_processes_h

#include <deque>
#include <functional>
#include <string>
#include <vector>

namespace feib
{
  /// A program to run.
  struct Process
  {
    std::vector<std::string> command;
    std::string output_file; // what the program says goes here; kept for on_end when empty

    /// Called when the program has ended, with its exit code (of a signal that ended it, minus its
    /// number) and, when there is no file, with what it said.
    std::function<void(int exit_code, const std::string &output)> on_end;
  };


  /// Programs that wait for their turn, and those that run.
  class ProcessQueue
  {
  public:
    void add(Process process);

    /// Runs all, at most @p n at once, until none is left; an on_end may add more. A signal that
    /// asks this program to end (SIGINT, SIGTERM, SIGHUP) is passed on to those running, no more
    /// are started, and when the last has ended RunFailure is thrown. RunFailure also when a
    /// program cannot be started. Whatever is thrown, nothing is left running.
    void run(unsigned int n);

  private:
    std::deque<Process> waiting;
  };
} // namespace feib

#endif
