// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/table_writer.h>

#include "ledger_csv_schema.h"

namespace
{
  template <int dim>
  class LedgerCsv : public feib::TableWriter<dim>
  {
  public:
    using Snapshot = typename feib::TableWriter<dim>::Snapshot;

    explicit LedgerCsv(const feib::Parameters &parameters)
      : feib::TableWriter<dim>("ledger.csv", parameters.integer("interval"))
    {}

    /// Appends the last row of the ledger, unless it has been written.
    void
    write(const Snapshot &snapshot) override
    {
      const feib::Ledger &ledger = snapshot.ledger;
      if (ledger.n_rows() == rows_seen)
        return;
      rows_seen = ledger.n_rows();
      this->append(snapshot, ledger.columns(), {ledger.last_row()});
    }

    void
    archive(feib::Archive &archive) override
    {
      feib::TableWriter<dim>::archive(archive);
      archive("rows_seen", rows_seen);
    }

  private:
    unsigned int rows_seen = 0;
  };
} // namespace


FEIB_PLUGIN("ledger_csv", "1.0", registry)
{
  registry.add<feib::OutputWriter, LedgerCsv>("ledger_csv", ledger_csv_schema);
}
