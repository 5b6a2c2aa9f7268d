// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/time_integrator/structure_load.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    /// a += factor b
    template <int dim>
    void
    add(NodalField<dim> &a, const double factor, const NodalField<dim> &b)
    {
      for (unsigned int q = 0; q < a.size(); ++q)
        a[q] += factor * b[q];
    }
  } // namespace


  template <int dim>
  StructureLoad<dim>::StructureLoad(const System &system,
                                    const double tau,
                                    const std::vector<Positions<dim>> &geometry,
                                    const bool elastic)
    : Inertia(system.space, system.structures, tau)
    , system(system)
    , tau(tau)
    , geometry(geometry)
    , elastic(elastic)
    , moved(system.structures.size())
    , forces(system.structures.size())
  {}


  template <int dim>
  bool
  StructureLoad<dim>::acts(const unsigned int s) const
  {
    return elastic || system.structures[s].model->viscous();
  }


  template <int dim>
  bool
  StructureLoad<dim>::empty() const
  {
    for (unsigned int s = 0; s < moved.size(); ++s)
      if (acts(s))
        return false;
    return Inertia::empty();
  }


  template <int dim>
  void
  StructureLoad<dim>::evaluate(const VelocityVector &u, VelocityVector &load)
  {
    NodalField<dim> U, force, viscous;
    largest = 0;
    for (unsigned int s = 0; s < moved.size(); ++s)
      {
        if (!acts(s))
          continue;
        const ImmersedStructure<dim> &structure = system.structures[s];
        structure.motion->interpolate(system.space, u, U);
        for (const NodalField<dim> &part :
             structure.model->force_loads(moved_by(s, U), geometry[s], U))
          largest = std::max(largest, std::sqrt(part * part));
        force = NodalField<dim>(structure.model->load_points());
        if (elastic)
          {
            moved[s] = moved_by(s, U);
            structure.model->load(moved[s], forces[s]);
            force = forces[s];
          }
        if (structure.model->viscous())
          {
            structure.model->viscous_load(geometry[s], U, viscous);
            add<dim>(force, 1., viscous);
          }
        structure.spreading().spread(system.space, force, load);
      }
    Inertia::evaluate(u, load);
  }


  template <int dim>
  double
  StructureLoad<dim>::largest_part() const
  {
    return largest;
  }


  template <int dim>
  void
  StructureLoad<dim>::apply(VelocityVector &dst, const VelocityVector &du) const
  {
    NodalField<dim> dU, force, viscous;
    for (unsigned int s = 0; s < moved.size(); ++s)
      {
        if (!acts(s))
          continue;
        const ImmersedStructure<dim> &structure = system.structures[s];
        structure.motion->interpolate(system.space, du, dU);
        force = NodalField<dim>(structure.model->load_points());
        if (elastic)
          {
            structure.model->load_derivative(moved[s], dU, force);
            for (auto &value : force)
              value *= -tau;
          }
        if (structure.model->viscous())
          {
            structure.model->viscous_load(geometry[s], dU, viscous);
            add<dim>(force, -1., viscous);
          }
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
    for (unsigned int s = 0; s < moved.size(); ++s)
      {
        if (!acts(s))
          continue;
        const ImmersedStructure<dim> &structure = system.structures[s];
        const StructureModel<dim> &model        = *structure.model;
        const std::uint64_t n_motion            = dim * structure.nodes.size();
        Product product{n_motion, n_motion, {}, {}, structure.motion->entries(system.space), true};
        if (elastic)
          product.middle = model.tangent(moved[s]);
        for (MatrixEntry &entry : product.middle)
          entry.value *= tau;
        if (model.viscous())
          {
            const MatrixEntries viscous = model.viscous_tangent(geometry[s]);
            product.middle.insert(product.middle.end(), viscous.begin(), viscous.end());
          }
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
