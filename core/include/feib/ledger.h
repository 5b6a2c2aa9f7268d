// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_ledger_h
#define feib_ledger_h

#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// The accounts of a run: one row per step, the same columns in every row, all rows kept.
  class Ledger
  {
  public:
    using Row = std::vector<std::pair<std::string, double>>;

    /// Adds a row. The first row fixes the names and the order of the columns; a later row with
    /// other names is a programmer's error (std::logic_error).
    void add(const Row &row);

    const std::vector<std::string> &columns() const;

    unsigned int n_rows() const;

    /// The values of row @p i in the order of columns().
    const std::vector<double> &row(unsigned int i) const;

    /// The value of a column in row @p i.
    double value(const std::string &column, unsigned int i) const;

    /// The value of a column in the last row.
    double last(const std::string &column) const;

  private:
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;
  };
} // namespace feib

#endif
