// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_stokes_solver_h
#define feib_plugins_navier_stokes_stokes_solver_h

#include "direct/direct_solver.h"
#include "multigrid/stokes_multigrid.h"
#include "stokes_equations.h"

#include <deal.II/lac/la_parallel_block_vector.h>
#include <deal.II/lac/solver_control.h>

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

    using Equations = StokesEquations<dim>;

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

    /// Factorises when there is no factorisation, or a better one pays.
    void renew_factorization(const Equations &equations);

    using BlockVector = dealii::LinearAlgebra::distributed::BlockVector<double>;

    /// solution = about matrix^{-1} right_hand_side by FGMRES, the second row of both matrix and
    /// right hand side times a weight. Returns the number of iterations.
    unsigned int iterate(const Equations &equations,
                         double weight,
                         double target,
                         const BlockVector &right_hand_side,
                         BlockVector &solution);

    /// One try. @p memory: of FGMRES. Throws SolverControl::NoConvergence.
    void try_to_iterate(const Equations &equations,
                        double weight,
                        unsigned int memory,
                        dealii::SolverControl &control,
                        const BlockVector &right_hand_side,
                        BlockVector &solution);

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
