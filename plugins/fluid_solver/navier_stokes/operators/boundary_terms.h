// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_boundary_terms_h
#define feib_plugins_navier_stokes_boundary_terms_h

#include <feib/fluid_solver.h>

#include <vector>

namespace feib
{
  /// What the conditions on the faces of the box add to the equations, and what the fluid gets
  /// through them.
  template <int dim>
  class BoundaryTerms
  {
  public:
    using Exchange = typename FluidSolver<dim>::BoundaryExchange;

    BoundaryTerms();

    /// For the present mesh of the space. Collective. Throws RunFailure when a part of a face has
    /// no face of a cell.
    void reinit(const EulerianSpace<dim> &space);

    /// Whether a condition gives a traction or a pressure, so that there is a load.
    static bool exists(const Domain<dim> &box);

    /// What is wrong with given tractions, pressures and fluxes at the first of these times when
    /// something is. Collective.
    static Issues check(const EulerianSpace<dim> &space, const std::vector<double> &times);

    /// (sigma n, v) of the tractions and pressures given at a time; where the pressure hangs on the
    /// flux, @p pressures has it, by the number of the condition. Not condensed. Collective. Throws
    /// RunFailure when something is not finite.
    VelocityVector
    load(const EulerianSpace<dim> &space, double time, const std::vector<double> &pressures) const;

    /// -(n, v) over one condition: the load of a pressure of 1. Not condensed. Collective.
    VelocityVector unit_load(const EulerianSpace<dim> &space, unsigned int condition) const;

    /// The flux of u out of the box through each condition. Collective.
    std::vector<double> fluxes(const EulerianSpace<dim> &space, const VelocityVector &u) const;

    /// What is exchanged at the state of the space and that time. @p reaction: minus the force that
    /// keeps the velocity where it is prescribed, not condensed. Collective.
    std::vector<Exchange> exchange(const EulerianSpace<dim> &space,
                                   VelocityVector reaction,
                                   double time,
                                   const std::vector<double> &pressures) const;

  private:
    static constexpr unsigned int n   = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_q = dim == 2 ? 4 : 16;

    using Face = typename EulerianSpace<dim>::BoundaryFace;

    /// An owned unknown in the boundary, and the condition that prescribes its value.
    struct Prescribed
    {
      unsigned int unknown, component, condition;
      dealii::Point<dim> place;
    };

    static void check_parts(const EulerianSpace<dim> &space);
    void find_prescribed(const EulerianSpace<dim> &space);

    /// A point of a face, and its weight there.
    dealii::Point<dim>
    place(const EulerianSpace<dim> &space, const Face &face, unsigned int q) const;
    double weight(const EulerianSpace<dim> &space, const Face &face, unsigned int q) const;

    /// sigma n as given, with the time of the expressions.
    static dealii::Tensor<1, dim>
    traction(const BoundaryCondition<dim> &condition, const dealii::Point<dim> &x, double pressure);

    static void set_time(const Domain<dim> &box, double time);
    static Issues not_finite(const EulerianSpace<dim> &space);

    dealii::Tensor<1, dim> velocity(const EulerianSpace<dim> &space,
                                    const VelocityVector &u,
                                    const Face &face,
                                    unsigned int q) const;

    std::vector<Prescribed> prescribed;

    // Of the unit cell: Gauss points of each face, and the shape functions there.
    dealii::Point<dim> points[2 * dim][n_q];
    double phi[2 * dim][n_q][n];
    double weights[n_q];
  };
} // namespace feib

#endif
