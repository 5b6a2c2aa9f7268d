// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_cross_product_h
#define feib_cross_product_h

#include <deal.II/base/tensor.h>

namespace feib
{
  /// x times v with all three components, of which in two dimensions only the third is not 0: the
  /// torque of a force v at x, or the angular momentum of a momentum v, about the origin.
  template <int dim>
  dealii::Tensor<1, 3>
  cross_product(const dealii::Tensor<1, dim> &x, const dealii::Tensor<1, dim> &v)
  {
    dealii::Tensor<1, 3> result;
    result[2] = x[0] * v[1] - x[1] * v[0];
    if constexpr (dim == 3)
      {
        result[0] = x[1] * v[2] - x[2] * v[1];
        result[1] = x[2] * v[0] - x[0] * v[2];
      }
    return result;
  }
} // namespace feib

#endif
