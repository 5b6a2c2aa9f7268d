// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_time_integrator_h
#define feib_time_integrator_h

#include <feib/fluid_solver.h>
#include <feib/immersed_structure.h>
#include <feib/timers.h>

#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// Orders the calls of one step.
  template <int dim>
  class TimeIntegrator
  {
  public:
    static constexpr const char *kind = "time_integrator";

    /// What a step works on.
    struct System
    {
      EulerianSpace<dim> &space;
      FluidSolver<dim> &fluid;
      std::vector<ImmersedStructure<dim>> &structures;
      Timers &timers;
    };

    using Report = typename FluidSolver<dim>::Report;

    virtual ~TimeIntegrator() = default;

    /// From the time @p time to time + dt: on entry space.old_velocity is u^n and the structures
    /// hold X^n; on return space.velocity and the structures hold the new state. Collective.
    virtual Report step(System &system, double time, double dt) = 0;

    /// Columns of the ledger that belong to the scheme (for fe_be: eta of each structure), at the
    /// present state. The same names at every call. Collective.
    virtual std::vector<std::pair<std::string, double>>
    diagnostics(const System &system, double dt) const
    {
      (void)system;
      (void)dt;
      return {};
    }
  };
} // namespace feib

#endif
