// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sheet.h"

#include <algorithm>
#include <map>

namespace feib
{
  namespace
  {
    /// The vector area of a segment or triangle.
    template <int dim>
    dealii::Tensor<1, dim>
    vector_area(const std::array<unsigned int, dim> &facet, const Positions<dim> &X)
    {
      const dealii::Tensor<1, dim> edge = X[facet[1]] - X[facet[0]];
      if constexpr (dim == 2)
        return cross_product_2d(edge);
      else
        return .5 * cross_product_3d(edge, X[facet[2]] - X[facet[0]]);
    }
  } // namespace


  template <int dim>
  std::vector<Sheet<dim>>
  find_sheets(const Domain<dim> &domain,
              const LagrangianMesh<dim> &mesh,
              const Positions<dim> &X,
              const std::vector<unsigned int> &images)
  {
    using Facet         = typename Sheet<dim>::Facet;
    const auto nodes_of = [&](Facet facet) {
      for (unsigned int &node : facet)
        node = images[node];
      return facet;
    };
    // Two faces of a body that are images of each other are inside it.
    const auto sorted = [&](const Facet &facet) {
      Facet nodes = nodes_of(facet);
      std::sort(nodes.begin(), nodes.end());
      return nodes;
    };
    bool continues = false;
    for (unsigned int i = 0; i < images.size() && mesh.structure_dim() == dim; ++i)
      continues = continues || images[i] != i;
    std::map<Facet, unsigned int> n_faces;
    if (continues)
      for (const auto &facet : mesh.surface())
        ++n_faces[sorted(facet)];

    std::vector<Sheet<dim>> result;
    std::vector<bool> outer(mesh.n_nodes(), false);
    for (const auto &facet : mesh.surface())
      {
        if (continues && n_faces[sorted(facet)] > 1)
          continue;
        result.push_back({facet, nodes_of(facet), {}, {}, {}});
        for (unsigned int v = 0; v < dim; ++v)
          {
            const std::array<bool, dim> held = domain.held(X[facet[v]]);
            result.back().at_wall[v]      = std::find(held.begin(), held.end(), true) != held.end();
            result.back().moves[v]        = !result.back().at_wall[v];
            outer[result.back().nodes[v]] = true;
          }
      }
    for (const auto &facet : mesh.interfaces())
      {
        result.push_back({facet, nodes_of(facet), {}, {}, {}});
        for (unsigned int v = 0; v < dim; ++v)
          result.back().moves[v] = !outer[result.back().nodes[v]];
      }
    return result;
  }


  template <int dim>
  void
  set_flux_maps(std::vector<Sheet<dim>> &sheets, const Positions<dim> &X, const bool flux_exact)
  {
    // Sums over all facets around a node: every rank has them all.
    std::vector<dealii::Tensor<1, dim>> normals(sheets.size()), sums(X.size());
    std::vector<double> areas(X.size(), 0.);
    std::vector<unsigned int> n_facets(X.size(), 0);
    for (unsigned int k = 0; k < sheets.size(); ++k)
      {
        normals[k] = vector_area<dim>(sheets[k].corners, X);
        for (unsigned int v = 0; v < dim; ++v)
          if (sheets[k].moves[v])
            {
              sums[sheets[k].nodes[v]] += normals[k] / dim;
              areas[sheets[k].nodes[v]] += normals[k].norm() / dim;
              ++n_facets[sheets[k].nodes[v]];
            }
      }

    // Where facets nearly fold back on each other N_i says nothing: the map would be large.
    constexpr double fold = 0.1;
    for (unsigned int k = 0; k < sheets.size(); ++k)
      for (unsigned int v = 0; v < dim; ++v)
        if (sheets[k].moves[v])
          {
            const unsigned int i             = sheets[k].nodes[v];
            const dealii::Tensor<1, dim> &N  = sums[i];
            const dealii::Tensor<1, dim> &nk = normals[k];
            dealii::Tensor<2, dim> &T        = sheets[k].maps[v];
            if (flux_exact && N.norm() > fold * areas[i])
              {
                const double square            = N.norm_square();
                const double a                 = nk * N / square;
                const dealii::Tensor<1, dim> t = nk - a * N;
                T = (outer_product(t, N) - outer_product(N, t)) / square;
                for (unsigned int c = 0; c < dim; ++c)
                  T[c][c] += a;
              }
            else
              for (unsigned int c = 0; c < dim; ++c)
                T[c][c] = areas[i] > 0 ? nk.norm() / areas[i] : double(dim) / n_facets[i];
          }
  }


  template std::vector<Sheet<2>> find_sheets(const Domain<2> &,
                                             const LagrangianMesh<2> &,
                                             const Positions<2> &,
                                             const std::vector<unsigned int> &);
  template std::vector<Sheet<3>> find_sheets(const Domain<3> &,
                                             const LagrangianMesh<3> &,
                                             const Positions<3> &,
                                             const std::vector<unsigned int> &);
  template void set_flux_maps(std::vector<Sheet<2>> &, const Positions<2> &, bool);
  template void set_flux_maps(std::vector<Sheet<3>> &, const Positions<3> &, bool);
} // namespace feib
