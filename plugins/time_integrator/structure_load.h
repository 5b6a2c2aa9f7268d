// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_time_integrator_structure_load_h
#define feib_plugins_time_integrator_structure_load_h

#include <feib/implicit_load.h>
#include <feib/time_integrator.h>

namespace feib
{
  /// The part of the structures' load that depends on the velocity u being computed,
  ///   J^T [ F(X^n + tau J u) - M/tau (J u - V^n) ],
  /// J at the geometry the couplings are set to, X^n and V^n what the structures hold. F is left
  /// out where the scheme takes the elastic force explicitly, M where there is no excess mass.
  template <int dim>
  class StructureLoad : public ImplicitLoad<dim>
  {
  public:
    using System  = typename TimeIntegrator<dim>::System;
    using Product = typename ImplicitLoad<dim>::Product;

    StructureLoad(System &system, const double tau, const bool elastic)
      : system(system)
      , tau(tau)
      , elastic(elastic)
      , moved(system.structures.size())
    {}

    /// Whether there is nothing in it.
    bool
    empty() const
    {
      for (const ImmersedStructure<dim> &structure : system.structures)
        if (elastic || !structure.model->excess_mass().empty())
          return false;
      return true;
    }

    void
    evaluate(const VelocityVector &u, VelocityVector &load) override
    {
      NodalField<dim> U, force;
      for (unsigned int s = 0; s < moved.size(); ++s)
        {
          const ImmersedStructure<dim> &structure = system.structures[s];
          const StructureModel<dim> &model        = *structure.model;
          structure.motion->interpolate(system.space, u, U);
          if (elastic)
            {
              moved[s] = model.positions;
              for (unsigned int i = 0; i < U.size(); ++i)
                moved[s][i] += tau * U[i];
              model.load(moved[s], force);
              structure.spreading().spread(system.space, force, load);
            }
          if (!model.excess_mass().empty())
            {
              for (unsigned int i = 0; i < U.size(); ++i)
                U[i] = -model.excess_mass()[i] / tau * (U[i] - model.velocities[i]);
              structure.motion->spread(system.space, U, load);
            }
        }
    }

    void
    apply(VelocityVector &dst, const VelocityVector &du) const override
    {
      NodalField<dim> dU, force;
      for (unsigned int s = 0; s < moved.size(); ++s)
        {
          const ImmersedStructure<dim> &structure = system.structures[s];
          const StructureModel<dim> &model        = *structure.model;
          structure.motion->interpolate(system.space, du, dU);
          if (elastic)
            {
              model.load_derivative(moved[s], dU, force);
              for (auto &value : force)
                value *= -tau;
              structure.spreading().spread(system.space, force, dst);
            }
          if (!model.excess_mass().empty())
            {
              for (unsigned int i = 0; i < dU.size(); ++i)
                dU[i] *= model.excess_mass()[i] / tau;
              structure.motion->spread(system.space, dU, dst);
            }
        }
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
      std::vector<Product> products;
      for (unsigned int s = 0; s < moved.size(); ++s)
        {
          const ImmersedStructure<dim> &structure = system.structures[s];
          const StructureModel<dim> &model        = *structure.model;
          const std::uint64_t n_motion            = dim * structure.nodes.size();
          const MatrixEntries J                   = structure.motion->entries(system.space);
          if (elastic)
            {
              Product product{n_motion, n_motion, {}, model.tangent(moved[s]), J, true};
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
          if (!model.excess_mass().empty())
            {
              Product product{n_motion, n_motion, {}, {}, J, true};
              if (dealii::Utilities::MPI::this_mpi_process(system.space.communicator()) == 0)
                for (std::uint64_t i = 0; i < n_motion; ++i)
                  product.middle.push_back({i, i, model.excess_mass()[i / dim] / tau});
              products.push_back(std::move(product));
            }
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
