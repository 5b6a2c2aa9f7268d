// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_table_writer_h
#define feib_table_writer_h

#include <feib/appended_file.h>
#include <feib/failure.h>
#include <feib/output_writer.h>

#include <deal.II/base/mpi.h>

#include <iomanip>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// A writer of one table, comma-separated values in a text file with the names of the columns in
  /// its first line, that grows with the run: write() calls append(). A run that is taken up goes
  /// on with it.
  template <int dim>
  class TableWriter : public OutputWriter<dim>
  {
  public:
    using Snapshot = typename OutputWriter<dim>::Snapshot;

    unsigned int
    interval() const override
    {
      return steps;
    }

    void
    archive(Archive &archive) override
    {
      archive("file", file);
    }

    void
    reopen(const std::string &directory, const MPI_Comm communicator) override
    {
      agree(communicator, [&] {
        if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
          file.reopen(directory + "/" + file_name);
      });
    }

  protected:
    /// @p file_name: within the folder of the results; @p interval: steps between calls of write().
    TableWriter(std::string file_name, const unsigned int interval)
      : file_name(std::move(file_name))
      , steps(interval)
    {}

    /// Adds rows, which rank 0 writes: all ranks call it, with the same @p columns every time.
    void
    append(const Snapshot &snapshot,
           const std::vector<std::string> &columns,
           const std::vector<std::vector<double>> &rows)
    {
      const MPI_Comm communicator = snapshot.space.communicator();
      agree(communicator, [&] {
        if (dealii::Utilities::MPI::this_mpi_process(communicator) != 0)
          return;
        if (!file.is_open())
          file.open(snapshot.directory + "/" + file_name, line(columns));
        std::string text;
        for (const std::vector<double> &row : rows)
          text += line(row);
        file.append(text);
      });
    }

  private:
    template <typename Entry>
    static std::string
    line(const std::vector<Entry> &entries)
    {
      std::ostringstream text;
      text << std::setprecision(17);
      for (std::size_t i = 0; i < entries.size(); ++i)
        text << (i > 0 ? "," : "") << entries[i];
      text << '\n';
      return text.str();
    }

    const std::string file_name;
    const unsigned int steps;
    AppendedFile file;
  };
} // namespace feib

#endif
