// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/message.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace feib
{
  namespace
  {
    /// The character of UTF-8 that begins at @p at: its code and bytes; no bytes when it is none.
    std::pair<unsigned long, unsigned int>
    character(const std::string &text, const std::size_t at)
    {
      const unsigned char first = text[at];
      if (first < 0x80)
        return {first, 1};
      const unsigned int n = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
      if (n == 0 || at + n > text.size())
        return {0, 0};
      unsigned long code = first & (0xFF >> (n + 1));
      for (unsigned int i = 1; i < n; ++i)
        {
          const unsigned char next = text[at + i];
          if ((next & 0xC0) != 0x80)
            return {0, 0};
          code = code << 6 | (next & 0x3F);
        }
      const unsigned long least[] = {0, 0, 0x80, 0x800, 0x10000};
      const bool valid = code >= least[n] && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF);
      return valid ? std::make_pair(code, n) : std::make_pair(0ul, 0u);
    }


    /// Controls, and the marks that turn the direction of what is written.
    bool
    acts(const unsigned long code)
    {
      return code < 0x20 || (code >= 0x7F && code < 0xA0) || (code >= 0x200E && code <= 0x200F) ||
             (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069) ||
             code == 0xFEFF;
    }
  } // namespace


  std::string
  readable(const double number)
  {
    char text[40];
    for (int digits = 1; digits <= 9; ++digits)
      {
        std::snprintf(text, sizeof text, "%.*g", digits, number);
        if (std::strtod(text, nullptr) == number)
          return text;
      }
    std::snprintf(text, sizeof text, "%.6g", number);
    return text;
  }


  std::string
  percent(const double part)
  {
    const double value = 100 * part;
    char text[40];
    // Two digits of large numbers would need an exponent.
    std::snprintf(text, sizeof text, std::abs(value) < 99.5 ? "%.2g %%" : "%.0f %%", value);
    return text;
  }


  std::string
  readable(const std::string &text, const std::size_t length)
  {
    std::string result;
    for (std::size_t at = 0; at < text.size();)
      {
        const auto [code, bytes] = character(text, at);
        if (at + std::max(bytes, 1u) > length)
          return result + "...";
        char escaped[24];
        if (bytes == 0)
          std::snprintf(escaped, sizeof escaped, "\\x%02x", text[at] & 0xFF);
        else if (acts(code))
          std::snprintf(escaped, sizeof escaped, "\\u%04lx", code);
        result += bytes == 0 || acts(code) ? escaped : text.substr(at, bytes);
        at += std::max(bytes, 1u);
      }
    return result;
  }


  std::string
  readable_lines(const std::string &text)
  {
    std::string result;
    for (std::size_t start = 0; start < text.size();)
      {
        const std::size_t end = std::min(text.find('\n', start), text.size());
        result += readable(text.substr(start, end - start)) + (end < text.size() ? "\n" : "");
        start = end + 1;
      }
    return result;
  }
} // namespace feib
