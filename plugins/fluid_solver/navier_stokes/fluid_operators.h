// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_fluid_operators_h
#define feib_plugins_navier_stokes_fluid_operators_h

#include "cell_kernels.h"
#include "cell_operators.h"

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

    /// What the equations are made of. Velocities are tested with R v, and count as R u, in inertia
    /// and convection when there is a @p reconstruction.
    struct Terms
    {
      double rho, mu, grad_div;
      bool symmetric; // 2 mu (D(u), D(v)), else mu (grad u, grad v)
      ConvectiveForm convective_form;
    };

    explicit FluidOperators(const Terms &terms)
      : given_terms(terms)
    {}

    const Terms &
    terms() const
    {
      return given_terms;
    }

    /// Whether R is not the identity.
    bool
    reconstructs() const
    {
      return with_reconstruction;
    }

    void set_reconstruction(const Reconstruction<dim> &reconstruction);

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

    /// r += factor rho b(w; u, v)
    void add_convection(double factor,
                        const VelocityVector &w,
                        const VelocityVector &u,
                        VelocityVector &r) const;

    /// a(u, u) and rho (u, u), summed over all ranks. Collective.
    double dissipation(const VelocityVector &u) const;
    double square(const VelocityVector &u) const;

    /// The largest sum_a |u_a| / h_a at any node, over all ranks. Collective.
    double cfl_rate(const VelocityVector &u) const;

    /// Integrals over the fluid at the velocity of the space. Collective.
    typename FluidSolver<dim>::Balance balance(const Space &space) const;

    /// The matrix of a cell for rate M + viscosity, with convection by w when given, and of (div u,
    /// q); rows of n_u.
    std::vector<double> velocity_matrix(const Space &space,
                                        unsigned int cell,
                                        double rate,
                                        const VelocityVector *w) const;
    const std::vector<double> &
    divergence_matrix(const Space &space, const unsigned int cell) const
    {
      return divergence_matrices[space.cells()[cell].level];
    }

  private:
    using Values                        = Batch<double>::Values;
    static constexpr unsigned int lanes = Batch<double>::lanes;

    /// Cells of one size, with outflow over the same faces.
    struct CellBatch
    {
      dealii::Tensor<1, dim> size;
      unsigned int level, outflow_faces, filled;
      unsigned int cells[lanes]; // the last lanes may repeat a cell
      unsigned int velocities[n_u * lanes], pressures[n_p * lanes];
    };

    void gather(const VelocityVector &u, const CellBatch &batch, Values (&local)[n_u]) const;

    void scatter_add(const Values (&local)[n_u], const CellBatch &batch, VelocityVector &r) const;

    /// out = rate (rho R u, R v) + viscosity (0 or 1) a(u, v)
    void velocity_form(const CellBatch &batch,
                       double rate,
                       double viscosity,
                       const Values (&u)[n_u],
                       Values (&out)[n_u]) const;

    double quadratic_form(double rate, double viscosity, const VelocityVector &u) const;

    const Terms given_terms;
    bool with_reconstruction = false;
    CellOperators<dim> operators;
    std::vector<CellBatch> batches;
    std::vector<unsigned int> outflow_faces;              // per cell, bit f for face f
    std::vector<std::vector<double>> masses;              // rho (R u, R v) of each level
    std::vector<std::vector<double>> divergence_matrices; // of each level
    MPI_Comm communicator = MPI_COMM_NULL;
  };
} // namespace feib

#endif
