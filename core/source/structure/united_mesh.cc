// SPDX-License-Identifier: LGPL-2.1-or-later
#include "united_mesh.h"

#include "mesh_builder.h"

#include <limits>
#include <set>

namespace feib
{
  namespace
  {
    using dealii::Point;
    using dealii::Tensor;

    /// Element data of all meshes, not a number where one has none of a name.
    template <int dim>
    typename LagrangianMesh<dim>::ElementData
    united_data(const std::vector<LagrangianMesh<dim>> &meshes)
    {
      constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
      const Tensor<1, 3> unknown({nothing, nothing, nothing});
      typename LagrangianMesh<dim>::ElementData result;
      unsigned int n = 0;
      for (const LagrangianMesh<dim> &mesh : meshes)
        {
          for (const auto &[name, values] : mesh.element_data())
            {
              auto &all = result[name];
              all.resize(n, unknown);
              all.insert(all.end(), values.begin(), values.end());
            }
          n += mesh.n_elements();
        }
      for (auto &[name, all] : result)
        all.resize(n, unknown);
      return result;
    }
  } // namespace


  template <int dim>
  LagrangianMesh<dim>
  united_mesh(const std::vector<LagrangianMesh<dim>> &meshes, const std::vector<std::string> &names)
  {
    const unsigned int m = meshes.front().structure_dim();
    Builder<dim> builder(meshes.front().communicator());
    std::vector<typename LagrangianMesh<dim>::Remark> remarks;
    typename LagrangianMesh<dim>::MaterialNames materials;
    for (unsigned int p = 0; p < meshes.size(); ++p)
      {
        const unsigned int first = builder.nodes.size();
        for (const Point<dim> &place : meshes[p].nodes())
          builder.node(place);
        for (const auto &element : meshes[p].elements())
          {
            builder.simplices.emplace_back();
            builder.simplices.back().material_id = p;
            for (unsigned int k = 0; k <= m; ++k)
              {
                builder.simplices.back().nodes[k]   = first + element.nodes[k];
                builder.simplices.back().corners[k] = meshes[p].corner(element, k);
              }
          }
        for (auto remark : meshes[p].remarks())
          {
            remark.text = "of its part \"" + names[p] + "\": " + remark.text;
            remarks.push_back(remark);
          }
        std::set<unsigned int> own;
        for (const auto &element : meshes[p].elements())
          own.insert(element.material_id);
        if (own.size() > 1)
          remarks.push_back({"groups",
                             double(own.size()),
                             "its part \"" + names[p] + "\" has " + std::to_string(own.size()) +
                               " materials of its own, which are not kept: each part is one"});
        materials[names[p]] = p;
      }
    LagrangianMesh<dim> result = builder.build(m);
    result.set_material_names(materials);
    result.set_element_data(united_data(meshes));
    for (const auto &remark : remarks)
      result.add_remark(remark);
    return result;
  }

  template LagrangianMesh<2> united_mesh(const std::vector<LagrangianMesh<2>> &,
                                         const std::vector<std::string> &);
  template LagrangianMesh<3> united_mesh(const std::vector<LagrangianMesh<3>> &,
                                         const std::vector<std::string> &);
} // namespace feib
