// SPDX-License-Identifier: LGPL-2.1-or-later
#include "command_line.h"
#include "runs.h"
#include "study.h"
#include "table.h"

#include <feib/case.h>
#include <feib/message.h>
#include <feib/version.h>

#include <iostream>

namespace
{
  using namespace feib;

  void
  print(const std::string &text)
  {
    std::cout << text << std::flush;
  }


  /// Returns the exit code.
  int
  execute(const StudyCommandLine &command)
  {
    if (command.show_help)
      return print(StudyCommandLine::help()), 0;
    if (command.version)
      return print("feib-study " + version() + "\n"), 0;

    const std::string text = Case::read(command.study_file);
    std::optional<Study> study;
    try
      {
        study.emplace(text, command.study_file);
      }
    catch (const Error &error)
      {
        std::cerr << Case::format(error.issues(), text, command.study_file);
        return 2;
      }

    // One bad case stops the study before anything long has been run.
    Runs runs(*study, command);
    runs.validate();
    if (command.validate)
      return print(command.study_file +
                   " is valid; combinations: " + std::to_string(runs.combinations().size()) + "\n"),
             0;

    runs.run();
    const Table table(*study, runs.combinations());
    write_file(std::filesystem::path(command.output) / "table.md", table.markdown());
    write_file(std::filesystem::path(command.output) / "table.csv", table.csv());
    std::cerr << "runs done: " << runs.n_done << ", found done: " << runs.n_found << ", results in "
              << command.output << std::endl;
    print(table.markdown());
    if (runs.n_lost > 0)
      throw RunFailure("runs without a result: " + std::to_string(runs.n_lost) +
                       "; the same command repeats them");
    return 0;
  }
} // namespace


// MPI is for the runs: this program starts them and has no part in it.
int
main(int argc, char **argv)
{
  try
    {
      return execute(StudyCommandLine(argc, argv));
    }
  catch (const Error &error)
    {
      std::cerr << "error: " << readable_lines(error.what()) << std::endl;
      return 2;
    }
  catch (const std::exception &failure)
    {
      std::cerr << "error: " << readable_lines(failure.what()) << std::endl;
      return 1;
    }
}
