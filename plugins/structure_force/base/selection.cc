// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/expression.h>
#include <feib/message.h>
#include <feib/structure_force/selection.h>

#include <algorithm>
#include <string>
#include <utility>

namespace feib
{
  namespace
  {
    /// The ids of the materials asked for: what the mesh's file calls so, else numbers.
    template <int dim>
    std::vector<unsigned int>
    materials_of(const Parameters &on, const LagrangianMesh<dim> &mesh)
    {
      std::vector<unsigned int> ids;
      for (const std::string &material : on.expressions("materials"))
        if (const auto named = mesh.material_names().find(material);
            named != mesh.material_names().end())
          ids.push_back(named->second);
        else if (material.find_first_not_of("0123456789") == std::string::npos &&
                 !material.empty() && material.size() < 10)
          ids.push_back(std::stoul(material));
        else
          {
            std::string known;
            for (const auto &[name, id] : mesh.material_names())
              known += (known.empty() ? "" : ", ") + ('"' + readable(name) + '"');
            on.fail("materials/" + std::to_string(ids.size()),
                    "found \"" + readable(material) + "\"; the materials of the mesh have " +
                      (known.empty() ? "no names" : "the names " + known));
          }
      return ids;
    }


    /// Whether each element is of the materials asked for.
    template <int dim>
    std::vector<bool>
    elements_of(const Parameters &on, const LagrangianMesh<dim> &mesh)
    {
      if (!on.has("materials"))
        return std::vector<bool>(mesh.n_elements(), true);
      std::vector<bool> chosen(mesh.n_elements(), false);
      const std::vector<unsigned int> materials = materials_of(on, mesh);
      for (unsigned int k = 0; k < materials.size(); ++k)
        {
          bool found = false;
          for (unsigned int e = 0; e < chosen.size(); ++e)
            if (mesh.elements()[e].material_id == materials[k])
              chosen[e] = found = true;
          if (!found)
            on.fail("materials/" + std::to_string(k),
                    "found " + std::to_string(materials[k]) +
                      ", but no element of the structure has this material");
        }
      return chosen;
    }


    /// Whether each node is where the expression says.
    template <int dim>
    std::vector<bool>
    nodes_where(const Parameters &on, const LagrangianMesh<dim> &mesh)
    {
      std::vector<bool> chosen(mesh.n_nodes(), true);
      if (!on.has("where"))
        return chosen;
      const auto where = parse_expressions<dim>(on, "where", 1, Variables::reference);
      for (unsigned int i = 0; i < chosen.size(); ++i)
        chosen[i] = where->value(mesh.nodes()[i]) != 0;
      if (const Issues issues = where->not_finite(MPI_COMM_SELF); !issues.empty())
        throw Error(issues);
      return chosen;
    }
  } // namespace


  template <int dim>
  Selection<dim>::Selection(const Parameters &parameters, const LagrangianMesh<dim> &mesh)
    : node_measures(mesh.n_nodes(), 0.)
  {
    const Parameters on               = parameters.child("on");
    const std::vector<bool> materials = elements_of(on, mesh), chosen = nodes_where(on, mesh);
    const unsigned int m = mesh.structure_dim();
    if (!on.boolean("boundary"))
      for (unsigned int e = 0; e < mesh.n_elements(); ++e)
        {
          const auto &element = mesh.elements()[e];
          if (materials[e])
            add(chosen, {element.nodes, m + 1, element.measure});
        }
    else
      for (const auto &face : mesh.faces())
        {
          if (!face.at_boundary() || !materials[face.elements[0]])
            continue;
          const auto &element = mesh.elements()[face.elements[0]];
          // The elements of a body are of positive measure: what is left without vertex k has its
          // normal outward for even k.
          const unsigned int k = face.opposite[0];
          Part part{{}, m, m * element.measure * element.shape_gradients[k].norm()};
          unsigned int n = 0;
          for (unsigned int j = 0; j <= m; ++j)
            if (j != k)
              part.nodes[n++] = element.nodes[j];
          if (m == dim && k % 2 == 1)
            std::swap(part.nodes[0], part.nodes[1]);
          add(chosen, part);
        }
    if (std::all_of(node_measures.begin(), node_measures.end(), [](const double w) {
          return w == 0;
        }))
      parameters.fail("on",
                      on.boolean("boundary") && mesh.closed() && m < dim
                        ? "selects nothing: the structure is closed and has no boundary"
                        : "selects no node of the structure");
  }


  template <int dim>
  void
  Selection<dim>::add(const std::vector<bool> &chosen, const Part part)
  {
    bool all = true;
    for (unsigned int j = 0; j < part.n_nodes; ++j)
      if (chosen[part.nodes[j]])
        node_measures[part.nodes[j]] += part.measure / part.n_nodes;
      else
        all = false;
    if (all)
      part_list.push_back(part);
  }


  template class Selection<2>;
  template class Selection<3>;
} // namespace feib
