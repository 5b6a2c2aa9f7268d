// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_fluid_operators_h
#define feib_plugins_navier_stokes_fluid_operators_h

#include "operators/convection.h"

#include <feib/fluid_solver.h>

namespace feib
{
  /// The terms of the Navier-Stokes equations on the velocities and pressures of the space, by
  /// loops over batches of cells. Arguments have their constraints distributed and their ghost
  /// values up to date; results are sums over the cells of this rank, neither compressed nor
  /// condensed.
  template <int dim>
  class FluidOperators
  {
  public:
    using Space = EulerianSpace<dim>;

    static constexpr unsigned int n   = CellOperators<dim>::n;
    static constexpr unsigned int n_u = CellOperators<dim>::n_u;
    static constexpr unsigned int n_p = CellOperators<dim>::n_p;

    /// What the equations are made of.
    struct Terms
    {
      double rho, mu, grad_div;
      bool symmetric; // 2 mu (D(u), D(v)), else mu (grad u, grad v)
      ConvectiveForm convective_form;
    };

    explicit FluidOperators(const Terms &terms)
      : given_terms(terms)
      , convection_terms(batches, operators, terms.rho, terms.convective_form)
    {}
    FluidOperators(const FluidOperators &) = delete;

    const Terms &
    terms() const
    {
      return given_terms;
    }

    Convection<dim> &
    convection()
    {
      return convection_terms;
    }
    const Convection<dim> &
    convection() const
    {
      return convection_terms;
    }

    /// For the present mesh of the space.
    void reinit(const Space &space);

    /// r += inertia (rho u, v) rate + viscosity and grad_div a(u, v), each times @p factor.
    void
    add_velocity_form(double rate, double factor, const VelocityVector &u, VelocityVector &r) const;

    /// r -= (rate M + viscosity) u - B^T p, g += B u: what is left of the linear equations.
    void subtract_stokes(double rate,
                         const VelocityVector &u,
                         const PressureVector &p,
                         VelocityVector &r,
                         PressureVector &g) const;

    /// r += B^T p and g += B u.
    void add_gradient(const PressureVector &p, VelocityVector &r) const;
    void add_divergence(const VelocityVector &u, PressureVector &g) const;

    /// a(u, u) and rho (u, u), summed over all ranks. Collective.
    double dissipation(const VelocityVector &u) const;
    double square(const VelocityVector &u) const;

    /// The largest sum_a |u_a| / h_a at any node, over all ranks. Collective.
    double cfl_rate(const VelocityVector &u) const;

    /// Integrals over the fluid at the velocity of the space. Collective.
    typename FluidSolver<dim>::Balance balance(const Space &space) const;

    /// The matrices of a cell, rows of n_u: for rate M + viscosity, and of (div u, q).
    std::vector<double>
    velocity_matrix(const Space &space, const unsigned int cell, const double rate) const
    {
      return operators.velocity_matrix(space.cells()[cell].size,
                                       rate * given_terms.rho,
                                       given_terms.mu,
                                       given_terms.symmetric,
                                       given_terms.grad_div);
    }
    const std::vector<double> &
    divergence_matrix(const Space &space, const unsigned int cell) const
    {
      return divergence_matrices[space.cells()[cell].level];
    }

  private:
    using Values                        = typename CellBatches<dim>::Values;
    using CellBatch                     = typename CellBatches<dim>::CellBatch;
    static constexpr unsigned int lanes = CellBatches<dim>::lanes;

    /// out = rate (rho u, v) + viscosity (0 or 1) a(u, v)
    void velocity_form(const CellBatch &batch,
                       double rate,
                       double viscosity,
                       const Values (&u)[n_u],
                       Values (&out)[n_u]) const;

    double quadratic_form(double rate, double viscosity, const VelocityVector &u) const;

    /// The integral of (div u)^2 over each cell.
    Values divergence_square(const CellBatch &batch, const Values (&u)[n_u]) const;

    void add_momentum(const Space &space,
                      const CellBatch &batch,
                      const Values (&u)[n_u],
                      typename FluidSolver<dim>::Balance &balance) const;

    const Terms given_terms;
    const CellOperators<dim> operators;
    CellBatches<dim> batches;
    Convection<dim> convection_terms;
    std::vector<std::vector<double>> divergence_matrices; // of each level
    MPI_Comm communicator = MPI_COMM_NULL;
  };
} // namespace feib

#endif
