// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/periodic_images.h>

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

namespace feib
{
  template <int dim>
  std::vector<unsigned int>
  periodic_images(const Domain<dim> &domain,
                  const LagrangianMesh<dim> &mesh,
                  const Positions<dim> &X)
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

  template std::vector<unsigned int>
  periodic_images(const Domain<2> &, const LagrangianMesh<2> &, const Positions<2> &);
  template std::vector<unsigned int>
  periodic_images(const Domain<3> &, const LagrangianMesh<3> &, const Positions<3> &);
} // namespace feib
