// SPDX-License-Identifier: LGPL-2.1-or-later
#include "time_series.h"

#include <feib/error.h>
#include <feib/message.h>
#include <feib/text_file.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace feib
{
  namespace
  {
    /// A line has one kind of separator: with semicolons or tabs, a comma is part of a field, and
    /// no number has one.
    std::vector<std::string>
    fields(std::string line)
    {
      if (!line.empty() && line.back() == '\r')
        line.pop_back();
      char separator = ' ';
      for (const char c : {',', '\t', ';'})
        if (line.find(c) != std::string::npos)
          separator = c;
      std::vector<std::string> result;
      std::istringstream stream(line);
      std::string field;
      while (separator == ' ' ? bool(stream >> field)
                              : bool(std::getline(stream, field, separator)))
        {
          const auto first = field.find_first_not_of(" \""), last = field.find_last_not_of(" \"");
          result.push_back(first == std::string::npos ? "" : field.substr(first, last - first + 1));
        }
      return result;
    }


    bool
    is_number(const std::string &text, double &value)
    {
      char *end = nullptr;
      value     = std::strtod(text.c_str(), &end);
      return !text.empty() && *end == 0 && std::isfinite(value);
    }


    /// Whether a row is one of names; a number with a slip of the pen is none.
    bool
    is_name(const std::string &text)
    {
      return text.find_first_of("0123456789+-.,") != 0;
    }
  } // namespace


  TimeSeries::TimeSeries(const std::string &file,
                         const std::string &column,
                         const bool repeats,
                         const MPI_Comm communicator)
    : repeats(repeats)
  {
    const std::string named = "the file \"" + readable(file) + "\"";
    std::string content     = read_text_file(file, named, true, communicator);
    if (content.rfind("\xEF\xBB\xBF", 0) == 0) // that spreadsheets put before UTF-8
      content.erase(0, 3);
    std::istringstream text(content);
    std::string line;
    std::size_t place   = 1;
    bool named_columns  = false;
    unsigned int number = 0;
    while (std::getline(text, line))
      {
        ++number;
        const std::vector<std::string> row = fields(line);
        if (row.empty() || row[0].rfind("#", 0) == 0 || (row.size() == 1 && row[0].empty()))
          continue;
        double time = 0, value = 0;
        const std::string where = named + ", line " + std::to_string(number) + ": ";
        if (times.empty() && !named_columns && is_name(row[0]))
          {
            named_columns = true;
            if (!column.empty())
              {
                place = std::find(row.begin(), row.end(), column) - row.begin();
                if (place == row.size() || place == 0)
                  throw Error(where + "no column of values is called \"" + readable(column) + "\"");
              }
            continue;
          }
        if (!column.empty() && !named_columns)
          throw Error(where + "there is no line of names, so no column \"" + readable(column) +
                      "\"");
        if (row.size() <= place)
          throw Error(where + "found " + std::to_string(row.size()) +
                      " columns; a time and a value are needed");
        if (!is_number(row[0], time) || !is_number(row[place], value))
          throw Error(where + "found \"" + readable(is_number(row[0], time) ? row[place] : row[0]) +
                      "\", a number is needed");
        if (!times.empty() && !(time > times.back()))
          throw Error(where + "the time " + readable(time) + " is not after " +
                      readable(times.back()));
        times.push_back(time);
        values.push_back(value);
      }
    if (times.size() < 2)
      throw Error(named + " has " + std::to_string(times.size()) +
                  " rows of numbers, at least 2 are needed");
    if (repeats && std::abs(values.front() - values.back()) >
                     1e-6 * (std::abs(values.front()) + std::abs(values.back())))
      throw Error(named + " begins with " + readable(values.front()) + " and ends with " +
                  readable(values.back()) + "; what repeats itself ends as it begins");
  }


  double
  TimeSeries::operator()(double t) const
  {
    if (repeats)
      {
        const double period = times.back() - times.front();
        t -= period * std::floor((t - times.front()) / period);
      }
    if (!(t > times.front()))
      return values.front();
    if (t >= times.back())
      return values.back();
    const std::size_t i = std::upper_bound(times.begin(), times.end(), t) - times.begin();
    const double share  = (t - times[i - 1]) / (times[i] - times[i - 1]);
    return (1 - share) * values[i - 1] + share * values[i];
  }
} // namespace feib
