// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_cartesian_forest_h
#define feib_cartesian_forest_h

#include <deal.II/base/point.h>
#include <deal.II/distributed/tria.h>

#include <array>
#include <functional>
#include <vector>

namespace feib
{
  /// Finds the cell of a point by arithmetic: the base cell from the coordinates, then one
  /// comparison per direction and level. A flat tree over what this rank knows of the forest.
  template <int dim>
  class CartesianForest
  {
  public:
    static constexpr unsigned int not_here = static_cast<unsigned int>(-1);

    /// Builds the tree for a box of @p base_cells cells. Leaves that are locally owned get the
    /// numbers 0, 1, ... in the order of active_cell_iterators().
    void rebuild(const dealii::parallel::distributed::Triangulation<dim> &triangulation,
                 const dealii::Point<dim> &lower,
                 const dealii::Point<dim> &upper,
                 const std::array<unsigned int, dim> &base_cells,
                 const std::array<bool, dim> &periodic);

    /// The number of the locally owned cell that holds x, or not_here when another rank's cell does
    /// or x is outside the box or not finite. Each point inside belongs to exactly one cell on
    /// exactly one rank. On success @p unit is the place in the cell, in [0,1]^dim. Periodic
    /// directions wrap.
    unsigned int locate(const dealii::Point<dim> &x, dealii::Point<dim> &unit) const;

    /// Whether x is finite and in the box (along periodic directions: not absurdly far away).
    bool inside(const dealii::Point<dim> &x) const;

  private:
    struct Node
    {
      int first_child;   // or -1
      unsigned int cell; // number of the owned leaf, or not_here
    };

    std::vector<Node> nodes;
    dealii::Point<dim> lower, upper;
    dealii::Tensor<1, dim> inverse_size; // of a base cell
    std::array<unsigned int, dim> base_cells;
    std::array<bool, dim> periodic;
  };
} // namespace feib

#endif
