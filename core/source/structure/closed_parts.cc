// SPDX-License-Identifier: LGPL-2.1-or-later
#include "closed_parts.h"

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace feib
{
  namespace
  {
    using dealii::Point;
    using dealii::Tensor;

    /// A closed part of a curve or surface.
    template <int dim>
    struct Part
    {
      std::vector<std::array<unsigned int, dim>> facets;
      std::array<double, dim> low, high; // the box around it
      std::uint64_t number;              // of its first element
    };

    template <int dim>
    std::vector<Part<dim>>
    make_parts(const std::vector<unsigned int> &part_of,
               const LagrangianMesh<dim> &mesh,
               const Positions<dim> &X)
    {
      std::vector<Part<dim>> parts;
      for (unsigned int e = 0; e < part_of.size(); ++e)
        {
          if (part_of[e] == parts.size())
            {
              parts.emplace_back();
              parts.back().low.fill(std::numeric_limits<double>::max());
              parts.back().high.fill(std::numeric_limits<double>::lowest());
              parts.back().number = mesh.elements()[e].number;
            }
          Part<dim> &part = parts[part_of[e]];
          part.facets.push_back(mesh.surface()[e]);
          for (const unsigned int i : part.facets.back())
            for (unsigned int a = 0; a < dim; ++a)
              {
                part.low[a]  = std::min(part.low[a], X[i][a]);
                part.high[a] = std::max(part.high[a], X[i][a]);
              }
        }
      return parts;
    }

    /// How often a closed part goes round a place: the sum of the angles (3D: solid angles, by the
    /// formula of van Oosterom and Strackee) of its elements, over that of the circle or sphere.
    /// Not a number on the part itself.
    template <int dim>
    double
    winding_number(const Part<dim> &part, const Positions<dim> &X, const Point<dim> &place)
    {
      constexpr double pi = dealii::numbers::PI;
      double sum          = 0;
      for (const auto &nodes : part.facets)
        {
          Tensor<2, dim> v;
          double size = 1;
          for (unsigned int k = 0; k < dim; ++k)
            {
              v[k] = X[nodes[k]] - place;
              size *= v[k].norm();
            }
          double cosine = v[0] * v[1];
          if constexpr (dim == 3)
            cosine = size + (v[0] * v[1]) * v[2].norm() + (v[1] * v[2]) * v[0].norm() +
                     (v[2] * v[0]) * v[1].norm();
          const double angle = std::atan2(determinant(v), cosine);
          if (size == 0 || std::abs(angle) > pi - 1e-6)
            return std::numeric_limits<double>::quiet_NaN();
          sum += angle;
        }
      return sum / (2 * pi); // a solid angle is twice the angle summed
    }

    /// The share of some nodes of @p part, without those on @p other, that lies inside @p other.
    template <int dim>
    double
    share_inside(const Part<dim> &part, const Part<dim> &other, const Positions<dim> &X)
    {
      const std::size_t n   = std::min<std::size_t>(part.facets.size(), 32);
      unsigned int n_inside = 0, n_all = 0;
      for (std::size_t i = 0; i < n; ++i)
        {
          const Point<dim> &x = X[part.facets[i * part.facets.size() / n][0]];
          bool near           = true;
          for (unsigned int a = 0; a < dim; ++a)
            near = near && x[a] >= other.low[a] && x[a] <= other.high[a];
          const double turns = near ? std::abs(winding_number<dim>(other, X, x)) : 0;
          if (std::isnan(turns))
            continue;
          ++n_all;
          n_inside += turns > .5;
        }
      return n_all == 0 ? 0 : double(n_inside) / n_all;
    }

    /// The measure that a closed part encloses, positive when its normals point outward.
    template <int dim>
    double
    enclosed(const Part<dim> &part, const Positions<dim> &X)
    {
      double sum = 0;
      for (const auto &nodes : part.facets)
        {
          Tensor<2, dim> edges;
          for (unsigned int k = 0; k < dim; ++k)
            edges[k] = X[nodes[k]] - X[part.facets[0][0]];
          sum += determinant(edges) / (dim == 2 ? 2 : 6);
        }
      return sum;
    }
  } // namespace


  template <int dim>
  std::vector<bool>
  parts_to_turn(const LagrangianMesh<dim> &mesh,
                const std::vector<unsigned int> &part_of,
                const Positions<dim> &X,
                std::vector<typename LagrangianMesh<dim>::Remark> &remarks)
  {
    const std::vector<Part<dim>> all = make_parts<dim>(part_of, mesh, X);
    std::vector<bool> turned(all.size());
    for (unsigned int p = 0; p < all.size(); ++p)
      {
        turned[p] = enclosed<dim>(all[p], X) < 0;
        for (unsigned int q = 0; q < all.size(); ++q)
          {
            const double share = q == p ? 0 : share_inside<dim>(all[p], all[q], X);
            if (share > .5)
              turned[p] = !turned[p];
            if (share > 0 && share < 1)
              remarks.push_back(
                {"overlap",
                 share,
                 "its part of element " + std::to_string(all[p].number) +
                   " crosses that of element " + std::to_string(all[q].number) +
                   ": what they enclose is no area or volume that can be measured"});
          }
      }
    return turned;
  }


  template std::vector<bool> parts_to_turn(const LagrangianMesh<2> &,
                                           const std::vector<unsigned int> &,
                                           const Positions<2> &,
                                           std::vector<LagrangianMesh<2>::Remark> &);
  template std::vector<bool> parts_to_turn(const LagrangianMesh<3> &,
                                           const std::vector<unsigned int> &,
                                           const Positions<3> &,
                                           std::vector<LagrangianMesh<3>::Remark> &);
} // namespace feib
