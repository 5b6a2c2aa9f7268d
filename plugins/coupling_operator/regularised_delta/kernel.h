// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_regularised_delta_kernel_h
#define feib_regularised_delta_kernel_h

#include <string>

namespace feib
{
  /// A kernel phi of one variable, in units of the lattice's spacing: even, not negative, zero
  /// where |r| >= radius() and nowhere else, and sum_j phi(r - j) = 1 over the integers j for every
  /// r.
  class Kernel
  {
  public:
    /// @p name: ib_3, ib_4, cosine or bspline_3 to bspline_6.
    explicit Kernel(const std::string &name);

    double
    radius() const
    {
      return half_width;
    }

    double operator()(double r) const;

  private:
    enum class Shape
    {
      ib_3,
      ib_4,
      cosine,
      bspline
    };

    Shape shape;
    unsigned int order; // of the B-spline: its width
    double half_width;
  };
} // namespace feib

#endif
