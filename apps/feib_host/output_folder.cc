// SPDX-License-Identifier: LGPL-2.1-or-later
#include "output_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>

namespace feib::output_folder
{
  namespace fs = std::filesystem;

  std::string
  refusal(const std::string &directory, const bool overwrite)
  {
    std::error_code problem;
    if (!fs::exists(directory, problem))
      return "";
    if (!fs::is_directory(directory, problem))
      return "the output folder " + directory + " is a file";
    if (!overwrite && !fs::is_empty(directory, problem))
      return "the output folder " + directory +
             " is not empty; choose another with --output, or allow this one with --overwrite";
    return claim(directory);
  }


  std::string
  claim(const std::string &directory)
  {
    static int claimed = -1;
    if (claimed >= 0)
      return "";
    const int folder = open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0)
      return "";
    if (flock(folder, LOCK_EX | LOCK_NB) == 0)
      {
        claimed = folder; // closed, and so given up, by the end of the process
        return "";
      }
    const bool taken = errno == EWOULDBLOCK;
    close(folder);
    return taken ? "another feib-host is writing into " + directory +
                     "; wait for its end, stop it, or choose another folder"
                 : "";
  }


  std::string
  make(const std::string &directory)
  {
    std::error_code error;
    fs::create_directories(directory, error);
    return error ? "cannot make the folder " + directory + ": " + error.message() : "";
  }


  std::string
  begin(const std::string &directory, const std::string &resolved, const bool goes_on)
  {
    std::error_code error;
    // The summary of an earlier run would speak for this one until its end.
    fs::remove(fs::path(directory) / "summary.json", error);
    // So would its checkpoints.
    if (!goes_on)
      fs::remove_all(fs::path(directory) / "checkpoints", error);
    std::ofstream file(fs::path(directory) / "resolved.json");
    file << resolved << '\n' << std::flush;
    return file ? "" : "cannot write into " + directory;
  }
} // namespace feib::output_folder
