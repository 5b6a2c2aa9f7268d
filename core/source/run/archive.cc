// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/archive.h>

#include <stdexcept>

namespace feib
{
  void
  Archive::check_size(const std::string &bytes, const std::size_t size) const
  {
    if (bytes.size() != size)
      throw RunFailure("the state \"" + path + "\" has " + std::to_string(bytes.size()) +
                       " bytes instead of " + std::to_string(size));
  }


  MemoryArchive::MemoryArchive()
    : Archive(false)
  {}


  void
  MemoryArchive::start_writing()
  {
    is_reading = false;
  }


  void
  MemoryArchive::start_reading()
  {
    is_reading = true;
  }


  std::any *
  MemoryArchive::slot()
  {
    if (is_reading && values.count(path) == 0)
      throw RunFailure("there is no state \"" + path + "\"");
    return &values[path];
  }


  bool
  MemoryArchive::contains(const std::string &place) const
  {
    return values.count(place) > 0;
  }


  void
  MemoryArchive::write(const std::string &)
  {
    throw std::logic_error("memory keeps values, not bytes");
  }


  std::string
  MemoryArchive::read()
  {
    throw std::logic_error("memory keeps values, not bytes");
  }


  void
  MemoryArchive::field(Vector &)
  {
    throw std::logic_error("memory keeps values, not bytes");
  }
} // namespace feib
