// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_inertial_load_h
#define feib_inertial_load_h

#include <feib/immersed_structure.h>
#include <feib/implicit_load.h>

namespace feib
{
  /// The inertia of the structures' excess mass M, lumped to nodes, when these come to move with
  /// the fluid's velocity u within the time tau,
  ///   J^T [ -M/tau (J u - V) ],
  /// J at the geometry the couplings are set to, V the velocities of the structures.
  template <int dim>
  class InertialLoad : public ImplicitLoad<dim>
  {
  public:
    using Product    = typename ImplicitLoad<dim>::Product;
    using Structures = std::vector<ImmersedStructure<dim>>;

    InertialLoad(const EulerianSpace<dim> &space, const Structures &structures, const double tau)
      : space(space)
      , structures(structures)
      , tau(tau)
    {}

    /// Whether no structure has any.
    bool
    empty() const
    {
      for (const ImmersedStructure<dim> &structure : structures)
        if (!structure.model->excess_mass().empty())
          return false;
      return true;
    }

    void
    evaluate(const VelocityVector &u, VelocityVector &load) override
    {
      NodalField<dim> U;
      for (const ImmersedStructure<dim> &structure : structures)
        if (const std::vector<double> &mass = structure.model->excess_mass(); !mass.empty())
          {
            structure.motion->interpolate(space, u, U);
            for (unsigned int i = 0; i < U.size(); ++i)
              U[i] = -mass[i] / tau * (U[i] - structure.model->velocities[i]);
            structure.motion->spread(space, U, load);
          }
    }

    void
    apply(VelocityVector &dst, const VelocityVector &du) const override
    {
      NodalField<dim> dU;
      for (const ImmersedStructure<dim> &structure : structures)
        if (const std::vector<double> &mass = structure.model->excess_mass(); !mass.empty())
          {
            structure.motion->interpolate(space, du, dU);
            for (unsigned int i = 0; i < dU.size(); ++i)
              dU[i] *= mass[i] / tau;
            structure.motion->spread(space, dU, dst);
          }
    }

    bool
    linear() const override
    {
      return true;
    }

    std::vector<Product>
    matrix() const override
    {
      std::vector<Product> products;
      for (const ImmersedStructure<dim> &structure : structures)
        if (const std::vector<double> &mass = structure.model->excess_mass(); !mass.empty())
          {
            const std::uint64_t n = dim * structure.nodes.size();
            Product product{n, n, {}, {}, structure.motion->entries(space), true};
            if (dealii::Utilities::MPI::this_mpi_process(space.communicator()) == 0)
              for (std::uint64_t i = 0; i < n; ++i)
                product.middle.push_back({i, i, mass[i / dim] / tau});
            products.push_back(std::move(product));
          }
      return products;
    }

  private:
    const EulerianSpace<dim> &space;
    const Structures &structures;
    const double tau;
  };
} // namespace feib

#endif
