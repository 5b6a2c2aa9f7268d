// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/position_fault.h>
#include <feib/message.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    using dealii::Point;
    using dealii::Tensor;

    template <int dim>
    std::string
    place(const Point<dim> &x)
    {
      std::string result;
      for (unsigned int a = 0; a < dim; ++a)
        result += (a ? ", " : "(") + readable(x[a]);
      return result + ")";
    }


    /// The edges from the first corner, as columns.
    template <int dim>
    Tensor<2, dim>
    edges_of(const typename LagrangianMesh<dim>::Element &element, const Positions<dim> &X)
    {
      Tensor<2, dim> edges;
      for (unsigned int k = 0; k < dim; ++k)
        for (unsigned int a = 0; a < dim; ++a)
          edges[a][k] = X[element.nodes[k + 1]][a] - X[element.nodes[0]][a];
      return edges;
    }


    /// Of a curve or surface: segments beside the longest, triangles beside their longest edge.
    template <int dim>
    std::string
    collapse(const LagrangianMesh<dim> &mesh, const Positions<dim> &X)
    {
      const bool curve = mesh.structure_dim() == 1;
      double longest   = 0;
      if (curve)
        for (const auto &element : mesh.elements())
          longest = std::max(longest, mesh.measure(element, X));
      for (const auto &element : mesh.elements())
        if (!(mesh.measure(element, X) >
              (curve ? 1e-12 * longest : 1e-7 * std::pow(mesh.longest_edge(element, X), 2))))
          return std::string("makes a ") + (curve ? "point" : "line") + " of element " +
                 std::to_string(element.number) + " at the reference place " +
                 place(element.centroid);
      return "";
    }


    template <int dim>
    std::string
    fold(const LagrangianMesh<dim> &mesh, const Positions<dim> &X)
    {
      const auto &elements                                 = mesh.elements();
      constexpr unsigned int none                          = -1;
      std::array<unsigned int, 2> n                        = {{0, 0}}; // of each sense
      std::array<unsigned int, 2> first                    = {{none, none}};
      const typename LagrangianMesh<dim>::Element *element = nullptr;
      for (unsigned int e = 0; e < elements.size(); ++e)
        {
          element                    = &elements[e];
          const Tensor<2, dim> edges = edges_of<dim>(*element, X);
          const double size          = determinant(edges);
          if (!(std::abs(size) > 1e-12 * std::pow(edges.norm(), dim)))
            return "flattens element " + std::to_string(element->number) +
                   " at the reference place " + place(element->centroid);
          if (n[size < 0]++ == 0)
            first[size < 0] = e;
        }
      if (n[0] == 0 || n[1] == 0)
        return "";
      const bool fewer = n[1] <= n[0];
      element          = &elements[first[fewer]];
      return "folds the body: " + std::to_string(n[fewer]) + " of its " +
             std::to_string(elements.size()) +
             " elements are turned over against the others, as element " +
             std::to_string(element->number) + " at the reference place " +
             place(element->centroid) + "; all must have the same sense";
    }


    /// The elements of a body by the boxes of a grid that they touch.
    template <int dim>
    class Grid
    {
    public:
      Grid(const LagrangianMesh<dim> &mesh, const Positions<dim> &X)
        : mesh(mesh)
        , X(X)
      {
        Point<dim> upper = X[0];
        lower            = X[0];
        for (const Point<dim> &x : X)
          for (unsigned int a = 0; a < dim; ++a)
            {
              lower[a] = std::min(lower[a], x[a]);
              upper[a] = std::max(upper[a], x[a]);
            }
        // About one element in a box.
        double volume = 1;
        for (unsigned int a = 0; a < dim; ++a)
          volume *= upper[a] - lower[a];
        size              = std::pow(volume / mesh.n_elements(), 1. / dim);
        std::size_t n_all = 1;
        for (unsigned int a = 0; a < dim; ++a)
          {
            n[a] = 1 + static_cast<unsigned int>(
                         std::min<double>((upper[a] - lower[a]) / size, mesh.n_elements()));
            n_all *= n[a];
          }
        boxes.resize(n_all);
        for (unsigned int e = 0; e < mesh.n_elements(); ++e)
          insert(e);
      }

      /// An element other than @p e that holds the centre of e; e when there is none.
      unsigned int
      covering(const unsigned int e) const
      {
        Point<dim> centre;
        for (unsigned int k = 0; k <= dim; ++k)
          centre += X[mesh.elements()[e].nodes[k]] / (dim + 1.);
        for (const unsigned int other : boxes[box(indices(centre))])
          if (other != e && holds(other, centre))
            return other;
        return e;
      }

    private:
      using Indices = std::array<unsigned int, dim>;

      Indices
      indices(const Point<dim> &x) const
      {
        Indices result;
        for (unsigned int a = 0; a < dim; ++a)
          result[a] =
            std::min(n[a] - 1, static_cast<unsigned int>(std::max(0., (x[a] - lower[a]) / size)));
        return result;
      }

      std::size_t
      box(const Indices &i) const
      {
        std::size_t result = 0;
        for (unsigned int a = dim; a-- > 0;)
          result = result * n[a] + i[a];
        return result;
      }

      void
      insert(const unsigned int e)
      {
        Point<dim> low = X[mesh.elements()[e].nodes[0]], high = low;
        for (unsigned int k = 1; k <= dim; ++k)
          for (unsigned int a = 0; a < dim; ++a)
            {
              low[a]  = std::min(low[a], X[mesh.elements()[e].nodes[k]][a]);
              high[a] = std::max(high[a], X[mesh.elements()[e].nodes[k]][a]);
            }
        const Indices first = indices(low), last = indices(high);
        for (Indices i = first; i[dim - 1] <= last[dim - 1];)
          {
            boxes[box(i)].push_back(e);
            for (unsigned int a = 0; a < dim; ++a)
              if (++i[a] <= last[a] || a + 1 == dim)
                break;
              else
                i[a] = first[a];
          }
      }

      bool
      holds(const unsigned int e, const Point<dim> &x) const
      {
        const auto &element       = mesh.elements()[e];
        const Tensor<1, dim> unit = invert(edges_of<dim>(element, X)) * (x - X[element.nodes[0]]);
        double rest               = 1;
        bool within               = true;
        for (unsigned int a = 0; a < dim; ++a)
          {
            within = within && unit[a] > 1e-6;
            rest -= unit[a];
          }
        return within && rest > 1e-6;
      }

      const LagrangianMesh<dim> &mesh;
      const Positions<dim> &X;
      Point<dim> lower;
      double size;
      std::array<unsigned int, dim> n;
      std::vector<std::vector<unsigned int>> boxes;
    };


    template <int dim>
    std::string
    overlap(const LagrangianMesh<dim> &mesh, const Positions<dim> &X)
    {
      const Grid<dim> grid(mesh, X);
      for (unsigned int e = 0; e < mesh.n_elements(); ++e)
        if (const unsigned int other = grid.covering(e); other != e)
          return "lets elements " + std::to_string(mesh.elements()[e].number) + " and " +
                 std::to_string(mesh.elements()[other].number) + " overlap at " +
                 place(X[mesh.elements()[e].nodes[0]]) +
                 ": a body fills a place once; what is meant to overlap must be two structures";
      return "";
    }
  } // namespace


  template <int dim>
  std::string
  position_fault(const LagrangianMesh<dim> &mesh, const Positions<dim> &X)
  {
    if (mesh.structure_dim() < dim)
      return collapse(mesh, X);
    const std::string folded = fold(mesh, X);
    return folded.empty() ? overlap(mesh, X) : folded;
  }


  template std::string position_fault(const LagrangianMesh<2> &, const Positions<2> &);
  template std::string position_fault(const LagrangianMesh<3> &, const Positions<3> &);
} // namespace feib
