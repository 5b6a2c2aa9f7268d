// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_ledger_h
#define feib_ledger_h

#include <feib/archive.h>

#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// The accounts of a run: one row per step, the same columns in every row. The first and the last
  /// row are kept.
  class Ledger
  {
  public:
    using Row = std::vector<std::pair<std::string, double>>;

    /// Adds a row. The first row fixes the names and the order of the columns; a later row with
    /// other names is a programmer's error (std::logic_error).
    void add(const Row &row);

    const std::vector<std::string> &columns() const;

    unsigned int n_rows() const;

    /// The values of the last row in the order of columns().
    const std::vector<double> &last_row() const;

    /// The value of a column in the first and in the last row.
    double first(const std::string &column) const;
    double last(const std::string &column) const;

    void archive(Archive &archive);

  private:
    std::size_t place(const std::string &column) const;

    std::vector<std::string> names;
    std::vector<double> first_row, newest_row;
    unsigned int count = 0;
  };
} // namespace feib

#endif
