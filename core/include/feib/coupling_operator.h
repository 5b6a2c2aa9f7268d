// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_coupling_operator_h
#define feib_coupling_operator_h

#include <feib/archive.h>
#include <feib/eulerian_space.h>
#include <feib/lagrangian_points.h>
#include <feib/matrix_entry.h>
#include <feib/parameters.h>

namespace feib
{
  /// One linear map J, from an Eulerian velocity to the velocities of points that ride on a
  /// structure, and its exact transpose: (J^T f) . v = f . (J v) to round-off, whatever J is, so
  /// that power is conserved. One object serves one structure and one set of points.
  ///
  /// A coupling is given the structure's mesh and positions, not only the points, so that it may
  /// integrate along segments and facets; and on the fluid's side the cells with their local values
  /// (EulerianSpace::cells), so that it may evaluate a reconstruction of the velocity.
  template <int dim>
  class CouplingOperator
  {
  public:
    static constexpr const char *kind = "coupling_operator";

    virtual ~CouplingOperator() = default;

    /// What the object carries from step to step. Collective.
    virtual void
    archive(Archive &)
    {}

    /// Fixes the geometry: J at the positions X. Collective. Throws RunFailure on all ranks when a
    /// point is not in the box or not finite.
    virtual void set_geometry(const EulerianSpace<dim> &space,
                              const LagrangianMesh<dim> &mesh,
                              const Positions<dim> &X,
                              const LagrangianPoints &points) = 0;

    /// U = J u, one velocity per point, made anew from the points, ghosts up to date. @p u has its
    /// constraints distributed and its ghost values up to date. Collective.
    virtual void interpolate(const EulerianSpace<dim> &space,
                             const VelocityVector &u,
                             NodalField<dim> &U) const = 0;

    /// rhs += J^T f on all degrees of freedom, constrained ones too (EulerianSpace::condense comes
    /// after). The ghosts of @p f are up to date; @p rhs is compressed on return. Collective.
    virtual void spread(const EulerianSpace<dim> &space,
                        const NodalField<dim> &f,
                        VelocityVector &rhs) const = 0;

    /// J as entries: row = point * dim + component, column = global velocity unknown (constrained
    /// ones too), those of this rank's cells. For preconditioners of implicit schemes.
    virtual MatrixEntries entries(const EulerianSpace<dim> &space) const = 0;

    /// How many of the smallest cells of the fluid an element of the structure may be long before
    /// volume or accuracy suffers: longer ones are a warning of the run. Points that see the flow
    /// only where they are miss what passes between them.
    virtual double
    longest_element() const
    {
      return 1;
    }
  };
} // namespace feib

#endif
