// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_appended_file_h
#define feib_appended_file_h

#include <feib/archive.h>

#include <memory>
#include <string>

namespace feib
{
  /// A text file that grows during a run, and that a continued run goes on with where the archived
  /// state left it. Its functions are for one rank; they throw RunFailure.
  class AppendedFile
  {
  public:
    bool
    is_open() const
    {
      return descriptor != nullptr;
    }

    /// Makes the file, or makes it anew.
    void open(const std::string &name, const std::string &head);

    /// Adds a text, in one piece. @p tail stands after it until more is added.
    void append(const std::string &text, const std::string &tail = "");

    /// After archive() has read: opens the file, without what was added to it later.
    void reopen(const std::string &name, const std::string &tail = "");

    /// How long the file is, without its tail.
    void
    archive(Archive &archive)
    {
      archive("length", length);
    }

  private:
    void write(const std::string &text);

    std::string name;
    std::shared_ptr<const int> descriptor; // closed with its last copy
    std::uint64_t length = 0;              // bytes
  };
} // namespace feib

#endif
