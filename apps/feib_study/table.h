// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_study_table_h
#define feib_study_table_h

#include "runs.h"

namespace feib
{
  /// A table of numbers and texts.
  class Table
  {
  public:
    /// The results of a study: axes, limit of the bisection, status, columns with their rates.
    Table(const Study &study, const std::vector<Combination> &combinations);

    /// For people: title, aligned columns, numbers in the formats of the columns.
    std::string markdown() const;

    /// For programs (RFC 4180): numbers with all digits.
    std::string csv() const;

  private:
    struct TableColumn
    {
      std::string name, format;
      std::vector<Json> cells; // number, text, or null for an empty cell
    };

    std::string title;
    std::vector<TableColumn> columns;
  };
} // namespace feib

#endif
