// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/ledger.h>

#include <algorithm>
#include <stdexcept>

namespace feib
{
  void
  Ledger::add(const Row &row)
  {
    if (count == 0)
      for (const auto &[name, value] : row)
        {
          if (std::find(names.begin(), names.end(), name) != names.end())
            throw std::logic_error("the ledger has two columns \"" + name + "\"");
          names.push_back(name);
        }
    if (row.size() != names.size())
      throw std::logic_error("a row of the ledger has " + std::to_string(row.size()) +
                             " columns instead of " + std::to_string(names.size()));
    std::vector<double> values;
    for (std::size_t i = 0; i < row.size(); ++i)
      {
        if (row[i].first != names[i])
          throw std::logic_error("column \"" + row[i].first + "\" of the ledger used to be \"" +
                                 names[i] + "\"");
        values.push_back(row[i].second);
      }
    if (count == 0)
      first_row = values;
    newest_row = std::move(values);
    ++count;
  }


  const std::vector<std::string> &
  Ledger::columns() const
  {
    return names;
  }


  unsigned int
  Ledger::n_rows() const
  {
    return count;
  }


  const std::vector<double> &
  Ledger::last_row() const
  {
    return newest_row;
  }


  std::size_t
  Ledger::place(const std::string &column) const
  {
    if (count == 0)
      throw std::logic_error("the ledger has no rows");
    const auto found = std::find(names.begin(), names.end(), column);
    if (found == names.end())
      throw std::logic_error("the ledger has no column \"" + column + "\"");
    return found - names.begin();
  }


  double
  Ledger::first(const std::string &column) const
  {
    return first_row[place(column)];
  }


  double
  Ledger::last(const std::string &column) const
  {
    return newest_row[place(column)];
  }


  void
  Ledger::archive(Archive &archive)
  {
    archive("columns", names);
    archive("first", first_row);
    archive("last", newest_row);
    archive("count", count);
  }
} // namespace feib
