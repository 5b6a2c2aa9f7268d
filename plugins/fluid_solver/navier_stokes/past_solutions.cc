// SPDX-License-Identifier: LGPL-2.1-or-later
#include "past_solutions.h"

namespace feib
{
  template <int dim>
  void
  PastSolutions<dim>::guess(EulerianSpace<dim> &space, const double new_time) const
  {
    if (provisional)
      return;
    // Far from solutions close to each other a polynomial is no guess.
    constexpr double farthest = 3;
    const auto time           = [&](const unsigned int i) { return solutions[i]->time; };
    unsigned int n_used       = 1;
    while (n_used < solutions.size() &&
           new_time - time(0) < farthest * (time(n_used - 1) - time(n_used)))
      ++n_used;
    if (solutions.empty() || n_used < 2)
      return;
    space.velocity = 0.;
    space.pressure = 0.;
    for (unsigned int i = 0; i < n_used; ++i)
      {
        double weight = 1; // Lagrange's polynomials at the new time
        for (unsigned int j = 0; j < n_used; ++j)
          if (j != i)
            weight *= (new_time - time(j)) / (time(i) - time(j));
        space.velocity.add(weight, solutions[i]->velocity);
        space.pressure.add(weight, solutions[i]->pressure);
      }
  }


  template <int dim>
  void
  PastSolutions<dim>::keep(const EulerianSpace<dim> &space, const double time)
  {
    provisional = std::make_shared<const Solution>(Solution{time, space.velocity, space.pressure});
  }


  template <int dim>
  void
  PastSolutions<dim>::commit()
  {
    constexpr unsigned int n_kept = 3;
    if (provisional)
      solutions.push_front(std::move(provisional));
    provisional.reset();
    if (solutions.size() > n_kept)
      solutions.pop_back();
  }


  template <int dim>
  void
  PastSolutions<dim>::forget()
  {
    solutions.clear();
    provisional.reset();
  }


  template <int dim>
  void
  PastSolutions<dim>::archive(Archive &archive)
  {
    archive("solutions", solutions);
    if (archive.reading())
      provisional.reset();
  }


  template class PastSolutions<2>;
  template class PastSolutions<3>;
} // namespace feib
