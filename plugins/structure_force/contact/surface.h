// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_contact_surface_h
#define feib_contact_surface_h

#include <feib/domain.h>
#include <feib/error.h>
#include <feib/lagrangian_mesh.h>

#include "simplex.h"

#include <cmath>
#include <cstdint>
#include <set>
#include <unordered_map>

namespace feib
{
  /// The surface of a structure, its parts, and which of its nodes and facets are near each other
  /// in a box with periodic directions. Lengths and measures are those at the start.
  template <int dim>
  class ContactSurface
  {
  public:
    using Facet  = typename LagrangianMesh<dim>::Facet;
    using Vector = dealii::Tensor<1, dim>;

    /// @p self_distance: how far apart along the edges of the mesh nodes of one part must be to
    /// count as apart; infinite: they never do.
    ContactSurface(const LagrangianMesh<dim> &mesh,
                   const Positions<dim> &start,
                   const Domain<dim> &domain,
                   const double self_distance)
      : facets(mesh.surface())
      , measures(mesh.n_nodes(), 0.)
      , part(mesh.n_nodes(), 0)
      , edges(mesh.n_nodes())
      , lower(domain.lower)
      , beside(mesh.n_nodes())
      , within_parts(std::isfinite(self_distance))
    {
      for (unsigned int a = 0; a < dim; ++a)
        period[a] = domain.periodic(a) ? domain.upper[a] - domain.lower[a] : 0;
      const std::vector<unsigned int> parts = mesh.parts();
      for (unsigned int e = 0; e < parts.size(); ++e)
        for (unsigned int k = 0; k <= mesh.structure_dim(); ++k)
          part[mesh.elements()[e].nodes[k]] = parts[e];
      for (const Facet &facet : facets)
        {
          Vector normal;
          if constexpr (dim == 2)
            normal = cross_product_2d(start[facet[1]] - start[facet[0]]);
          else
            normal = cross_product_3d(start[facet[1]] - start[facet[0]],
                                      start[facet[2]] - start[facet[0]]) /
                     2;
          for (const unsigned int i : facet)
            {
              measures[i] += normal.norm() / dim;
              for (const unsigned int j : facet)
                if (i < j)
                  edges[i].push_back(j);
            }
        }
      for (unsigned int i = 0; i < measures.size(); ++i)
        {
          sort(edges[i]);
          if (measures[i] > 0)
            nodes.push_back(i);
        }
      if (within_parts)
        find_beside(mesh, start, self_distance);
    }

    const std::vector<Facet> facets;
    std::vector<double> measures;                 // that each node stands for, 0 within a body
    std::vector<unsigned int> nodes;              // those of the surface
    std::vector<unsigned int> part;               // of each node
    std::vector<std::vector<unsigned int>> edges; // of each node, to nodes of larger numbers

    double
    longest_edge(const Positions<dim> &X) const
    {
      double result = 0;
      for (const Facet &facet : facets)
        for (unsigned int k = 0; k < dim; ++k)
          result = std::max(result, X[facet[k]].distance(X[facet[(k + 1) % dim]]));
      return result;
    }

    /// What must be added to a facet for the image that is nearest to a place, when its first node
    /// is at @p corner.
    Vector
    shift(const dealii::Point<dim> &place, const dealii::Point<dim> &corner) const
    {
      Vector result;
      for (unsigned int a = 0; a < dim; ++a)
        if (period[a] > 0)
          result[a] = period[a] * std::round((place[a] - corner[a]) / period[a]);
      return result;
    }

    /// Whether a node and a facet, moved by a shift, are apart.
    bool
    apart(const unsigned int i, const Facet &facet, const Vector &shift) const
    {
      if (part[i] != part[facet[0]] || shift.norm_square() > 0)
        return true;
      return within_parts && std::none_of(facet.begin(), facet.end(), [&](const unsigned int j) {
               return std::binary_search(beside[i].begin(), beside[i].end(), j);
             });
    }

    /// Calls action(node, facet, shift) for nodes and facets that are apart, at least for all those
    /// within @p range of each other, nodes and facets in rising order. Returns the number of nodes
    /// and facets that were looked at.
    template <typename Action>
    std::size_t
    for_each_near(const Positions<dim> &X, const double range, const Action &action) const
    {
      for (const unsigned int i : nodes)
        if (!std::isfinite(X[i].square()))
          throw RunFailure("positions are not finite");
      const Cells cells(*this, X, range);
      std::size_t n = 0;
      for (const unsigned int i : nodes)
        if (const std::vector<unsigned int> *const found = cells.of(X[i]))
          for (const unsigned int f : *found)
            {
              ++n;
              const Vector moved = shift(X[i], X[facets[f][0]]);
              bool near          = true;
              for (unsigned int a = 0; a < dim && near; ++a)
                {
                  const auto [low, high] = extent(facets[f], X, a);
                  near = X[i][a] >= low + moved[a] - range && X[i][a] <= high + moved[a] + range;
                }
              if (near && apart(i, facets[f], moved))
                action(i, facets[f], moved);
            }
      return n;
    }

  private:
    /// The facets near each cell of a grid.
    class Cells
    {
    public:
      Cells(const ContactSurface &surface, const Positions<dim> &X, const double range)
        : surface(surface)
      {
        // A facet, however long, is in few cells.
        const double size = std::max(range, surface.longest_edge(X) / 4);
        for (unsigned int a = 0; a < dim; ++a)
          {
            width[a] = size;
            if (surface.period[a] > 0)
              {
                number[a] = std::max(1., std::min(1e6, std::floor(surface.period[a] / width[a])));
                width[a]  = surface.period[a] / number[a];
              }
          }
        for (unsigned int f = 0; f < surface.facets.size(); ++f)
          add(f, X, range);
      }

      const std::vector<unsigned int> *
      of(const dealii::Point<dim> &x) const
      {
        std::array<std::int64_t, dim> cell;
        for (unsigned int a = 0; a < dim; ++a)
          cell[a] = index(x[a], a);
        const auto found = lists.find(key(cell));
        return found == lists.end() ? nullptr : &found->second;
      }

    private:
      std::int64_t
      index(const double x, const unsigned int a) const
      {
        return std::clamp(std::floor((x - surface.lower[a]) / width[a]), -1e15, 1e15);
      }

      std::uint64_t
      key(const std::array<std::int64_t, dim> &cell) const
      {
        std::uint64_t result = 0;
        for (unsigned int a = 0; a < dim; ++a)
          {
            const std::int64_t n = number[a], wrapped = n > 0 ? (cell[a] % n + n) % n : cell[a];
            result = result << 21 ^ (static_cast<std::uint64_t>(wrapped) & 0x1fffff);
          }
        return result;
      }

      void
      add(const unsigned int f, const Positions<dim> &X, const double range)
      {
        std::array<std::int64_t, dim> first, last, cell;
        for (unsigned int a = 0; a < dim; ++a)
          {
            const auto [low, high] = extent(surface.facets[f], X, a);
            first[a]               = index(low - range, a);
            last[a]                = index(high + range, a);
            if (number[a] > 0)
              last[a] = std::min<std::int64_t>(last[a], first[a] + number[a] - 1);
          }
        for (cell = first; cell[dim - 1] <= last[dim - 1];)
          {
            lists[key(cell)].push_back(f);
            unsigned int a = 0;
            for (++cell[0]; a + 1 < dim && cell[a] > last[a]; ++cell[++a])
              cell[a] = first[a];
          }
      }

      const ContactSurface &surface;
      std::array<double, dim> width, number{}; // number of cells in periodic directions, else 0
      std::unordered_map<std::uint64_t, std::vector<unsigned int>> lists;
    };

    /// Each once.
    static void
    sort(std::vector<unsigned int> &list)
    {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }

    static std::pair<double, double>
    extent(const Facet &facet, const Positions<dim> &X, const unsigned int a)
    {
      std::pair<double, double> result{X[facet[0]][a], X[facet[0]][a]};
      for (const unsigned int i : facet)
        result = {std::min(result.first, X[i][a]), std::max(result.second, X[i][a])};
      return result;
    }

    /// Fills `beside`, along the edges of all elements (Dijkstra).
    void
    find_beside(const LagrangianMesh<dim> &mesh, const Positions<dim> &start, const double distance)
    {
      std::vector<std::vector<unsigned int>> neighbours(mesh.n_nodes());
      for (const auto &element : mesh.elements())
        for (unsigned int k = 0; k <= mesh.structure_dim(); ++k)
          for (unsigned int l = 0; l <= mesh.structure_dim(); ++l)
            if (k != l)
              neighbours[element.nodes[k]].push_back(element.nodes[l]);
      for (auto &list : neighbours)
        sort(list);
      std::vector<double> way(mesh.n_nodes(), std::numeric_limits<double>::infinity());
      for (const unsigned int i : nodes)
        {
          std::set<std::pair<double, unsigned int>> front{{0., i}};
          way[i] = 0;
          std::vector<unsigned int> reached{i};
          while (!front.empty())
            {
              const unsigned int j = front.begin()->second;
              front.erase(front.begin());
              for (const unsigned int k : neighbours[j])
                if (const double longer = way[j] + start[j].distance(start[k]);
                    longer < way[k] && longer <= distance)
                  {
                    if (std::isinf(way[k]))
                      reached.push_back(k);
                    front.erase({way[k], k});
                    way[k] = longer;
                    front.insert({longer, k});
                  }
            }
          for (const unsigned int j : reached)
            {
              way[j] = std::numeric_limits<double>::infinity();
              if (measures[j] > 0)
                beside[i].push_back(j);
            }
          sort(beside[i]);
        }
    }

    dealii::Point<dim> lower;
    std::array<double, dim> period;                // 0: none
    std::vector<std::vector<unsigned int>> beside; // of each node, those of its part nearby; sorted
    bool within_parts;
  };
} // namespace feib

#endif
