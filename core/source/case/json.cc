// SPDX-License-Identifier: LGPL-2.1-or-later
#include "json.h"

#include <feib/message.h>

#include <algorithm>
#include <numeric>

namespace feib
{
  std::string
  pointer_part(const std::string &key)
  {
    std::string part = "/";
    for (const char c : key)
      if (c == '~')
        part += "~0";
      else if (c == '/')
        part += "~1";
      else
        part += c;
    return part;
  }


  std::vector<std::string>
  pointer_parts(const std::string &pointer)
  {
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < pointer.size(); ++i)
      if (pointer[i] == '/')
        parts.emplace_back();
      else if (pointer[i] == '~' && i + 1 < pointer.size())
        parts.back() += pointer[++i] == '1' ? '/' : '~';
      else
        parts.back() += pointer[i];
    return parts;
  }


  std::string
  quoted(const std::string &name)
  {
    return "\"" + readable(name, 80) + "\"";
  }


  std::string
  quoted_list(const std::vector<std::string> &names)
  {
    std::string list;
    for (const std::string &name : names)
      {
        if (list.size() > 1000)
          return list + ", ...";
        list += (list.empty() ? "" : ", ") + quoted(name);
      }
    return list;
  }


  std::string
  nearest(const std::string &name, const std::vector<std::string> &names)
  {
    const auto simplified = [](std::string text) {
      std::transform(text.begin(), text.end(), text.begin(), [](const unsigned char c) {
        return c == '-' || c == ' ' ? '_' : std::tolower(c);
      });
      return text;
    };
    const auto distance = [](const std::string &a, const std::string &b) {
      std::vector<std::size_t> row(b.size() + 1);
      std::iota(row.begin(), row.end(), 0);
      for (std::size_t i = 0; i < a.size(); ++i)
        {
          std::size_t diagonal = row[0]++;
          for (std::size_t j = 0; j < b.size(); ++j)
            {
              const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
              diagonal                      = row[j + 1];
              row[j + 1]                    = std::min({substituted, row[j] + 1, row[j + 1] + 1});
            }
        }
      return row.back();
    };

    if (name.size() > 100)
      return "";
    std::string best;
    std::size_t best_distance = static_cast<std::size_t>(-1);
    for (const std::string &candidate : names)
      {
        const std::size_t d = distance(simplified(name), simplified(candidate));
        if (d < best_distance && 3 * d <= std::max(name.size(), candidate.size()))
          {
            best          = candidate;
            best_distance = d;
          }
      }
    return best;
  }


  std::optional<std::size_t>
  too_deep(const std::string &text)
  {
    constexpr unsigned int limit = 100;
    unsigned int depth           = 0;
    for (std::size_t i = 0; i < text.size(); ++i)
      if (text[i] == '"')
        for (++i; i < text.size() && text[i] != '"'; ++i)
          i += text[i] == '\\';
      else if (text.compare(i, 2, "//") == 0)
        i = std::min(text.find('\n', i), text.size());
      else if (text.compare(i, 2, "/*") == 0)
        i = std::min(text.find("*/", i + 2), text.size() - 1) + 1;
      else if ((text[i] == '[' || text[i] == '{') && ++depth > limit)
        return i;
      else if ((text[i] == ']' || text[i] == '}') && depth > 0)
        --depth;
    return {};
  }


  std::map<std::string, double>
  mathematical_constants()
  {
    return {{"pi", 3.14159265358979323846}, {"e", 2.71828182845904523536}};
  }
} // namespace feib
