// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_synced_file_h
#define feib_source_synced_file_h

#include <filesystem>
#include <string>

namespace feib
{
  /// Waits until a file or a folder is on the disk. Throws RunFailure.
  void sync(const std::filesystem::path &path);

  /// Writes a file and waits until it is on the disk. Throws RunFailure.
  void write_synced(const std::filesystem::path &path, const std::string &text);
} // namespace feib

#endif
