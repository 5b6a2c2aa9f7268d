// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_forecast_h
#define feib_source_forecast_h

#include <feib/eulerian_space.h>
#include <feib/immersed_structure.h>

#include <string>
#include <vector>

namespace feib
{
  /// The times at which functions of the time are tried before a run: 0, the end and some between,
  /// at no simple fractions, where a periodic function might be zero.
  std::vector<double> sample_times(double end);

  /// Throws Error at @p pointer when a mesh of so many cells is beyond what is allowed, or needs
  /// more memory than the machines of the run have. Collective.
  template <int dim>
  void check_size(double n_cells, const std::string &pointer, MPI_Comm communicator);

  /// Cells, unknowns, memory; of each structure its elements and their edges beside the cells'. One
  /// line each. Collective.
  template <int dim>
  std::string size_text(const EulerianSpace<dim> &space,
                        const std::vector<ImmersedStructure<dim>> &structures);
} // namespace feib

#endif
