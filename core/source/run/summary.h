// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_summary_h
#define feib_summary_h

#include "accounts.h"
#include "json.h"

namespace feib
{
  /// How a run went, beside its accounts.
  struct RunRecord
  {
    unsigned int step      = 0;
    double time            = 0;
    double wall_seconds    = 0;
    double stability_limit = std::numeric_limits<double>::infinity(); // before the first step
    unsigned int retries   = 0;
    unsigned int remeshes  = 0; // changes of the mesh, and what they took
    double remesh_seconds  = 0;
    std::vector<double> step_seconds;
  };

  /// What summary.json says of a run beside its verdict. Collective.
  template <int dim>
  Json summary(const Components<dim> &components,
               const Accounts<dim> &accounts,
               const RunRecord &record);
} // namespace feib

#endif
