// SPDX-License-Identifier: LGPL-2.1-or-later
#include "initial_state.h"

#include <feib/expression.h>
#include <feib/message.h>
#include <feib/reference_mesh.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace feib
{
  namespace
  {
    template <int dim>
    std::string
    text(const dealii::Point<dim> &place)
    {
      std::string result;
      for (unsigned int i = 0; i < dim; ++i)
        result += (i ? ", " : "") + readable(place[i]);
      return "(" + result + ")";
    }


    template <int dim>
    void
    set_materials(const Parameters &parameters, LagrangianMesh<dim> &mesh)
    {
      const auto material = parse_expressions<dim>(parameters, "material", 1, Variables::reference);
      std::vector<unsigned int> ids;
      for (const auto &element : mesh.elements())
        {
          const double id = material->value(element.centroid);
          if (!(id > -.5 && id < 1e9))
            parameters.fail("material",
                            "is " + readable(id) + " at the reference place " +
                              text(element.centroid) + "; it must be 0, 1, 2, ... there");
          ids.push_back(std::lround(id));
        }
      mesh.set_materials(ids);
    }


    /// Sets the positions of some nodes, those of the mesh in @p block, by the key
    /// "initial_position" of @p given.
    template <int dim>
    void
    place(const Parameters &given,
          const Parameters &block,
          const LagrangianMesh<dim> &mesh,
          const std::vector<unsigned int> &of_block,
          Positions<dim> &X)
    {
      const std::vector<dealii::Point<dim>> &nodes = mesh.nodes();
      auto [mesh_name, keys]                       = block.child("mesh").choice();
      if (mesh_name == "refined")
        std::tie(mesh_name, keys) = keys.child("mesh").choice();
      const bool glued = mesh_name == "closed_curve" || mesh_name == "periodic_strip";
      if (!given.has("initial_position"))
        {
          if (glued || mesh_name == "open_curve")
            block.fail("",
                       "lacks \"initial_position\": the reference coordinates of the mesh " +
                         mesh_name + " are not places");
          for (const unsigned int i : of_block)
            X[i] = nodes[i];
          return;
        }

      const auto X0 = parse_expressions<dim>(given, "initial_position", dim, Variables::reference);
      const auto position = [&X0](const dealii::Point<dim> &s) {
        dealii::Point<dim> x;
        for (unsigned int i = 0; i < dim; ++i)
          x[i] = X0->value(s, i);
        if (!std::isfinite(x.norm()))
          throw Error(X0->not_finite(MPI_COMM_SELF));
        return x;
      };
      double extent = 0;
      for (const unsigned int i : of_block)
        {
          X[i]   = position(nodes[i]);
          extent = std::max(extent, X[i].distance(X[of_block[0]]));
        }
      for (const unsigned int i : of_block)
        if (glued && nodes[i][0] == 0)
          {
            dealii::Point<dim> end = nodes[i];
            end[0]                 = keys.number("length");
            const double gap       = position(end).distance(X[i]);
            if (gap > 1e-6 * extent)
              given.fail("initial_position",
                         "does not close: s1 = 0 and s1 = " + readable(end[0]) +
                           " are the same place of the mesh " + mesh_name +
                           ", but their positions are " + readable(gap) +
                           " apart; the mesh of what reaches across a periodic box is " +
                           (mesh_name == "closed_curve" ? "open_curve" : "rectangle"));
          }
    }


    /// Of meshes of several parts each may say where it is.
    template <int dim>
    Positions<dim>
    initial_positions(const Parameters &parameters, const LagrangianMesh<dim> &mesh)
    {
      Positions<dim> X(mesh);
      const auto [mesh_name, block] = parameters.child("mesh").choice();
      std::vector<Parameters> parts{parameters};
      if (mesh_name == "parts")
        parts = block.children("meshes");
      std::vector<std::vector<unsigned int>> nodes(parts.size());
      std::vector<unsigned int> part_of(mesh.n_nodes(), 0);
      if (parts.size() > 1)
        for (const auto &element : mesh.elements())
          for (unsigned int k = 0; k <= mesh.structure_dim(); ++k)
            part_of[element.nodes[k]] = element.material_id;
      for (unsigned int i = 0; i < part_of.size(); ++i)
        nodes[part_of[i]].push_back(i);
      for (unsigned int p = 0; p < parts.size(); ++p)
        place(
          parts[p].has("initial_position") ? parts[p] : parameters, parts[p], mesh, nodes[p], X);
      return X;
    }
  } // namespace


  template <int dim>
  LagrangianMesh<dim>
  make_structure_mesh(const Parameters &parameters,
                      const unsigned int structure_dim,
                      Positions<dim> &positions)
  {
    LagrangianMesh<dim> mesh = make_reference_mesh<dim>(parameters.child("mesh"), structure_dim);
    positions                = initial_positions(parameters, mesh); // of each part by its material
    if (structure_dim == dim && parameters.has("material"))
      set_materials(parameters, mesh);
    mesh.orient_closed_parts(positions);
    return mesh;
  }


  template <int dim>
  NodalField<dim>
  initial_velocities(const Parameters &parameters,
                     const LagrangianMesh<dim> &mesh,
                     const bool heavy)
  {
    NodalField<dim> V(mesh);
    if (!parameters.has("initial_velocity"))
      return V;
    if (!heavy)
      parameters.fail("initial_velocity",
                      "needs an excess_density: without one the structure moves with "
                      "the fluid, whose initial_velocity it has");
    const auto V0 =
      parse_expressions<dim>(parameters, "initial_velocity", dim, Variables::reference);
    for (unsigned int i = 0; i < V.size(); ++i)
      for (unsigned int a = 0; a < dim; ++a)
        V[i][a] = V0->value(mesh.nodes()[i], a);
    if (const Issues issues = V0->not_finite(MPI_COMM_SELF); !issues.empty())
      throw Error(issues);
    return V;
  }


  template <int dim>
  std::vector<double>
  lumped_masses(const Parameters &parameters, const LagrangianMesh<dim> &mesh)
  {
    const auto density =
      parse_expressions<dim>(parameters, "excess_density", 1, Variables::reference);
    const unsigned int m = mesh.structure_dim();
    std::vector<double> masses(mesh.n_nodes(), 0.);
    bool heavy = false;
    for (const auto &element : mesh.elements())
      {
        const double value = density->value(element.centroid);
        heavy              = heavy || value != 0;
        if (value < 0 && m < dim)
          parameters.fail(
            "excess_density",
            "is " + readable(value) + " at the reference place " + text(element.centroid) +
              "; a curve or surface displaces no fluid, so it must not be less than 0");
        for (unsigned int k = 0; k <= m; ++k)
          masses[element.nodes[k]] += value * element.measure / (m + 1);
      }
    if (const Issues issues = density->not_finite(MPI_COMM_SELF); !issues.empty())
      throw Error(issues);
    return heavy ? masses : std::vector<double>();
  }


  template LagrangianMesh<2> make_structure_mesh(const Parameters &, unsigned int, Positions<2> &);
  template LagrangianMesh<3> make_structure_mesh(const Parameters &, unsigned int, Positions<3> &);
  template NodalField<2> initial_velocities(const Parameters &, const LagrangianMesh<2> &, bool);
  template NodalField<3> initial_velocities(const Parameters &, const LagrangianMesh<3> &, bool);
  template std::vector<double> lumped_masses(const Parameters &, const LagrangianMesh<2> &);
  template std::vector<double> lumped_masses(const Parameters &, const LagrangianMesh<3> &);
} // namespace feib
