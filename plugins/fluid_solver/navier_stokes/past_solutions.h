// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_past_solutions_h
#define feib_plugins_navier_stokes_past_solutions_h

#include <feib/archive.h>
#include <feib/eulerian_space.h>

#include <deque>
#include <memory>

namespace feib
{
  /// The solutions of the last steps, from which the first guess of the next is extrapolated.
  template <int dim>
  class PastSolutions
  {
  public:
    /// Puts the polynomial in time through the solutions into the state. Where the present step was
    /// computed before, the state stays: it is nearer than any guess.
    void guess(EulerianSpace<dim> &space, double time) const;

    /// The state of the space is the solution of the present step, until commit() or another is.
    void keep(const EulerianSpace<dim> &space, double time);

    void commit();

    /// They are of another mesh.
    void forget();

    void archive(Archive &archive);

  private:
    struct Solution
    {
      double time = 0;
      VelocityVector velocity;
      PressureVector pressure;

      void
      archive(Archive &archive)
      {
        archive("time", time);
        archive("velocity", velocity);
        archive("pressure", pressure);
      }
    };

    std::deque<std::shared_ptr<const Solution>> solutions; // the latest first
    std::shared_ptr<const Solution> provisional;           // of the present step
  };
} // namespace feib

#endif
