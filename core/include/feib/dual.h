// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_dual_h
#define feib_dual_h

#include <feib/lanes.h>

#include <array>

namespace feib
{
  /// A value with its derivatives in n directions, which arithmetic and functions carry along
  /// (forward automatic differentiation; Griewank and Walther 2008, chapter 3). Dual numbers of
  /// dual numbers have second derivatives. The innermost numbers are Lanes.
  template <int n, typename Scalar>
  struct Dual
  {
    Scalar value;
    std::array<Scalar, n> slope;

    Dual() = default;

    Dual(const Lanes &constant)
      : value(constant)
    {
      slope.fill(Scalar(Lanes(0.)));
    }

    /// f of @p x, given the value of f there and of its derivative.
    static DEAL_II_ALWAYS_INLINE Dual
    chain(const Dual &x, const Scalar &value, const Scalar &derivative)
    {
      Dual result;
      result.value = value;
#pragma GCC unroll 16
      for (int i = 0; i < n; ++i)
        result.slope[i] = derivative * x.slope[i];
      return result;
    }

    DEAL_II_ALWAYS_INLINE Dual &
    operator+=(const Dual &b)
    {
      value += b.value;
#pragma GCC unroll 16
      for (int i = 0; i < n; ++i)
        slope[i] += b.slope[i];
      return *this;
    }

    DEAL_II_ALWAYS_INLINE Dual &
    operator-=(const Dual &b)
    {
      value -= b.value;
#pragma GCC unroll 16
      for (int i = 0; i < n; ++i)
        slope[i] -= b.slope[i];
      return *this;
    }

    DEAL_II_ALWAYS_INLINE Dual &
    operator*=(const Dual &b)
    {
#pragma GCC unroll 16
      for (int i = 0; i < n; ++i)
        slope[i] = slope[i] * b.value + value * b.slope[i];
      value *= b.value;
      return *this;
    }

    DEAL_II_ALWAYS_INLINE Dual &
    operator+=(const Lanes &b)
    {
      value += b;
      return *this;
    }

    DEAL_II_ALWAYS_INLINE Dual &
    operator*=(const Lanes &b)
    {
      value *= b;
#pragma GCC unroll 16
      for (int i = 0; i < n; ++i)
        slope[i] *= b;
      return *this;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator+(Dual a, const Dual &b)
    {
      return a += b;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator-(Dual a, const Dual &b)
    {
      return a -= b;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator*(Dual a, const Dual &b)
    {
      return a *= b;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator/(const Dual &a, const Dual &b)
    {
      return a * reciprocal(b);
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator-(const Dual &a)
    {
      return a * Lanes(-1.);
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator+(Dual a, const Lanes &b)
    {
      return a += b;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator+(const Lanes &a, Dual b)
    {
      return b += a;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator-(Dual a, const Lanes &b)
    {
      return a += Lanes(-1.) * b;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator-(const Lanes &a, const Dual &b)
    {
      return b * Lanes(-1.) + a;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator*(Dual a, const Lanes &b)
    {
      return a *= b;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator*(const Lanes &a, Dual b)
    {
      return b *= a;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator/(Dual a, const Lanes &b)
    {
      return a *= Lanes(1.) / b;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    operator/(const Lanes &a, const Dual &b)
    {
      return reciprocal(b) * a;
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    reciprocal(const Dual &x)
    {
      const Scalar inverse = Lanes(1.) / x.value;
      return chain(x, inverse, Lanes(-1.) * inverse * inverse);
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    exp(const Dual &x)
    {
      const Scalar value = exp(x.value);
      return chain(x, value, value);
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    log(const Dual &x)
    {
      return chain(x, log(x.value), Lanes(1.) / x.value);
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    sqrt(const Dual &x)
    {
      const Scalar value = sqrt(x.value);
      return chain(x, value, Lanes(.5) / value);
    }

    /// x to a constant power.
    friend DEAL_II_ALWAYS_INLINE Dual
    pow(const Dual &x, const double p)
    {
      const Scalar below = pow(x.value, p - 1);
      return chain(x, below * x.value, Lanes(p) * below);
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    sin(const Dual &x)
    {
      return chain(x, sin(x.value), cos(x.value));
    }

    friend DEAL_II_ALWAYS_INLINE Dual
    cos(const Dual &x)
    {
      return chain(x, cos(x.value), Lanes(-1.) * sin(x.value));
    }

    /// The larger of x and 0: what a fibre feels that bears no compression.
    friend DEAL_II_ALWAYS_INLINE Dual
    positive_part(const Dual &x)
    {
      return chain(x, positive_part(x.value), step(x.value));
    }

    /// 1 where x > 0, else 0.
    friend DEAL_II_ALWAYS_INLINE Dual
    step(const Dual &x)
    {
      Dual result(Lanes(0.));
      result.value = step(x.value);
      return result;
    }
  };
} // namespace feib

#endif
