// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/failure.h>
#include <feib/structure_model/structure_forces.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace feib
{
  template <int dim>
  StructureForces<dim>::StructureForces(const LagrangianMesh<dim> &mesh,
                                        const std::string &structure_name,
                                        LagrangianPoints &points)
    : mesh(mesh)
    , structure_name(structure_name)
    , points(points)
  {}


  template <int dim>
  void
  StructureForces<dim>::set(List new_list)
  {
    list = std::move(new_list);
    if (!list.empty() && !points.are_nodes(mesh.n_nodes()))
      {
        first_point = points.size();
        for (unsigned int i = 0; i < mesh.n_nodes(); ++i)
          for (unsigned int k = 0; k < points.nodes_per_point; ++k)
            {
              points.node.push_back(i);
              points.weight.push_back(k == 0 ? 1. : 0.);
            }
      }
  }


  template <int dim>
  bool
  StructureForces<dim>::any(bool (StructureForce<dim>::*property)() const) const
  {
    return std::any_of(list.begin(), list.end(), [&](const auto &force) {
      return (*force.*property)();
    });
  }


  template <int dim>
  template <typename Action>
  void
  StructureForces<dim>::for_each(const char *what, const Action &action) const
  {
    for (const auto &force : list)
      agree(
        mesh.communicator(),
        [&] { action(*force); },
        "the force \"" + force->name + "\" of structure \"" + structure_name + "\" fails in its " +
          what);
  }


  template <int dim>
  template <typename Action>
  void
  StructureForces<dim>::add(const char *what, const Action &action, NodalField<dim> &load) const
  {
    if (list.empty())
      return;
    NodalField<dim> at_nodes(mesh);
    for_each(what, [&](const StructureForce<dim> &force) {
      action(force, at_nodes);
      for (const auto &value : at_nodes)
        if (!std::isfinite(value.norm_square()))
          throw RunFailure("it is not finite");
    });
    NodalField<dim> sum(points);
    std::copy(load.begin(), load.end(), sum.begin());
    for (unsigned int i = 0; i < at_nodes.size(); ++i)
      sum[first_point + i] += at_nodes[i];
    load = std::move(sum);
  }


  template <int dim>
  template <typename Action>
  void
  StructureForces<dim>::add_entries(const char *what,
                                    const Action &action,
                                    MatrixEntries &entries) const
  {
    const std::size_t n_before = entries.size();
    for_each(what, [&](const StructureForce<dim> &force) { action(force, entries); });
    for (std::size_t i = n_before; i < entries.size(); ++i)
      entries[i].row += std::uint64_t(first_point) * dim;
  }


  template <int dim>
  bool
  StructureForces<dim>::empty() const
  {
    return list.empty();
  }


  template <int dim>
  bool
  StructureForces<dim>::linear() const
  {
    return std::all_of(list.begin(), list.end(), [](const auto &force) { return force->linear(); });
  }


  template <int dim>
  bool
  StructureForces<dim>::viscous() const
  {
    return any(&StructureForce<dim>::viscous);
  }


  template <int dim>
  bool
  StructureForces<dim>::external() const
  {
    return any(&StructureForce<dim>::external);
  }


  template <int dim>
  std::vector<std::string>
  StructureForces<dim>::names() const
  {
    std::vector<std::string> result;
    for (const auto &force : list)
      result.push_back(force->name);
    return result;
  }


  template <int dim>
  std::vector<double>
  StructureForces<dim>::energies(const Positions<dim> &X) const
  {
    std::vector<double> result;
    for_each("energy", [&](const StructureForce<dim> &force) {
      result.push_back(force.energy(X));
      if (!std::isfinite(result.back()))
        throw RunFailure("it is not finite");
    });
    return result;
  }


  template <int dim>
  std::vector<NodalField<dim>>
  StructureForces<dim>::loads(const Positions<dim> &X,
                              const Positions<dim> &geometry,
                              const NodalField<dim> &U) const
  {
    std::vector<NodalField<dim>> result;
    for_each("load", [&](const StructureForce<dim> &force) {
      result.emplace_back(mesh);
      force.load(X, result.back());
      if (force.viscous())
        force.viscous_load(geometry, U, result.back());
      if (force.external())
        force.external_load(geometry, result.back());
    });
    return result;
  }


  template <int dim>
  typename StructureForces<dim>::Stiffness
  StructureForces<dim>::stiffness(const Positions<dim> &X) const
  {
    Stiffness result;
    for_each("stiffness", [&](const StructureForce<dim> &force) {
      const Stiffness added = force.stiffness(X);
      result.nodal += added.nodal;
      result.bending += added.bending;
    });
    return result;
  }


  template <int dim>
  void
  StructureForces<dim>::set_moment(const double time, const double elapsed)
  {
    for_each("moment", [&](StructureForce<dim> &force) { force.set_moment(time, elapsed); });
  }


  template <int dim>
  void
  StructureForces<dim>::update_state(const Positions<dim> &X)
  {
    for_each("state", [&](StructureForce<dim> &force) { force.update_state(X); });
  }


  template <int dim>
  void
  StructureForces<dim>::add_load(const Positions<dim> &X, NodalField<dim> &load) const
  {
    add(
      "load",
      [&](const StructureForce<dim> &force, NodalField<dim> &at_nodes) { force.load(X, at_nodes); },
      load);
  }


  template <int dim>
  void
  StructureForces<dim>::add_load_derivative(const Positions<dim> &X,
                                            const NodalField<dim> &dX,
                                            NodalField<dim> &dload) const
  {
    add(
      "derivative of the load",
      [&](const StructureForce<dim> &force, NodalField<dim> &at_nodes) {
        force.load_derivative(X, dX, at_nodes);
      },
      dload);
  }


  template <int dim>
  void
  StructureForces<dim>::add_viscous_load(const Positions<dim> &X,
                                         const NodalField<dim> &U,
                                         NodalField<dim> &load) const
  {
    add(
      "viscous load",
      [&](const StructureForce<dim> &force, NodalField<dim> &at_nodes) {
        force.viscous_load(X, U, at_nodes);
      },
      load);
  }


  template <int dim>
  void
  StructureForces<dim>::add_external_load(const Positions<dim> &X, NodalField<dim> &load) const
  {
    add(
      "external load",
      [&](const StructureForce<dim> &force, NodalField<dim> &at_nodes) {
        force.external_load(X, at_nodes);
      },
      load);
  }


  template <int dim>
  void
  StructureForces<dim>::add_tangent(const Positions<dim> &X, MatrixEntries &entries) const
  {
    add_entries(
      "tangent",
      [&](const StructureForce<dim> &force, MatrixEntries &of_nodes) {
        force.tangent(X, of_nodes);
      },
      entries);
  }


  template <int dim>
  void
  StructureForces<dim>::add_viscous_tangent(const Positions<dim> &X, MatrixEntries &entries) const
  {
    add_entries(
      "viscous tangent",
      [&](const StructureForce<dim> &force, MatrixEntries &of_nodes) {
        force.viscous_tangent(X, of_nodes);
      },
      entries);
  }


  template <int dim>
  void
  StructureForces<dim>::archive(Archive &archive)
  {
    for (const auto &force : list)
      archive("force_" + force->name, *force);
  }


  template class StructureForces<2>;
  template class StructureForces<3>;
} // namespace feib
