// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/time_integrator/structure_load.h>

namespace feib
{
  template <int dim>
  StructureLoad<dim>::StructureLoad(const System &system, const double tau, const bool elastic)
    : Inertia(system.space, system.structures, tau)
    , system(system)
    , tau(tau)
    , elastic(elastic)
    , moved(system.structures.size())
    , forces(system.structures.size())
  {}


  template <int dim>
  bool
  StructureLoad<dim>::empty() const
  {
    return (!elastic || system.structures.empty()) && Inertia::empty();
  }


  template <int dim>
  void
  StructureLoad<dim>::evaluate(const VelocityVector &u, VelocityVector &load)
  {
    NodalField<dim> U;
    if (elastic)
      for (unsigned int s = 0; s < moved.size(); ++s)
        {
          const ImmersedStructure<dim> &structure = system.structures[s];
          structure.motion->interpolate(system.space, u, U);
          moved[s] = moved_by(s, U);
          structure.model->load(moved[s], forces[s]);
          structure.spreading().spread(system.space, forces[s], load);
        }
    Inertia::evaluate(u, load);
  }


  template <int dim>
  void
  StructureLoad<dim>::apply(VelocityVector &dst, const VelocityVector &du) const
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


  template <int dim>
  bool
  StructureLoad<dim>::linear() const
  {
    if (elastic)
      for (const ImmersedStructure<dim> &structure : system.structures)
        if (!structure.model->linear())
          return false;
    return true;
  }


  template <int dim>
  std::vector<typename StructureLoad<dim>::Product>
  StructureLoad<dim>::matrix() const
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


  template <int dim>
  Positions<dim>
  StructureLoad<dim>::moved_by(const unsigned int s, const NodalField<dim> &U) const
  {
    Positions<dim> X = system.structures[s].model->positions;
    for (unsigned int i = 0; i < U.size(); ++i)
      X[i] += tau * U[i];
    return X;
  }


  template <int dim>
  NodalField<dim>
  StructureLoad<dim>::elastic_force(const unsigned int s, const NodalField<dim> &U) const
  {
    const Positions<dim> X = moved_by(s, U);
    if (X == moved[s])
      return forces[s];
    NodalField<dim> force;
    system.structures[s].model->load(X, force);
    return force;
  }


  template class StructureLoad<2>;
  template class StructureLoad<3>;
} // namespace feib
