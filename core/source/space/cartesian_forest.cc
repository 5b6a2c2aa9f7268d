// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/cartesian_forest.h>
#include <feib/domain.h>

#include <deal.II/grid/tria_accessor.h>
#include <deal.II/grid/tria_iterator.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    /// Splits a convex polygon (or segment) by the plane x_a = c. A part without extent is empty;
    /// what lies in the plane belongs to the upper part.
    template <class Polygon>
    void
    split(const Polygon &polygon,
          const unsigned int a,
          const double c,
          Polygon &below,
          Polygon &above)
    {
      below.clear();
      above.clear();
      bool any_below = false, any_above = false;
      for (const auto &corner : polygon)
        {
          any_below = any_below || corner.unit[a] < c;
          any_above = any_above || corner.unit[a] > c;
        }
      if (!any_below || !any_above)
        {
          (any_below ? below : above) = polygon;
          return;
        }
      const unsigned int n_edges = polygon.size() == 2 ? 1 : polygon.size();
      for (unsigned int i = 0; i < polygon.size(); ++i)
        {
          const auto &p = polygon[i];
          if (p.unit[a] <= c)
            below.push_back(p);
          if (p.unit[a] >= c)
            above.push_back(p);
          if (i == n_edges)
            continue;
          const auto &q = polygon[(i + 1) % polygon.size()];
          if ((p.unit[a] < c && q.unit[a] > c) || (p.unit[a] > c && q.unit[a] < c))
            {
              auto crossing  = p;
              const double t = (c - p.unit[a]) / (q.unit[a] - p.unit[a]);
              for (unsigned int b = 0; b < p.barycentric.size(); ++b)
                {
                  crossing.unit[b] += t * (q.unit[b] - p.unit[b]);
                  crossing.barycentric[b] += t * (q.barycentric[b] - p.barycentric[b]);
                }
              crossing.unit[a] = c;
              below.push_back(crossing);
              above.push_back(crossing);
            }
        }
    }
  } // namespace


  template <int dim>
  void
  CartesianForest<dim>::rebuild(
    const dealii::parallel::distributed::Triangulation<dim> &triangulation,
    const std::vector<typename dealii::Triangulation<dim>::active_cell_iterator> &owned_cells,
    const unsigned int base_level,
    const Domain<dim> &box)
  {
    base = Lattice<dim>(box, 0);
    for (unsigned int a = 0; a < dim; ++a)
      near[a] = base.periodic(a) ? 0. : round_off(box.lower[a], box.upper[a]) / base.unit()[a];

    std::vector<unsigned int> owned(triangulation.n_active_cells(), not_here);
    unsigned int n_owned = 0;
    for (const auto &cell : owned_cells)
      owned[cell->active_cell_index()] = n_owned++;

    nodes.assign(std::size_t(base.n_units()), Node{-1, not_here});

    // Descends from a base cell; the children of a node lie side by side, as deal.II numbers them.
    using Iterator = typename dealii::Triangulation<dim>::cell_iterator;
    const std::function<void(const Iterator &, unsigned int)> enter = [&](const Iterator &cell,
                                                                          const unsigned int node) {
      if (cell->has_children())
        {
          const unsigned int first = nodes.size();
          nodes[node].first_child  = first;
          nodes.resize(first + (1U << dim), Node{-1, not_here});
          for (unsigned int child = 0; child < (1U << dim); ++child)
            enter(cell->child(child), first + child);
        }
      else
        nodes[node].cell = owned[cell->active_cell_index()];
    };

    for (const auto &cell : triangulation.cell_iterators_on_level(base_level))
      {
        const auto place   = base.unit_around(cell->center());
        unsigned int index = 0, stride = 1;
        for (unsigned int a = 0; a < dim; ++a)
          {
            index += stride * place[a];
            stride *= base.extent(a);
          }
        enter(cell, index);
      }
  }


  template <int dim>
  bool
  CartesianForest<dim>::inside(const dealii::Point<dim> &x) const
  {
    for (unsigned int a = 0; a < dim; ++a)
      {
        const double z = coordinate(x, a);
        if (!(std::abs(z) < 1e9) || (!base.periodic(a) && !(z >= 0 && z <= base.extent(a))))
          return false;
      }
    return true;
  }


  template <int dim>
  double
  CartesianForest<dim>::coordinate(const dealii::Point<dim> &x, const unsigned int a) const
  {
    const double z = base.scaled(x[a], a);
    if (std::abs(z) <= near[a])
      return 0;
    if (std::abs(z - base.extent(a)) <= near[a])
      return base.extent(a);
    return z;
  }


  template <int dim>
  unsigned int
  CartesianForest<dim>::locate(const dealii::Point<dim> &x, dealii::Point<dim> &unit) const
  {
    if (!inside(x))
      return not_here;

    unsigned int index = 0, stride = 1;
    for (unsigned int a = 0; a < dim; ++a)
      {
        double z = coordinate(x, a);
        if (base.periodic(a))
          z -= base.extent(a) * std::floor(z / base.extent(a));
        // The upper end belongs to the last cell.
        const unsigned int i = std::min(static_cast<std::int64_t>(z), base.extent(a) - 1);
        unit[a]              = z - i;
        index += stride * i;
        stride *= base.extent(a);
      }

    while (nodes[index].first_child >= 0)
      {
        unsigned int child = 0;
        for (unsigned int a = 0; a < dim; ++a)
          {
            unit[a] *= 2;
            if (unit[a] >= 1)
              {
                unit[a] -= 1;
                child += 1U << a;
              }
          }
        index = nodes[index].first_child + child;
      }
    return nodes[index].cell;
  }


  template <int dim>
  void
  CartesianForest<dim>::cut(const std::array<dealii::Point<dim>, dim> &facet,
                            const VisitPiece &visit) const
  {
    Polygon polygon(dim);
    for (unsigned int k = 0; k < dim; ++k)
      {
        for (unsigned int a = 0; a < dim; ++a)
          polygon[k].unit[a] = coordinate(facet[k], a);
        polygon[k].barycentric.fill(0);
        polygon[k].barycentric[k] = 1;
      }
    cut_base(polygon, 0, 0, 1, visit);
  }


  template <int dim>
  void
  CartesianForest<dim>::cut_base(const Polygon &polygon,
                                 const unsigned int a,
                                 const unsigned int index,
                                 const unsigned int stride,
                                 const VisitPiece &visit) const
  {
    if (a == dim)
      {
        cut_node(polygon, index, visit);
        return;
      }
    const auto [least, largest] =
      std::minmax_element(polygon.begin(), polygon.end(), [a](const Corner &p, const Corner &q) {
        return p.unit[a] < q.unit[a];
      });
    const int n    = base.extent(a);
    int first      = std::floor(least->unit[a]);
    const int last = std::max(first, int(std::ceil(largest->unit[a])) - 1);
    Polygon rest   = polygon, part, above;
    for (int i = first; i <= last; ++i)
      {
        if (i < last)
          {
            split(rest, a, i + 1., part, above);
            rest.swap(above);
          }
        else
          part.swap(rest);
        // What lies in the upper end of the box belongs to the last cell; ends overstepped by
        // round-off too.
        const int cell =
          base.periodic(a) ? i - n * int(std::floor(double(i) / n)) : std::clamp(i, 0, n - 1);
        for (Corner &corner : part)
          corner.unit[a] -= base.periodic(a) ? i : cell;
        cut_base(part, a + 1, index + stride * cell, stride * n, visit);
      }
  }


  template <int dim>
  void
  CartesianForest<dim>::cut_node(const Polygon &polygon,
                                 const unsigned int index,
                                 const VisitPiece &visit) const
  {
    if (nodes[index].first_child < 0)
      {
        if (nodes[index].cell != not_here)
          visit(nodes[index].cell, dealii::make_array_view(polygon));
        return;
      }
    std::array<Polygon, 1 << dim> parts;
    parts[0] = polygon;
    Polygon whole;
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int child = 0; child < (1U << a); ++child)
        {
          whole.swap(parts[child]);
          if (!whole.empty())
            split(whole, a, .5, parts[child], parts[child + (1U << a)]);
          else
            parts[child].clear();
        }
    for (unsigned int child = 0; child < (1U << dim); ++child)
      if (!parts[child].empty())
        {
          for (Corner &corner : parts[child])
            for (unsigned int a = 0; a < dim; ++a)
              corner.unit[a] = 2 * corner.unit[a] - (child >> a & 1U);
          cut_node(parts[child], nodes[index].first_child + child, visit);
        }
  }


  template class CartesianForest<2>;
  template class CartesianForest<3>;
} // namespace feib
