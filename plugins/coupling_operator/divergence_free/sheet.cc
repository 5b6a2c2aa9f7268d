// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sheet.h"

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>

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
  std::vector<unsigned int>
  find_images(const Domain<dim> &domain, const LagrangianMesh<dim> &mesh, const Positions<dim> &X)
  {
    constexpr double near = 1e-6; // of the box
    std::vector<unsigned int> images(mesh.n_nodes());
    std::iota(images.begin(), images.end(), 0u);
    dealii::Point<dim> low = X[0], high = X[0];
    for (const dealii::Point<dim> &x : X)
      for (unsigned int a = 0; a < dim; ++a)
        {
          low[a]  = std::min(low[a], x[a]);
          high[a] = std::max(high[a], x[a]);
        }
    std::array<bool, dim> spans; // a whole period
    for (unsigned int a = 0; a < dim; ++a)
      spans[a] =
        domain.periodic(a) && high[a] - low[a] > (1 - near) * (domain.upper[a] - domain.lower[a]);
    if (std::find(spans.begin(), spans.end(), true) == spans.end())
      return images;

    // Numbers that are the same for images, and a sum of them to sort by.
    struct End
    {
      double key = 0;
      unsigned int node;
      std::array<double, 2 * dim> signature;
    };
    std::vector<End> ends;
    std::vector<bool> known(mesh.n_nodes(), false);
    for (const auto &face : mesh.faces())
      for (unsigned int v = 0; face.at_boundary() && v < mesh.structure_dim(); ++v)
        if (const unsigned int i = face.nodes[v]; !known[i])
          {
            known[i] = true;
            End end{0, i, {}};
            for (unsigned int a = 0; a < dim; ++a)
              {
                const double turns =
                  (X[i][a] - domain.lower[a]) / (domain.upper[a] - domain.lower[a]);
                const double angle       = 2 * dealii::numbers::PI * turns;
                end.signature[2 * a]     = spans[a] ? std::cos(angle) : turns;
                end.signature[2 * a + 1] = spans[a] ? std::sin(angle) : 0.;
                end.key += end.signature[2 * a] / (a + 1.3) + end.signature[2 * a + 1] / (a + 2.7);
              }
            ends.push_back(end);
          }
    std::sort(ends.begin(), ends.end(), [](const End &a, const End &b) { return a.key < b.key; });
    const std::vector<unsigned int> parts = mesh.parts();
    std::vector<unsigned int> part_of(mesh.n_nodes(), 0);
    for (unsigned int e = 0; e < parts.size(); ++e)
      for (unsigned int v = 0; v <= mesh.structure_dim(); ++v)
        part_of[mesh.elements()[e].nodes[v]] = parts[e];
    const auto first = [&](unsigned int i) {
      while (images[i] != i)
        i = images[i];
      return i;
    };
    for (auto e = ends.begin(); e != ends.end(); ++e)
      for (auto f = e; f != ends.begin() && e->key - std::prev(f)->key < 2 * dim * near;)
        {
          --f;
          double distance = 0;
          for (unsigned int k = 0; k < 2 * dim; ++k)
            distance = std::max(distance, std::abs(e->signature[k] - f->signature[k]));
          // Two ends at one place, or of different parts, are not one end.
          bool periods = false;
          for (unsigned int a = 0; a < dim; ++a)
            periods = periods || 2 * std::abs(X[e->node][a] - X[f->node][a]) >
                                   domain.upper[a] - domain.lower[a];
          if (distance < near && periods && part_of[e->node] == part_of[f->node])
            {
              const unsigned int i = first(e->node), j = first(f->node);
              images[std::max(i, j)] = std::min(i, j);
            }
        }
    for (unsigned int &image : images)
      image = first(image);
    return images;
  }


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


  template std::vector<unsigned int>
  find_images(const Domain<2> &, const LagrangianMesh<2> &, const Positions<2> &);
  template std::vector<Sheet<2>> find_sheets(const Domain<2> &,
                                             const LagrangianMesh<2> &,
                                             const Positions<2> &,
                                             const std::vector<unsigned int> &);
  template std::vector<unsigned int>
  find_images(const Domain<3> &, const LagrangianMesh<3> &, const Positions<3> &);
  template std::vector<Sheet<3>> find_sheets(const Domain<3> &,
                                             const LagrangianMesh<3> &,
                                             const Positions<3> &,
                                             const std::vector<unsigned int> &);
  template void set_flux_maps(std::vector<Sheet<2>> &, const Positions<2> &, bool);
  template void set_flux_maps(std::vector<Sheet<3>> &, const Positions<3> &, bool);
} // namespace feib
