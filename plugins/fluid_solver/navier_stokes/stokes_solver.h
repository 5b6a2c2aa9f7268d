// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_stokes_solver_h
#define feib_plugins_navier_stokes_stokes_solver_h

#include "direct_solver.h"
#include "fluid_operators.h"
#include "stokes_multigrid.h"

#include <set>

namespace feib
{
  /// Solves the linear equations of a step, or of a step of Newton's method for an implicit load,
  /// for a correction of velocity and pressure: by FGMRES with multigrid or a factorisation for
  /// preconditioner, or by the factorisation alone where that has all there is in the equations.
  template <int dim>
  class StokesSolver
  {
  public:
    enum class Method
    {
      automatic,
      multigrid,
      direct
    };

    /// [rate M + viscosity + convection + load  -B^T; -B  0].
    struct Equations
    {
      const EulerianSpace<dim> &space;
      const FluidOperators<dim> &operators;
      double rate;                              // 1/dt
      const VelocityVector *velocity = nullptr; // Newton's method has convection here, if any
      double cfl                     = 0;       // of that velocity
      const ImplicitLoad<dim> *load  = nullptr;

      /// r += factor times the derivative of convection along u
      void
      add_convection(const double factor, const VelocityVector &u, VelocityVector &r) const
      {
        operators.add_convection(factor, u, r);
        operators.add_convection_by(factor, u, *velocity, r);
      }
    };

    explicit StokesSolver(const Method method)
      : wanted(method)
    {}

    /// (du, dp) = matrix^{-1} (r, g), with r condensed; du obeys homogeneous constraints.
    /// The norm of (r, @p weight g) is brought below @p target. Returns the number of iterations.
    /// Collective. Throws RunFailure with the history of the residual when that does not succeed.
    unsigned int solve(const Equations &equations,
                       const VelocityVector &r,
                       const PressureVector &g,
                       double weight,
                       double target,
                       VelocityVector &du,
                       PressureVector &dp);

    /// Drops all that was made for earlier equations: what follows does not depend on them.
    void forget();

  private:
    Method choose(const Equations &equations) const;

    void prepare(const Equations &equations);

    void factorize(const Equations &equations);

    const Method wanted;
    Method method = Method::automatic; // as chosen
    std::set<Method> told;             // what the log has said

    // What the preconditioner was made for; convective: with convection in its blocks.
    bool convective                      = false;
    unsigned int revision                = 0;
    double rate                          = 0;
    const FluidOperators<dim> *operators = nullptr;

    StokesMultigrid<dim> multigrid;

    DirectSolver<dim> direct;
    bool factor_outdated        = true;
    bool factor_with_load       = false; // the implicit load is, or should be, in the factorisation
    bool factor_with_convection = false;
    unsigned int excess         = 0; // iterations beyond the few after a fresh factorisation
    unsigned int uses           = 0; // corrections computed with the factorisation,
    unsigned int last_uses      = 0; // and with the one before
  };
} // namespace feib

#endif
