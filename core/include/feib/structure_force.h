// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_force_h
#define feib_structure_force_h

#include <feib/archive.h>
#include <feib/domain.h>
#include <feib/lagrangian_mesh.h>
#include <feib/matrix_entry.h>
#include <feib/parameters.h>

#include <string>
#include <vector>

namespace feib
{
  /// What acts on a structure beside its law: one more term of its energy, with forces at nodes.
  /// Time schemes take it as they take the law: load() at the positions and the time the elastic
  /// force is taken at; viscous_load(), linear in the velocities computed, implicitly in every
  /// scheme; and external_load(), which is the derivative of no energy, where the fluid meets the
  /// structure.
  ///
  /// Loads, entries and stiffnesses are added to what comes. A load is complete on every rank when
  /// a function returns; of entries each rank gives a part. All functions are collective.
  template <int dim>
  class StructureForce
  {
  public:
    static constexpr const char *kind = "structure_force";

    /// The structure that it acts on.
    struct Body
    {
      const LagrangianMesh<dim> &mesh; // outlives the force
      Positions<dim> positions;        // at the start
      /// Of each node, beyond that of the fluid; empty: none. [mass]
      std::vector<double> excess_mass;
      std::vector<double> times; // where functions of the time are to be tried
      const Domain<dim> &domain; // outlives the force
    };

    /// What the largest stable step of an explicit scheme depends on, per reference measure of the
    /// structure: a displacement that is a wave of number k is resisted by a force of nodal +
    /// bending k^4 times itself.
    struct Stiffness
    {
      double nodal   = 0; // [force/length/measure]
      double bending = 0; // [force length^3/measure]
    };

    virtual ~StructureForce() = default;

    /// The name in results: that of the case, or the component's.
    std::string name;

    /// Once, before all else. Throws Error where the case does not fit the structure.
    virtual void attach(const Body &body) = 0;

    /// The time that the functions below are taken at, and how much of it has gone by since the
    /// beginning of the step, 0 between steps.
    virtual void
    set_moment(const double time, const double elapsed)
    {
      (void)time;
      (void)elapsed;
    }

    /// The end of a step at X: what the force remembers moves on.
    virtual void
    update_state(const Positions<dim> &X)
    {
      (void)X;
    }

    /// The potential energy.
    virtual double
    energy(const Positions<dim> &X) const
    {
      (void)X;
      return 0;
    }

    /// The forces -d energy/dX at the nodes.
    virtual void
    load(const Positions<dim> &X, NodalField<dim> &load) const
    {
      (void)X;
      (void)load;
    }

    /// Their derivative in the direction dX.
    virtual void
    load_derivative(const Positions<dim> &X,
                    const NodalField<dim> &dX,
                    NodalField<dim> &dload) const
    {
      (void)X;
      (void)dX;
      (void)dload;
    }

    /// - d load/dX: row = node * dim + component, column alike.
    virtual void
    tangent(const Positions<dim> &X, MatrixEntries &entries) const
    {
      (void)X;
      (void)entries;
    }

    /// Whether load() is linear in X, so that its derivative does not depend on X.
    virtual bool
    linear() const
    {
      return false;
    }

    /// Whether there is a viscous_load().
    virtual bool
    viscous() const
    {
      return false;
    }

    /// Forces at the nodes, linear in their velocities U, that dissipate: load . U <= 0.
    virtual void
    viscous_load(const Positions<dim> &X, const NodalField<dim> &U, NodalField<dim> &load) const
    {
      (void)X;
      (void)U;
      (void)load;
    }

    /// - d viscous_load/dU, like tangent().
    virtual void
    viscous_tangent(const Positions<dim> &X, MatrixEntries &entries) const
    {
      (void)X;
      (void)entries;
    }

    /// Whether there is an external_load().
    virtual bool
    external() const
    {
      return false;
    }

    /// Forces at the nodes that come from no energy. Schemes take them explicitly, so that they
    /// must not be stiff.
    virtual void
    external_load(const Positions<dim> &X, NodalField<dim> &load) const
    {
      (void)X;
      (void)load;
    }

    virtual Stiffness
    stiffness(const Positions<dim> &X) const
    {
      (void)X;
      return {};
    }

    /// What the force carries from step to step.
    virtual void
    archive(Archive &)
    {}
  };
} // namespace feib

#endif
