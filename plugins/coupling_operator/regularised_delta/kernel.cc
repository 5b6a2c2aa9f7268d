// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kernel.h"

#include <deal.II/base/numbers.h>

#include <cmath>
#include <stdexcept>

namespace feib
{
  namespace
  {
    /// The B-spline of degree n - 1 and width n, for r >= 0, by truncated powers.
    double
    bspline(const double r, const unsigned int n)
    {
      double sum = 0, coefficient = 1; // (-1)^k n (n-1) ... / k!, over (n-1)!
      for (unsigned int k = 1; k < n; ++k)
        coefficient /= k;
      double x = n / 2. - r;
      for (unsigned int k = 0; x > 0; ++k, --x)
        {
          double power = coefficient;
          for (unsigned int i = 1; i < n; ++i)
            power *= x;
          sum += power;
          coefficient *= -double(n - k) / (k + 1);
        }
      return sum;
    }
  } // namespace


  Kernel::Kernel(const std::string &name)
    : order(0)
    , half_width(2)
  {
    if (name == "ib_3")
      {
        shape      = Shape::ib_3;
        half_width = 1.5;
      }
    else if (name == "ib_4")
      shape = Shape::ib_4;
    else if (name == "cosine")
      shape = Shape::cosine;
    else if (name.rfind("bspline_", 0) == 0)
      {
        shape      = Shape::bspline;
        order      = std::stoul(name.substr(8));
        half_width = order / 2.;
      }
    else
      throw std::logic_error("there is no kernel " + name);
  }


  double
  Kernel::operator()(const double signed_r) const
  {
    const double r = std::abs(signed_r);
    if (r >= half_width)
      return 0;
    switch (shape)
      {
        case Shape::ib_3:
          return r < .5 ? (1 + std::sqrt(1 - 3 * r * r)) / 3
                        : (5 - 3 * r - std::sqrt(1 - 3 * (1 - r) * (1 - r))) / 6;
        case Shape::ib_4:
          return r < 1 ? (3 - 2 * r + std::sqrt(1 + 4 * r - 4 * r * r)) / 8
                       : (5 - 2 * r - std::sqrt(-7 + 12 * r - 4 * r * r)) / 8;
        case Shape::cosine:
          return (1 + std::cos(dealii::numbers::PI_2 * r)) / 4;
        case Shape::bspline:
          return bspline(r, order);
      }
    return 0;
  }
} // namespace feib
