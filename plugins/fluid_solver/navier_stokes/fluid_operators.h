// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_fluid_operators_h
#define feib_plugins_navier_stokes_fluid_operators_h

#include "cell_kernels.h"
#include "cell_operators.h"

#include <feib/fluid_solver.h>

#include <optional>

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
    {}

    const Terms &
    terms() const
    {
      return given_terms;
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

    /// Convection is by the velocity @p w from now on, until the mesh changes.
    void set_convecting_velocity(const VelocityVector &w);

    /// r += factor rho b(w; u, v) with
    ///   skew_symmetric  b = 1/2 [(w . grad u, v) - (w . grad v, u)]
    ///   rotational      b = (curl w x R u, R v)
    /// and the traction of open boundaries (CellOperators::add_open_boundary). The power b(w; u, u)
    /// is that of open boundaries alone, for any w.
    void add_convection(double factor, const VelocityVector &u, VelocityVector &r) const;

    /// r += factor times the derivative of convection of @p u in the convecting velocity (which u
    /// was set as), along @p w: what Newton's method has beside add_convection().
    void add_convection_by(double factor,
                           const VelocityVector &w,
                           const VelocityVector &u,
                           VelocityVector &r) const;

    /// p += factor rho/2 |u|^2 in the functions of the pressure: the rotational form's pressure is
    /// the total one.
    void add_dynamic_pressure(double factor, const VelocityVector &u, PressureVector &p) const;

    /// a(u, u) and rho (u, u), summed over all ranks. Collective.
    double dissipation(const VelocityVector &u) const;
    double square(const VelocityVector &u) const;

    /// The largest sum_a |u_a| / h_a at any node, over all ranks. Collective.
    double cfl_rate(const VelocityVector &u) const;

    /// Integrals over the fluid at the velocity of the space. Collective.
    typename FluidSolver<dim>::Balance balance(const Space &space) const;

    /// The matrix of a cell for rate M + viscosity, of the derivative of
    /// convection at the convecting velocity @p u, and of (div u, q); rows of n_u.
    std::vector<double>
    velocity_matrix(const Space &space, const unsigned int cell, const double rate) const
    {
      return operators.velocity_matrix(space.cells()[cell].size,
                                       rate * given_terms.rho,
                                       given_terms.mu,
                                       given_terms.symmetric,
                                       given_terms.grad_div);
    }
    std::vector<double> convection_matrix(unsigned int cell, const VelocityVector &u) const;
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
      unsigned int level, open_faces, filled;
      unsigned int first_open;   // of at_nodes
      unsigned int cells[lanes]; // the last lanes may repeat a cell
      unsigned int velocities[n_u * lanes], pressures[n_p * lanes];
    };

    void gather(const VelocityVector &u, const CellBatch &batch, Values (&local)[n_u]) const;

    void scatter_add(const Values (&local)[n_u], const CellBatch &batch, VelocityVector &r) const;

    /// out = rate (rho u, v) + viscosity (0 or 1) a(u, v)
    void velocity_form(const CellBatch &batch,
                       double rate,
                       double viscosity,
                       const Values (&u)[n_u],
                       Values (&out)[n_u]) const;

    double quadratic_form(double rate, double viscosity, const VelocityVector &u) const;

    static constexpr unsigned int most_stored = dim * n_points<dim>;

    /// out += convection of u on a cell's inside, by the velocity that is @p at_points as prepared;
    void convect(const Values *at_points, const Values (&u)[n_u], Values (&out)[n_u]) const;

    /// and through the open faces of a batch, by the velocity @p at_nodes, or with its change @p
    /// by.
    void convect_out(const CellBatch &batch,
                     const Values *at_nodes,
                     const Values *by,
                     const Values (&u)[n_u],
                     Values (&out)[n_u]) const;

    const Terms given_terms;
    const CellOperators<dim> operators;
    std::vector<CellBatch> batches;
    std::vector<unsigned int> place_of_cell;              // batch * lanes + lane
    std::vector<std::vector<double>> divergence_matrices; // of each level

    // Of the convecting velocity: at the points, and for batches with open faces at the nodes.
    std::optional<ReconstructionAtPoints<dim>> reconstruction; // the same for all levels
    std::vector<Values> at_points, at_nodes;

    MPI_Comm communicator = MPI_COMM_NULL;
  };
} // namespace feib

#endif
