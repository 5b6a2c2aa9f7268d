// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_convection_h
#define feib_plugins_navier_stokes_convection_h

#include "operators/cell_batches.h"
#include "operators/cell_operators.h"

#include <optional>

namespace feib
{
  /// Convection, and its derivative, on the velocities of the space. Arguments and results are as
  /// those of FluidOperators.
  template <int dim>
  class Convection
  {
  public:
    static constexpr unsigned int n   = CellBatches<dim>::n;
    static constexpr unsigned int n_u = CellBatches<dim>::n_u;
    static constexpr unsigned int n_p = CellBatches<dim>::n_p;

    /// @p batches and @p operators must live as long.
    Convection(const CellBatches<dim> &batches,
               const CellOperators<dim> &operators,
               double rho,
               ConvectiveForm form);

    /// For the present mesh of the space, that of the batches.
    void reinit(const EulerianSpace<dim> &space);

    /// Convection is by the velocity @p w from now on, until the mesh changes.
    void set_velocity(const VelocityVector &w);

    /// r += factor rho b(w; u, v) with
    ///   skew_symmetric  b = 1/2 [(w . grad u, v) - (w . grad v, u)]
    ///   rotational      b = (curl w x R u, R v)
    /// and the traction of open boundaries (CellOperators::add_open_boundary). The power b(w; u, u)
    /// is that of open boundaries alone, for any w.
    void add(double factor, const VelocityVector &u, VelocityVector &r) const;

    /// r += factor times the derivative of convection of @p u in the convecting velocity (which u
    /// was set as), along @p w: what Newton's method has beside add().
    void add_by(double factor,
                const VelocityVector &w,
                const VelocityVector &u,
                VelocityVector &r) const;

    /// p += factor rho/2 |u|^2 in the functions of the pressure: the rotational form's pressure is
    /// the total one.
    void add_dynamic_pressure(double factor, const VelocityVector &u, PressureVector &p) const;

    /// The matrix of a cell, rows of n_u, of the derivative at the convecting velocity @p u.
    std::vector<double> matrix(unsigned int cell, const VelocityVector &u) const;

  private:
    using Values                        = typename CellBatches<dim>::Values;
    using CellBatch                     = typename CellBatches<dim>::CellBatch;
    static constexpr unsigned int lanes = CellBatches<dim>::lanes;

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

    const CellBatches<dim> &batches;
    const CellOperators<dim> &operators;
    const double rho;
    const ConvectiveForm form;

    // Of the convecting velocity: at the points, and for batches with open faces at the nodes.
    std::optional<ReconstructionAtPoints<dim>> reconstruction; // the same for all levels
    std::vector<Values> at_points, at_nodes;
  };
} // namespace feib

#endif
