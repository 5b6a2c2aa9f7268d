// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_structure_model_moments_h
#define feib_source_structure_model_moments_h

#include <feib/lagrangian_mesh.h>

#include <utility>

namespace feib
{
  /// The measure of a structure at X, or of what a closed curve or surface encloses, with the sign
  /// of its orientation, and its first moment about X[0].
  template <int structure_dim, int dim>
  std::pair<double, dealii::Tensor<1, dim>> moments(const LagrangianMesh<dim> &mesh,
                                                    const Positions<dim> &X);
} // namespace feib

#endif
