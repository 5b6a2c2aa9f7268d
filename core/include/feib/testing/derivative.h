// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_derivative_h
#define feib_testing_derivative_h

namespace feib::testing
{
  /// d/dh f(h) at h = 0 by central differences, extrapolated to order 6 (exact for polynomials of
  /// degree 6). f returns a double, a tensor, or anything else with + and *.
  template <typename Function>
  auto
  derivative(const Function &f, const double step = 1e-2)
  {
    const auto central = [&](const double h) { return (f(h) - f(-h)) * (.5 / h); };
    const auto d1 = central(step), d2 = central(step / 2), d4 = central(step / 4);
    const auto e1 = (d2 * 4. - d1) * (1. / 3), e2 = (d4 * 4. - d2) * (1. / 3);
    return (e2 * 16. - e1) * (1. / 15);
  }
} // namespace feib::testing

#endif
