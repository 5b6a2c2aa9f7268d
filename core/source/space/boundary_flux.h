// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_boundary_flux_h
#define feib_source_boundary_flux_h

#include <feib/eulerian_space.h>

#include <string>

namespace feib
{
  /// What prescribed velocities carry through the boundary, per time [volume/time].
  struct BoundaryFlux
  {
    double net   = 0; // out of the box
    double gross = 0; // in and out
    double error = 0; // of net

    double
    in() const
    {
      return (gross - net) / 2;
    }

    double
    out() const
    {
      return (gross + net) / 2;
    }
  };

  /// The flux of the boundary values that stand in the constraints, exact for Q2. Collective.
  template <int dim>
  BoundaryFlux interpolated_flux(const dealii::DoFHandler<dim> &handler,
                                 const Domain<dim> &box,
                                 const dealii::AffineConstraints<double> &constraints);

  /// Whether the prescribed velocities themselves, and not only their interpolation, carry a net
  /// flux out of an enclosed box at their present time t. Collective.
  template <int dim>
  Issues unbalanced_flux(const Domain<dim> &box,
                         const BoundaryFlux &interpolated,
                         double t,
                         MPI_Comm communicator);

  /// What to say of a flux that EulerianSpace has spread.
  template <int dim>
  std::string spread_flux_text(const EulerianSpace<dim> &space);

  /// The flux of the expressions themselves at their present time. Collective.
  template <int dim>
  BoundaryFlux prescribed_flux(const Domain<dim> &box);
} // namespace feib

#endif
