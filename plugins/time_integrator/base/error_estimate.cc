// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/time_integrator/error_estimate.h>

#include <algorithm>
#include <limits>

namespace feib
{
  namespace
  {
    template <int dim>
    double
    fluid_error(const EulerianSpace<dim> &space, const double dt)
    {
      // u_s less the extrapolation of u^n and u^{n-1} is tau (tau + old dt)/2 u''.
      if (!(space.old_dt > 0))
        return std::numeric_limits<double>::infinity();
      const double tau = dt / 2, ratio = tau / space.old_dt;
      VelocityVector difference = space.velocity;
      difference.zero_out_ghost_values();
      difference.add(-1 - ratio, space.old_velocity, ratio, space.older_velocity);
      return dt * dt * dt / 6 * difference.linfty_norm() / (tau * (tau + space.old_dt));
    }
  } // namespace


  template <int dim>
  double
  ErrorEstimate<dim>::add(const EulerianSpace<dim> &space,
                          const double time,
                          const double dt,
                          const std::vector<NodalField<dim>> &velocities)
  {
    if (velocities.empty())
      return fluid_error(space, dt);

    const double middle = time + dt / 2;
    double result       = std::numeric_limits<double>::infinity();
    if (past.size() >= 2)
      {
        const Motion &last = past.back(), &before = past[past.size() - 2];
        // Divided by (t - t_1)(t - t_2), the difference to the line through the past is u''/2.
        const double t_1 = last.time, t_2 = before.time;
        const double ratio = (middle - t_1) / (t_1 - t_2);
        double largest     = 0;
        for (unsigned int s = 0; s < velocities.size(); ++s)
          largest = std::max(largest, velocities[s].largest([&](const unsigned int i) {
            return (velocities[s][i] - (1 + ratio) * last.velocities[s][i] +
                    ratio * before.velocities[s][i])
              .norm();
          }));
        result = dt * dt * dt / 6 * largest / ((middle - t_1) * (middle - t_2));
      }
    past.push_back({middle, velocities});
    if (past.size() > 2)
      past.pop_front();
    return result;
  }


  template <int dim>
  void
  ErrorEstimate<dim>::archive(Archive &archive)
  {
    archive("past", past);
  }


  template class ErrorEstimate<2>;
  template class ErrorEstimate<3>;
} // namespace feib
