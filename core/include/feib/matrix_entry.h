// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_matrix_entry_h
#define feib_matrix_entry_h

#include <cstdint>
#include <vector>

namespace feib
{
  /// An entry of a sparse matrix. Entries of the same place add up, over all ranks.
  struct MatrixEntry
  {
    std::uint64_t row, column;
    double value;
  };

  using MatrixEntries = std::vector<MatrixEntry>;
} // namespace feib

#endif
