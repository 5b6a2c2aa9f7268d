// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_host_output_folder_h
#define feib_host_output_folder_h

#include <string>

/// The folder a run writes into. Each function is called on rank 0 and returns what forbids, a
/// sentence, or "".
namespace feib::output_folder
{
  /// Whether a new run may write there: an empty folder, one that is not there yet or, with
  /// @p overwrite, one that no run is writing into.
  std::string refusal(const std::string &directory, bool overwrite);

  /// Keeps other processes of feib-host out of a folder until this one ends, however it ends. Where
  /// the file system has no locks nobody is kept out.
  std::string claim(const std::string &directory);

  /// Makes the folder.
  std::string make(const std::string &directory);

  /// Puts the exact run into the folder. @p goes_on: with the run whose files are there.
  std::string begin(const std::string &directory, const std::string &resolved, bool goes_on);
} // namespace feib::output_folder

#endif
