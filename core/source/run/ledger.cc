// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/ledger.h>

#include <algorithm>
#include <stdexcept>

namespace feib
{
  void
  Ledger::add(const Row &row)
  {
    if (rows.empty())
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
    rows.push_back(std::move(values));
  }


  const std::vector<std::string> &
  Ledger::columns() const
  {
    return names;
  }


  unsigned int
  Ledger::n_rows() const
  {
    return rows.size();
  }


  const std::vector<double> &
  Ledger::row(const unsigned int i) const
  {
    return rows.at(i);
  }


  double
  Ledger::value(const std::string &column, const unsigned int i) const
  {
    const auto place = std::find(names.begin(), names.end(), column);
    if (place == names.end())
      throw std::logic_error("the ledger has no column \"" + column + "\"");
    return rows.at(i)[place - names.begin()];
  }


  double
  Ledger::last(const std::string &column) const
  {
    if (rows.empty())
      throw std::logic_error("the ledger has no rows");
    return value(column, rows.size() - 1);
  }
} // namespace feib
