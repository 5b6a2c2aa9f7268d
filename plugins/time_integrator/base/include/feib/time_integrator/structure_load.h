// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_time_integrator_structure_load_h
#define feib_time_integrator_structure_load_h

#include <feib/inertial_load.h>
#include <feib/time_integrator.h>

namespace feib
{
  /// The part of the structures' load that depends on the velocity u being computed,
  ///   J^T [ F(X^n + tau J u) - M/tau (J u - V^n) ],
  /// J at the geometry the couplings are set to, X^n and V^n what the structures hold. F is left
  /// out where the scheme takes the elastic force explicitly, M where there is no excess mass.
  template <int dim>
  class StructureLoad : public InertialLoad<dim>
  {
  public:
    using System  = typename TimeIntegrator<dim>::System;
    using Product = typename ImplicitLoad<dim>::Product;

    /// @p elastic: whether F is a part of it.
    StructureLoad(const System &system, double tau, bool elastic);

    /// Whether there is nothing in it.
    bool empty() const;

    void evaluate(const VelocityVector &u, VelocityVector &load) override;

    void apply(VelocityVector &dst, const VelocityVector &du) const override;

    bool linear() const override;

    std::vector<Product> matrix() const override;

    /// F of structure @p s for the velocities @p U of its nodes: what a fluid solver has evaluated
    /// last is not computed again.
    NodalField<dim> elastic_force(unsigned int s, const NodalField<dim> &U) const;

  private:
    using Inertia = InertialLoad<dim>;

    const System &system;
    const double tau;
    const bool elastic;
    Positions<dim> moved_by(unsigned int s, const NodalField<dim> &U) const;

    std::vector<Positions<dim>> moved;   // where F was evaluated last
    std::vector<NodalField<dim>> forces; // F there
  };
} // namespace feib

#endif
