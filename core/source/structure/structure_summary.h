// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_summary_h
#define feib_structure_summary_h

#include "json.h"

#include <feib/structure_model.h>

namespace feib
{
  /// What summary.json says of a structure at its present positions, beside those at the start.
  /// @p leak and @p time_error: the parts of the change of its measure.
  template <int dim>
  Json structure_summary(const StructureModel<dim> &model, double leak, double time_error);
} // namespace feib

#endif
