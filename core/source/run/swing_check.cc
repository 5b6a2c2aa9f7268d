// SPDX-License-Identifier: LGPL-2.1-or-later
#include "swing_check.h"

#include <algorithm>

namespace feib
{
  namespace
  {
    constexpr double tolerated  = .1;
    constexpr unsigned int many = 20;

    template <class T>
    void
    push(std::deque<T> &values, const T &value, const unsigned int n)
    {
      values.push_front(value);
      if (values.size() > n)
        values.pop_back();
    }
  } // namespace


  void
  SwingCheck::Force::add(const dealii::Tensor<1, 3> &value, const double negligible)
  {
    push(past, value, 3);
    peak = std::max(.98 * peak, value.norm());
    if (past.size() < 3)
      return;
    // Of a swing of amplitude A and P steps A sin^2(pi/P); of one component it vanishes now and
    // then.
    push(rough, (past[0] - 2. * past[1] + past[2]).norm() / 4, 3);
    amplitude = *std::max_element(rough.begin(), rough.end());
    steps     = amplitude > std::max(tolerated * peak, negligible) ? steps + 1 : 0;
  }


  void
  SwingCheck::add(const Ledger &ledger, const double negligible)
  {
    const std::vector<std::string> &columns = ledger.columns();
    const std::vector<double> &row          = ledger.last_row();
    const auto is_component                 = [&](const std::size_t i, const unsigned int a) {
      return i < columns.size() && columns[i].rfind(std::string("force_") + "xyz"[a] + "_", 0) == 0;
    };
    std::size_t n = 0;
    for (std::size_t i = 0; i < columns.size(); ++i)
      if (is_component(i, 0))
        {
          if (n == forces.size())
            {
              forces.emplace_back();
              forces.back().name = columns[i].substr(std::string("force_x_").size());
            }
          dealii::Tensor<1, 3> value;
          for (unsigned int a = 0; a < 3 && is_component(i + a, a); ++a)
            value[a] = row[i + a];
          forces[n++].add(value, negligible);
        }
  }


  SwingCheck::Worst
  SwingCheck::worst() const
  {
    Worst result;
    double largest = 0;
    for (const Force &force : forces)
      if (force.steps >= many && force.amplitude > largest)
        {
          largest = force.amplitude;
          result  = {force.amplitude / force.peak, force.name};
        }
    return result;
  }
} // namespace feib
