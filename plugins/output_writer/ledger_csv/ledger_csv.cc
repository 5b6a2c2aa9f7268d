// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/appended_file.h>
#include <feib/failure.h>
#include <feib/output_writer.h>
#include <feib/plugin.h>

#include <deal.II/base/mpi.h>

#include <iomanip>
#include <sstream>

#include "ledger_csv_schema.h"

namespace
{
  template <int dim>
  class LedgerCsv : public feib::OutputWriter<dim>
  {
  public:
    using Snapshot = typename feib::OutputWriter<dim>::Snapshot;

    explicit LedgerCsv(const feib::Parameters &parameters)
      : steps(parameters.integer("interval"))
    {}

    unsigned int
    interval() const override
    {
      return steps;
    }

    /// Appends the last row of the ledger, unless it has been written.
    void
    write(const Snapshot &snapshot) override
    {
      const feib::Ledger &ledger = snapshot.ledger;
      if (ledger.n_rows() == rows_seen)
        return;
      const MPI_Comm communicator = snapshot.space.communicator();
      rows_seen                   = ledger.n_rows();

      feib::agree(communicator, [&] {
        if (dealii::Utilities::MPI::this_mpi_process(communicator) != 0)
          return;
        if (!file.is_open())
          file.open(snapshot.directory + "/" + file_name, text_of(ledger.columns()));
        file.append(text_of(ledger.last_row()));
      });
    }

    void
    archive(feib::Archive &archive) override
    {
      archive("rows_seen", rows_seen);
      archive("file", file);
    }

    void
    reopen(const std::string &directory) override
    {
      feib::agree(MPI_COMM_WORLD, [&] {
        if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
          file.reopen(directory + "/" + file_name);
      });
    }

  private:
    static constexpr const char *file_name = "ledger.csv";

    template <typename Entry>
    static std::string
    text_of(const std::vector<Entry> &entries)
    {
      std::ostringstream text;
      text << std::setprecision(17);
      for (std::size_t i = 0; i < entries.size(); ++i)
        text << (i > 0 ? "," : "") << entries[i];
      text << '\n';
      return text.str();
    }

    const unsigned int steps;
    unsigned int rows_seen = 0;
    feib::AppendedFile file;
  };
} // namespace


FEIB_PLUGIN("ledger_csv", "1.0", registry)
{
  registry.add<feib::OutputWriter, LedgerCsv>("ledger_csv", ledger_csv_schema);
}
