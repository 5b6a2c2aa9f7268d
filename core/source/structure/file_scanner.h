// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_file_scanner_h
#define feib_file_scanner_h

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <string>
#include <string_view>

namespace feib
{
  /// Goes through a file that holds text, and binary numbers between. No count is believed: a file
  /// that is shorter than it says ends in an Error, which all functions throw with file and place.
  class FileScanner
  {
  public:
    /// @p name: for messages. @p text must outlive the scanner.
    FileScanner(const std::string &name, std::string_view text);

    [[noreturn]] void fail(const std::string &message) const;

    /// Goes to the next word; whether there is one.
    bool find_word();

    std::string_view word();

    /// Goes behind the next word if it is this one; whether it is.
    bool find(std::string_view expected);

    /// The rest of the line, without its end.
    std::string_view rest_of_line();

    /// The same, going to the next line; empty at the end of the file.
    std::string_view next_line();

    /// Goes to the next line, where binary numbers begin.
    void end_line();

    /// A word that is a number.
    template <typename T>
    T
    number(const char *const what)
    {
      const std::string_view found = word();
      T value{};
      const auto [end, problem] = std::from_chars(found.data(), found.data() + found.size(), value);
      if (problem != std::errc() || end != found.data() + found.size())
        fail("found " + quoted(found) + " in " + section + " where " + what + " is expected");
      return value;
    }

    /// A word that is a number; NaN and infinity are numbers that are not finite.
    double real(bool finite = true);

    /// The bytes of a number.
    template <typename T>
    T
    item()
    {
      std::array<char, sizeof(T)> bytes;
      const std::string_view found = take(1, sizeof(T));
      std::copy(found.begin(), found.end(), bytes.begin());
      if (swapped)
        std::reverse(bytes.begin(), bytes.end());
      T value;
      std::memcpy(&value, bytes.data(), sizeof(T));
      return value;
    }

    /// @p n times @p size bytes.
    std::string_view take(std::size_t n, std::size_t size);

    void skip_words(std::size_t n);

    /// Goes to the first place from here on where @p mark stands, and behind it.
    void skip_to(const std::string &mark);

    static std::string quoted(std::string_view found);

    std::string section = "the file"; // for messages
    std::size_t line    = 1;
    bool binary         = false; // then places are bytes, not lines
    bool swapped        = false; // the bytes of numbers, against those of this machine

  private:
    const std::string name;
    const std::string_view text;
    std::size_t at = 0;
  };
} // namespace feib

#endif
