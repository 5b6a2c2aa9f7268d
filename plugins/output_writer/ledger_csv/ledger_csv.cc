// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/output_writer.h>
#include <feib/plugin.h>

#include <deal.II/base/mpi.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iomanip>

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
      const bool first            = rows_seen == 0;
      const MPI_Comm communicator = snapshot.space.communicator();
      rows_seen                   = ledger.n_rows();

      std::string trouble;
      if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
        {
          const std::string name = snapshot.directory + "/ledger.csv";
          errno                  = 0;
          if (first)
            {
              file.open(name);
              file << std::setprecision(17);
              write_row(ledger.columns());
            }
          write_row(ledger.row(rows_seen - 1));
          file.flush();
          if (!file)
            trouble =
              "cannot write " + name + (errno ? std::string(": ") + std::strerror(errno) : "");
        }
      trouble = dealii::Utilities::MPI::broadcast(communicator, trouble, 0);
      if (!trouble.empty())
        throw feib::RunFailure(trouble);
    }

  private:
    template <typename Entry>
    void
    write_row(const std::vector<Entry> &entries)
    {
      for (std::size_t i = 0; i < entries.size(); ++i)
        file << (i > 0 ? "," : "") << entries[i];
      file << '\n';
    }

    const unsigned int steps;
    unsigned int rows_seen = 0;
    std::ofstream file;
  };
} // namespace


FEIB_PLUGIN("ledger_csv", "1.0", registry)
{
  registry.add<feib::OutputWriter, LedgerCsv>("ledger_csv", ledger_csv_schema);
}
