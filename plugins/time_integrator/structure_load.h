// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_time_integrator_structure_load_h
#define feib_plugins_time_integrator_structure_load_h

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
    using Inertia = InertialLoad<dim>;

    StructureLoad(System &system, const double tau, const bool elastic)
      : Inertia(system.space, system.structures, tau)
      , system(system)
      , tau(tau)
      , elastic(elastic)
      , moved(system.structures.size())
    {}

    /// Whether there is nothing in it.
    bool
    empty() const
    {
      return (!elastic || system.structures.empty()) && Inertia::empty();
    }

    void
    evaluate(const VelocityVector &u, VelocityVector &load) override
    {
      NodalField<dim> U, force;
      if (elastic)
        for (unsigned int s = 0; s < moved.size(); ++s)
          {
            const ImmersedStructure<dim> &structure = system.structures[s];
            structure.motion->interpolate(system.space, u, U);
            moved[s] = structure.model->positions;
            for (unsigned int i = 0; i < U.size(); ++i)
              moved[s][i] += tau * U[i];
            structure.model->load(moved[s], force);
            structure.spreading().spread(system.space, force, load);
          }
      Inertia::evaluate(u, load);
    }

    void
    apply(VelocityVector &dst, const VelocityVector &du) const override
    {
      NodalField<dim> dU, force;
      if (elastic)
        for (unsigned int s = 0; s < moved.size(); ++s)
          {
            const ImmersedStructure<dim> &structure = system.structures[s];
            structure.motion->interpolate(system.space, du, dU);
            structure.model->load_derivative(moved[s], dU, force);
            for (auto &value : force)
              value *= -tau;
            structure.spreading().spread(system.space, force, dst);
          }
      Inertia::apply(dst, du);
    }

    bool
    linear() const override
    {
      if (elastic)
        for (const ImmersedStructure<dim> &structure : system.structures)
          if (!structure.model->linear())
            return false;
      return true;
    }

    std::vector<Product>
    matrix() const override
    {
      std::vector<Product> products = Inertia::matrix();
      if (elastic)
        for (unsigned int s = 0; s < moved.size(); ++s)
          {
            const ImmersedStructure<dim> &structure = system.structures[s];
            const StructureModel<dim> &model        = *structure.model;
            const std::uint64_t n_motion            = dim * structure.nodes.size();
            Product product{n_motion,
                            n_motion,
                            {},
                            model.tangent(moved[s]),
                            structure.motion->entries(system.space),
                            true};
            for (MatrixEntry &entry : product.middle)
              entry.value *= tau;
            if (!model.conservative())
              {
                product.n_left    = dim * model.load_points().size();
                product.left      = structure.spreading().entries(system.space);
                product.symmetric = false;
              }
            products.push_back(std::move(product));
          }
      return products;
    }

  private:
    const System &system;
    const double tau;
    const bool elastic;
    std::vector<Positions<dim>> moved; // where F was evaluated last
  };
} // namespace feib

#endif
