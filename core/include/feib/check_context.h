// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_check_context_h
#define feib_check_context_h

#include <feib/immersed_structure.h>

#include <vector>

namespace feib
{
  /// What components check themselves against before a run (their function check()): what a schema
  /// cannot say and a constructor cannot see.
  template <int dim>
  struct CheckContext
  {
    const EulerianSpace<dim> &space; // with the first mesh
    const std::vector<ImmersedStructure<dim>> &structures;
    std::vector<double> times; // where functions of the time are tried: 0, the end, some between
  };
} // namespace feib

#endif
