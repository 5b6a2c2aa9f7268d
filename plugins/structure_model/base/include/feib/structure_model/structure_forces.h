// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_model_structure_forces_h
#define feib_structure_model_structure_forces_h

#include <feib/lagrangian_points.h>
#include <feib/structure_force.h>

#include <memory>
#include <string>
#include <vector>

namespace feib
{
  /// All that acts on a structure beside its law, as one. Loads and entries are added at the load
  /// points of the structure, among which are its nodes. What a force throws on any rank, or values
  /// that are not finite, is a RunFailure on all that names the force. All functions of X are
  /// collective.
  template <int dim>
  class StructureForces
  {
  public:
    using List      = std::vector<std::unique_ptr<StructureForce<dim>>>;
    using Stiffness = typename StructureForce<dim>::Stiffness;

    /// None. @p points: the load points. All arguments must outlive the object.
    StructureForces(const LagrangianMesh<dim> &mesh,
                    const std::string &structure_name,
                    LagrangianPoints &points);

    /// Adds the nodes to the load points, where these are others.
    void set(List list);

    bool empty() const;
    bool linear() const;
    bool viscous() const;
    bool external() const;

    std::vector<std::string> names() const;
    std::vector<double> energies(const Positions<dim> &X) const;

    /// At the nodes, the load of each at X, the viscous and external ones at the @p geometry.
    std::vector<NodalField<dim>>
    loads(const Positions<dim> &X, const Positions<dim> &geometry, const NodalField<dim> &U) const;

    Stiffness stiffness(const Positions<dim> &X) const;

    void set_moment(double time, double elapsed);
    void update_state(const Positions<dim> &X);

    void add_load(const Positions<dim> &X, NodalField<dim> &load) const;
    void add_load_derivative(const Positions<dim> &X,
                             const NodalField<dim> &dX,
                             NodalField<dim> &dload) const;
    void add_viscous_load(const Positions<dim> &X,
                          const NodalField<dim> &U,
                          NodalField<dim> &load) const;
    void add_external_load(const Positions<dim> &X, NodalField<dim> &load) const;

    void add_tangent(const Positions<dim> &X, MatrixEntries &entries) const;
    void add_viscous_tangent(const Positions<dim> &X, MatrixEntries &entries) const;

    void archive(Archive &archive);

  private:
    bool any(bool (StructureForce<dim>::*property)() const) const;

    /// Calls action(force) for each.
    template <typename Action>
    void for_each(const char *what, const Action &action) const;

    /// Adds what action(force, load at the nodes) adds.
    template <typename Action>
    void add(const char *what, const Action &action, NodalField<dim> &load) const;

    /// Adds entries that action(force, entries) gives for nodes.
    template <typename Action>
    void add_entries(const char *what, const Action &action, MatrixEntries &entries) const;

    const LagrangianMesh<dim> &mesh;
    const std::string &structure_name;
    LagrangianPoints &points;
    List list;
    unsigned int first_point = 0; // where the nodes begin among the load points
  };
} // namespace feib

#endif
