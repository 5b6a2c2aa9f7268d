// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/appended_file.h>
#include <feib/error.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace feib
{
  namespace
  {
    [[noreturn]] void
    fail(const std::string &name)
    {
      throw RunFailure("cannot write " + name + ": " + std::strerror(errno));
    }


    std::shared_ptr<const int>
    open_file(const std::string &name, const int flags)
    {
      const int descriptor = open(name.c_str(), flags | O_CLOEXEC, 0666);
      if (descriptor < 0)
        fail(name);
      return {new int(descriptor), [](const int *const number) {
                close(*number);
                delete number;
              }};
    }
  } // namespace


  void
  AppendedFile::open(const std::string &file, const std::string &head)
  {
    *this      = AppendedFile();
    name       = file;
    descriptor = open_file(name, O_WRONLY | O_CREAT | O_TRUNC);
    append(head);
  }


  void
  AppendedFile::reopen(const std::string &file, const std::string &tail)
  {
    if (length == 0)
      return; // it was not there yet
    name       = file;
    descriptor = open_file(name, O_WRONLY);
    struct stat status;
    if (fstat(*descriptor, &status) != 0)
      fail(name);
    if (std::uint64_t(status.st_size) < length)
      throw RunFailure(name + " has " + std::to_string(status.st_size) + " bytes, and had " +
                       std::to_string(length) +
                       " when the state was written: it is of another run, or has been changed");
    if (ftruncate(*descriptor, length) != 0)
      fail(name);
    write(tail);
  }


  void
  AppendedFile::append(const std::string &text, const std::string &tail)
  {
    write(text + tail);
    length += text.size();
  }


  void
  AppendedFile::write(const std::string &text)
  {
    std::size_t done = 0;
    while (done < text.size())
      {
        const ssize_t n =
          pwrite(*descriptor, text.data() + done, text.size() - done, length + done);
        if (n < 0 && errno == EINTR)
          continue;
        if (n <= 0)
          fail(name);
        done += n;
      }
  }
} // namespace feib
