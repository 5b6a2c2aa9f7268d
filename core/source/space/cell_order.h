// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_cell_order_h
#define feib_cell_order_h

#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_handler.h>

#include <vector>

namespace feib
{
  /// The locally owned active cells in the order of the forest: along the curve by which p4est
  /// divides them between ranks. Unlike the order of active_cell_iterators() it does not depend on
  /// how the mesh came to be what it is; the cells of rank after rank are those of one rank.
  template <int dim>
  std::vector<typename dealii::Triangulation<dim>::active_cell_iterator>
  cells_in_order(const dealii::parallel::distributed::Triangulation<dim> &mesh);

  /// The same cell, with its unknowns.
  template <int dim>
  typename dealii::DoFHandler<dim>::active_cell_iterator
  in_handler(const typename dealii::Triangulation<dim>::active_cell_iterator &cell,
             const dealii::DoFHandler<dim> &handler)
  {
    return {&handler.get_triangulation(), cell->level(), cell->index(), &handler};
  }

  /// A place in that order, and how often a tree was split there: the cells below a cell have keys
  /// from its own up to key + size.
  struct CellKey
  {
    std::uint64_t tree, path; // the children taken, as if all cells were of the deepest level
    unsigned int level;

    bool
    operator<(const CellKey &other) const
    {
      return tree < other.tree || (tree == other.tree && path < other.path);
    }
  };

  template <int dim>
  CellKey key_of(const dealii::CellAccessor<dim> &cell);

  /// The keys of all cells of a forest from their levels, in order. Throws RunFailure when there is
  /// no such forest.
  template <int dim>
  std::vector<CellKey> keys_of_levels(const std::vector<unsigned char> &levels,
                                      std::uint64_t n_trees);
} // namespace feib

#endif
