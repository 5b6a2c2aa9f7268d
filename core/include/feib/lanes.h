// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_lanes_h
#define feib_lanes_h

#include <deal.II/base/config.h>

#include <cmath>

namespace feib
{
  /// Eight numbers, one of each material point that is worked on at once, as the compiler's vector.
  /// A double stands for eight equal ones.
  class Lanes
  {
  public:
    static constexpr unsigned int n = 8;

    Lanes() = default;

    Lanes(const double value)
      : values(Values{} + value)
    {}

    double
    operator[](const unsigned int lane) const
    {
      return values[lane];
    }

    void
    set(const unsigned int lane, const double value)
    {
      values[lane] = value;
    }

    DEAL_II_ALWAYS_INLINE Lanes &
    operator+=(const Lanes &b)
    {
      values += b.values;
      return *this;
    }

    DEAL_II_ALWAYS_INLINE Lanes &
    operator-=(const Lanes &b)
    {
      values -= b.values;
      return *this;
    }

    DEAL_II_ALWAYS_INLINE Lanes &
    operator*=(const Lanes &b)
    {
      values *= b.values;
      return *this;
    }

    DEAL_II_ALWAYS_INLINE Lanes &
    operator/=(const Lanes &b)
    {
      values /= b.values;
      return *this;
    }

    friend DEAL_II_ALWAYS_INLINE Lanes
    operator+(Lanes a, const Lanes &b)
    {
      return a += b;
    }

    friend DEAL_II_ALWAYS_INLINE Lanes
    operator-(Lanes a, const Lanes &b)
    {
      return a -= b;
    }

    friend DEAL_II_ALWAYS_INLINE Lanes
    operator*(Lanes a, const Lanes &b)
    {
      return a *= b;
    }

    friend DEAL_II_ALWAYS_INLINE Lanes
    operator/(Lanes a, const Lanes &b)
    {
      return a /= b;
    }

    friend DEAL_II_ALWAYS_INLINE Lanes
    operator-(const Lanes &a)
    {
      return Lanes(0.) - a;
    }

    /// A function of each.
    template <typename Function>
    friend Lanes
    apply(const Function &function, const Lanes &x)
    {
      Lanes result;
      for (unsigned int lane = 0; lane < n; ++lane)
        result.values[lane] = function(x.values[lane]);
      return result;
    }

    friend Lanes
    exp(const Lanes &x)
    {
      return apply([](const double y) { return std::exp(y); }, x);
    }

    friend Lanes
    log(const Lanes &x)
    {
      return apply([](const double y) { return std::log(y); }, x);
    }

    friend Lanes
    sqrt(const Lanes &x)
    {
      return apply([](const double y) { return std::sqrt(y); }, x);
    }

    friend Lanes
    pow(const Lanes &x, const double p)
    {
      return apply([p](const double y) { return std::pow(y, p); }, x);
    }

    friend Lanes
    sin(const Lanes &x)
    {
      return apply([](const double y) { return std::sin(y); }, x);
    }

    friend Lanes
    cos(const Lanes &x)
    {
      return apply([](const double y) { return std::cos(y); }, x);
    }

    friend Lanes
    reciprocal(const Lanes &x)
    {
      return Lanes(1.) / x;
    }

    /// 1 where x > 0, else 0.
    friend Lanes
    step(const Lanes &x)
    {
      return apply([](const double y) { return y > 0 ? 1. : 0.; }, x);
    }

    /// The larger of x and 0: what a fibre feels that bears no compression.
    friend Lanes
    positive_part(const Lanes &x)
    {
      return apply([](const double y) { return y > 0 ? y : 0.; }, x);
    }

  private:
    typedef double Values __attribute__((vector_size(8 * n)));

    Values values;
  };
} // namespace feib

#endif
