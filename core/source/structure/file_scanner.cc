// SPDX-License-Identifier: LGPL-2.1-or-later
#include "file_scanner.h"

#include <feib/error.h>
#include <feib/message.h>

#include <cctype>
#include <cmath>
#include <cstdlib>

namespace feib
{
  FileScanner::FileScanner(const std::string &name, const std::string_view text)
    : name(name)
    , text(text)
  {}


  void
  FileScanner::fail(const std::string &message) const
  {
    throw Error("file \"" + name + "\", " +
                (binary ? "byte " + std::to_string(at) : "line " + std::to_string(line)) + ": " +
                message);
  }


  bool
  FileScanner::find_word()
  {
    for (; at < text.size() && std::isspace(static_cast<unsigned char>(text[at])); ++at)
      line += text[at] == '\n';
    return at < text.size();
  }


  std::string_view
  FileScanner::word()
  {
    if (!find_word())
      fail("the file ends inside " + section);
    const std::size_t begin = at;
    while (at < text.size() && !std::isspace(static_cast<unsigned char>(text[at])))
      ++at;
    return text.substr(begin, at - begin);
  }


  bool
  FileScanner::find(const std::string_view expected)
  {
    if (!find_word() || text.substr(at, expected.size()) != expected)
      return false;
    at += expected.size();
    return true;
  }


  std::string_view
  FileScanner::rest_of_line()
  {
    const std::size_t begin = at;
    at                      = std::min(text.find('\n', at), text.size());
    return text.substr(begin, at - begin);
  }


  std::string_view
  FileScanner::next_line()
  {
    const std::string_view result = rest_of_line();
    if (at < text.size())
      {
        ++at;
        ++line;
      }
    return result;
  }


  void
  FileScanner::end_line()
  {
    const std::string_view rest = rest_of_line();
    if (rest.find_first_not_of(" \t\r") != rest.npos)
      fail("found " + quoted(rest) + " in " + section + " where the line should end");
    if (at == text.size())
      fail("the file ends inside " + section);
    ++at;
    ++line;
  }


  double
  FileScanner::real(const bool finite)
  {
    const std::string copy(word());
    char *end          = nullptr;
    const double value = std::strtod(copy.c_str(), &end);
    if (end != copy.c_str() + copy.size() || (finite && !std::isfinite(value)))
      fail("found " + quoted(copy) + " in " + section + " where a " + (finite ? "finite " : "") +
           "number is expected");
    return value;
  }


  std::string_view
  FileScanner::take(const std::size_t n, const std::size_t size)
  {
    if (n > (text.size() - at) / size)
      fail("the file ends inside " + section);
    const std::string_view result = text.substr(at, n * size);
    at += n * size;
    return result;
  }


  void
  FileScanner::skip_words(const std::size_t n)
  {
    for (std::size_t i = 0; i < n; ++i)
      word();
  }


  void
  FileScanner::skip_to(const std::string &mark)
  {
    const std::size_t found = text.find(mark, at);
    if (found == text.npos)
      fail("the file ends inside " + section);
    at = found + mark.size();
  }


  std::string
  FileScanner::quoted(const std::string_view found)
  {
    return '"' + readable(std::string(found), 30) + '"';
  }
} // namespace feib
