// SPDX-License-Identifier: LGPL-2.1-or-later
#include "synced_file.h"

#include <feib/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace feib
{
  void
  sync(const std::filesystem::path &path)
  {
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    const bool done      = descriptor >= 0 && fsync(descriptor) == 0;
    const int problem    = errno;
    if (descriptor >= 0)
      close(descriptor);
    if (!done)
      throw RunFailure("cannot write " + path.string() + ": " + std::strerror(problem));
  }


  void
  write_synced(const std::filesystem::path &path, const std::string &text)
  {
    errno = 0;
    std::ofstream stream(path, std::ios::binary);
    stream.write(text.data(), text.size());
    stream.close();
    if (!stream)
      throw RunFailure("cannot write " + path.string() +
                       (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
    sync(path);
  }
} // namespace feib
