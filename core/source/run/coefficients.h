// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_coefficients_h
#define feib_coefficients_h

#include <feib/parameters.h>

#include <deal.II/base/tensor.h>

namespace feib
{
  /// Drag and lift coefficients, by the reference velocity and length of a case: the force of the
  /// fluid on a body over density/2 velocity^2 times the length (in 3D an area), along the flow and
  /// across.
  template <int dim>
  struct Coefficients
  {
    /// From the block "coefficients". Throws Error.
    Coefficients(const Parameters &parameters, double density);

    /// Of the force that the fluid gets.
    double
    drag(const dealii::Tensor<1, dim> &force) const
    {
      return -(force * flow) / reference_force;
    }
    double
    lift(const dealii::Tensor<1, dim> &force) const
    {
      return -(force * across) / reference_force;
    }

    /// The Strouhal number of a frequency.
    double
    strouhal(const double frequency) const
    {
      return frequency * length / velocity;
    }

    double velocity, length, reference_force;
    dealii::Tensor<1, dim> flow, across; // unit vectors
  };
} // namespace feib

#endif
