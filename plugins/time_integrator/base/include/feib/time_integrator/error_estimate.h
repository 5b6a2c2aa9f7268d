// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_time_integrator_error_estimate_h
#define feib_time_integrator_error_estimate_h

#include <feib/archive.h>
#include <feib/eulerian_space.h>
#include <feib/lagrangian_mesh.h>

#include <deque>
#include <vector>

namespace feib
{
  /// An estimate of the error dt^3/12 u'' that a step of the midpoint rule adds to displacements,
  /// from the second difference of the velocities half way through the last three steps (which are
  /// free of the alternation that the rule leaves in u^n); of the nodes, or of the fluid when there
  /// is no structure.
  template <int dim>
  class ErrorEstimate
  {
  public:
    /// Takes note of the step from @p time: @p velocities of the structures' nodes half way
    /// through it, and space.velocity. Infinite while there are too few steps. [length]
    double add(const EulerianSpace<dim> &space,
               double time,
               double dt,
               const std::vector<NodalField<dim>> &velocities);

    void archive(Archive &archive);

  private:
    /// Of the nodes in a step.
    struct Motion
    {
      double time = 0; // half way through the step
      std::vector<NodalField<dim>> velocities;

      void
      archive(Archive &archive)
      {
        archive("time", time);
        archive("velocities", velocities);
      }
    };

    std::deque<Motion> past; // the last two steps
  };
} // namespace feib

#endif
