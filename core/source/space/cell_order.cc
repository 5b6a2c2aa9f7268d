// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cell_order.h"

#include <feib/error.h>

#include <functional>

namespace feib
{
  namespace
  {
    /// p4est has no deeper cells, and their paths fit into 64 bits.
    template <int dim>
    constexpr unsigned int deepest = dim == 2 ? 30 : 19;
  } // namespace


  template <int dim>
  std::vector<typename dealii::Triangulation<dim>::active_cell_iterator>
  cells_in_order(const dealii::parallel::distributed::Triangulation<dim> &mesh)
  {
    using Iterator = typename dealii::Triangulation<dim>::cell_iterator;
    std::vector<typename dealii::Triangulation<dim>::active_cell_iterator> result;
    const std::function<void(const Iterator &)> enter = [&](const Iterator &cell) {
      if (cell->has_children())
        for (unsigned int child = 0; child < cell->n_children(); ++child)
          enter(cell->child(child));
      else if (cell->is_locally_owned())
        result.push_back(cell);
    };
    for (const auto tree : mesh.get_p4est_tree_to_coarse_cell_permutation())
      enter(Iterator(&mesh, 0, tree));
    return result;
  }


  template <int dim>
  CellKey
  key_of(const dealii::CellAccessor<dim> &cell)
  {
    // The coarse cells of a distributed mesh are known by their trees.
    const dealii::CellId id = cell.id();
    const auto children     = id.get_child_indices();
    CellKey key{id.get_coarse_cell_id(), 0, static_cast<unsigned int>(children.size())};
    for (const auto child : children)
      key.path = (key.path << dim) + child;
    key.path <<= dim * (deepest<dim> - key.level);
    return key;
  }


  template <int dim>
  std::vector<CellKey>
  keys_of_levels(const std::vector<unsigned char> &levels, const std::uint64_t n_trees)
  {
    std::vector<CellKey> keys;
    keys.reserve(levels.size());
    CellKey next{0, 0, 0};
    for (const unsigned int level : levels)
      {
        const std::uint64_t size = std::uint64_t(1)
                                   << (dim * (deepest<dim> - std::min(level, deepest<dim>)));
        if (level > deepest<dim> || next.tree == n_trees || next.path % size != 0)
          throw RunFailure("the levels of the cells are those of no mesh of this box");
        keys.push_back({next.tree, next.path, level});
        next.path += size;
        if (next.path == std::uint64_t(1) << (dim * deepest<dim>))
          next = {next.tree + 1, 0, 0};
      }
    if (next.tree != n_trees || next.path != 0)
      throw RunFailure("the levels of the cells are those of no mesh of this box");
    return keys;
  }


  template std::vector<dealii::Triangulation<2>::active_cell_iterator>
  cells_in_order(const dealii::parallel::distributed::Triangulation<2> &);
  template std::vector<dealii::Triangulation<3>::active_cell_iterator>
  cells_in_order(const dealii::parallel::distributed::Triangulation<3> &);
  template CellKey key_of(const dealii::CellAccessor<2> &);
  template CellKey key_of(const dealii::CellAccessor<3> &);
  template std::vector<CellKey> keys_of_levels<2>(const std::vector<unsigned char> &,
                                                  std::uint64_t);
  template std::vector<CellKey> keys_of_levels<3>(const std::vector<unsigned char> &,
                                                  std::uint64_t);
} // namespace feib
