// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/cartesian_forest.h>

#include <deal.II/grid/tria_accessor.h>
#include <deal.II/grid/tria_iterator.h>

#include <cmath>

namespace feib
{
  template <int dim>
  void
  CartesianForest<dim>::rebuild(
    const dealii::parallel::distributed::Triangulation<dim> &triangulation,
    const dealii::Point<dim> &lower_corner,
    const dealii::Point<dim> &upper_corner,
    const std::array<unsigned int, dim> &cells,
    const std::array<bool, dim> &periodic_directions)
  {
    lower      = lower_corner;
    upper      = upper_corner;
    base_cells = cells;
    periodic   = periodic_directions;

    unsigned int n_base = 1;
    for (unsigned int a = 0; a < dim; ++a)
      {
        inverse_size[a] = base_cells[a] / (upper[a] - lower[a]);
        n_base *= base_cells[a];
      }

    std::vector<unsigned int> owned(triangulation.n_active_cells(), not_here);
    unsigned int n_owned = 0;
    for (const auto &cell : triangulation.active_cell_iterators())
      if (cell->is_locally_owned())
        owned[cell->active_cell_index()] = n_owned++;

    nodes.assign(n_base, Node{-1, not_here});

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

    for (const auto &cell : triangulation.cell_iterators_on_level(0))
      {
        const dealii::Point<dim> centre = cell->center();
        unsigned int index = 0, stride = 1;
        for (unsigned int a = 0; a < dim; ++a)
          {
            index += stride * static_cast<unsigned int>((centre[a] - lower[a]) * inverse_size[a]);
            stride *= base_cells[a];
          }
        enter(cell, index);
      }
  }


  template <int dim>
  bool
  CartesianForest<dim>::inside(const dealii::Point<dim> &x) const
  {
    for (unsigned int a = 0; a < dim; ++a)
      if (!(std::abs((x[a] - lower[a]) * inverse_size[a]) < 1e9) ||
          (!periodic[a] && !(x[a] >= lower[a] && x[a] <= upper[a])))
        return false;
    return true;
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
        double z = (x[a] - lower[a]) * inverse_size[a];
        if (periodic[a])
          z -= base_cells[a] * std::floor(z / base_cells[a]);
        // The upper end belongs to the last cell.
        const unsigned int i = std::min(static_cast<unsigned int>(z), base_cells[a] - 1);
        unit[a]              = z - i;
        index += stride * i;
        stride *= base_cells[a];
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


  template class CartesianForest<2>;
  template class CartesianForest<3>;
} // namespace feib
