// SPDX-License-Identifier: LGPL-2.1-or-later
#include "refined_mesh.h"

#include "mesh_builder.h"

#include <map>

namespace feib
{
  namespace
  {
    using Numbers = std::vector<unsigned int>;

    /// Which edge a middle is of: its two corners.
    constexpr std::array<std::array<unsigned int, 2>, 6> edges = {
      {{{0, 1}}, {{0, 2}}, {{1, 2}}, {{0, 3}}, {{1, 3}}, {{2, 3}}}};

    /// The parts of a simplex of dimension m; 0 to m are its corners, m + 1 + i the middle of edge
    /// i. Tetrahedra after J. Bey, Computing 55 (1995) 355: none of their descendants degenerates.
    std::vector<Numbers>
    parts(const unsigned int m)
    {
      if (m == 1)
        return {{0, 2}, {2, 1}};
      if (m == 2)
        return {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}, {3, 5, 4}};
      return {{0, 4, 5, 7},
              {4, 1, 6, 8},
              {5, 6, 2, 9},
              {7, 8, 9, 3},
              {4, 5, 7, 8},
              {4, 5, 6, 8},
              {5, 7, 8, 9},
              {5, 6, 8, 9}};
    }
  } // namespace


  template <int dim>
  LagrangianMesh<dim>
  refined_mesh(const LagrangianMesh<dim> &mesh)
  {
    const unsigned int m = mesh.structure_dim(), n_edges = m * (m + 1) / 2;
    Builder<dim> builder(mesh.communicator());
    builder.nodes = mesh.nodes();
    std::map<std::pair<unsigned int, unsigned int>, unsigned int> middles;
    const std::vector<Numbers> parts_of_each = parts(m);
    for (const auto &element : mesh.elements())
      {
        std::vector<dealii::Point<dim>> places;
        Numbers nodes(element.nodes.begin(), element.nodes.begin() + m + 1);
        for (unsigned int k = 0; k <= m; ++k)
          places.push_back(mesh.corner(element, k));
        for (unsigned int i = 0; i < n_edges; ++i)
          {
            const auto [a, b] = edges[i];
            places.push_back(places[a] + .5 * (places[b] - places[a]));
            const auto [found, is_new] =
              middles.try_emplace(std::minmax(nodes[a], nodes[b]), builder.nodes.size());
            if (is_new)
              builder.node(places.back());
            nodes.push_back(found->second);
          }
        for (const Numbers &part : parts_of_each)
          {
            builder.simplices.emplace_back();
            builder.simplices.back().material_id = element.material_id;
            for (unsigned int k = 0; k <= m; ++k)
              {
                builder.simplices.back().nodes[k]   = nodes[part[k]];
                builder.simplices.back().corners[k] = places[part[k]];
              }
          }
      }
    LagrangianMesh<dim> result = builder.build(m);
    result.set_material_names(mesh.material_names());
    typename LagrangianMesh<dim>::ElementData data;
    for (const auto &[name, values] : mesh.element_data())
      for (const auto &value : values)
        data[name].insert(data[name].end(), parts_of_each.size(), value);
    result.set_element_data(data);
    for (const auto &remark : mesh.remarks())
      result.add_remark(remark);
    return result;
  }

  template LagrangianMesh<2> refined_mesh(const LagrangianMesh<2> &);
  template LagrangianMesh<3> refined_mesh(const LagrangianMesh<3> &);
} // namespace feib
