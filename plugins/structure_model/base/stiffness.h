// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_structure_model_stiffness_h
#define feib_source_structure_model_stiffness_h

#include <feib/structure_model/face_loads.h>
#include <feib/structure_model.h>

namespace feib
{
  /// The largest eigenvalues of d2W/dF2 over elements with the gradients F.
  template <int structure_dim, int dim>
  typename StructureModel<dim>::Stiffness
  largest_stiffness(const std::vector<typename FaceLoads<structure_dim, dim>::Matrix> &F,
                    const typename FaceLoads<structure_dim, dim>::Columns &columns);
} // namespace feib

#endif
