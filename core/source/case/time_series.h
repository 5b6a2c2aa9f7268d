// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_time_series_h
#define feib_source_time_series_h

#include <mpi.h>

#include <string>
#include <vector>

namespace feib
{
  /// A function given by its values at increasing times, straight between them; before the first
  /// and after the last it stays, or it repeats itself.
  class TimeSeries
  {
  public:
    /// From a text file: a column of times, and values from the column called @p column (the second
    /// when empty), separated by commas, semicolons, tabs or blanks; a line of names may come
    /// first, lines that begin with # are comments. Read by the first rank. Throws Error with the
    /// line that is wrong. Collective.
    TimeSeries(const std::string &file,
               const std::string &column,
               bool repeats,
               MPI_Comm communicator);

    double operator()(double t) const;

  private:
    const bool repeats;
    std::vector<double> times, values;
  };
} // namespace feib

#endif
