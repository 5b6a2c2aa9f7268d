// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_time_integrator_structure_load_h
#define feib_time_integrator_structure_load_h

#include <feib/inertial_load.h>
#include <feib/time_integrator.h>

namespace feib
{
  /// The part of the structures' load that depends on the velocity u being computed,
  ///   J^T [ F(X^n + tau J u) + F_v(X_g, J u) - M/tau (J u - V^n) ],
  /// J at the geometry X_g the couplings are set to, X^n and V^n what the structures hold. F is
  /// left out where the scheme takes the elastic force explicitly; M and the viscous load F_v where
  /// there are none.
  template <int dim>
  class StructureLoad : public InertialLoad<dim>
  {
  public:
    using System  = typename TimeIntegrator<dim>::System;
    using Product = typename ImplicitLoad<dim>::Product;

    /// @p geometry: X_g, must outlive the object. @p elastic: whether F is a part of it.
    StructureLoad(const System &system,
                  double tau,
                  const std::vector<Positions<dim>> &geometry,
                  bool elastic);

    /// Whether there is nothing in it.
    bool empty() const;

    void evaluate(const VelocityVector &u, VelocityVector &load) override;

    /// Of the forces on structures (StructureForce), as norms over the nodes: a body that is held
    /// has the fluid's forces, and springs against them.
    double largest_part() const override;

    void apply(VelocityVector &dst, const VelocityVector &du) const override;

    bool linear() const override;

    std::vector<Product> matrix() const override;

    /// F of structure @p s for the velocities @p U of its nodes: what a fluid solver has evaluated
    /// last is not computed again.
    NodalField<dim> elastic_force(unsigned int s, const NodalField<dim> &U) const;

    /// X^n + tau U of structure @p s.
    Positions<dim> moved_by(unsigned int s, const NodalField<dim> &U) const;

  private:
    using Inertia = InertialLoad<dim>;

    /// Whether structure @p s has a part in the load beside its inertia.
    bool acts(unsigned int s) const;

    const System &system;
    const double tau;
    const std::vector<Positions<dim>> &geometry;
    const bool elastic;
    std::vector<Positions<dim>> moved;   // where F was evaluated last
    std::vector<NodalField<dim>> forces; // F there
    double largest = 0;                  // of what StructureForces do there
  };
} // namespace feib

#endif
