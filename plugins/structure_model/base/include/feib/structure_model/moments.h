// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_model_moments_h
#define feib_structure_model_moments_h

#include <feib/lagrangian_mesh.h>

#include <deal.II/base/symmetric_tensor.h>

namespace feib
{
  /// Moments of a structure, or of what a closed curve or surface encloses, with the sign of its
  /// orientation; about X[0].
  template <int dim>
  struct Moments
  {
    double measure = 0; // set to 0 where it is 0 but for round-off
    dealii::Tensor<1, dim> first;
    dealii::SymmetricTensor<2, dim> second;
  };

  template <int structure_dim, int dim>
  Moments<dim> moments(const LagrangianMesh<dim> &mesh, const Positions<dim> &X);
} // namespace feib

#endif
