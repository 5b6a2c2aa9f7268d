// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_cartesian_forest_h
#define feib_cartesian_forest_h

#include <feib/lattice.h>

#include <deal.II/base/array_view.h>
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

    /// Builds the tree for a box whose base cells are those of the triangulation's level
    /// @p base_level. The locally owned cells, @p owned_cells, get the numbers 0, 1, ...
    void rebuild(
      const dealii::parallel::distributed::Triangulation<dim> &triangulation,
      const std::vector<typename dealii::Triangulation<dim>::active_cell_iterator> &owned_cells,
      unsigned int base_level,
      const Domain<dim> &box);

    /// The number of the locally owned cell that holds x, or not_here when another rank's cell does
    /// or x is outside the box or not finite. Each point inside belongs to exactly one cell on
    /// exactly one rank. On success @p unit is the place in the cell, in [0,1]^dim; what lies on a
    /// face of the box within round_off() is taken to be in it. Periodic directions wrap.
    unsigned int locate(const dealii::Point<dim> &x, dealii::Point<dim> &unit) const;

    /// A corner of a piece of a facet: its place in the unit cell, and its barycentric coordinates
    /// in the facet.
    struct Corner
    {
      dealii::Point<dim> unit;
      std::array<double, dim> barycentric;
    };

    /// Called with a locally owned cell and the corners, in order, of a convex piece in it.
    using VisitPiece =
      std::function<void(unsigned int cell, const dealii::ArrayView<const Corner> &corners)>;

    /// Cuts a facet, a segment (dim = 2) or triangle (dim = 3) inside the box, along the faces of
    /// the cells, and visits the pieces in this rank's cells. Over all ranks the pieces make up the
    /// facet: what lies in a face belongs to one cell of those beside it. Periodic directions wrap.
    void cut(const std::array<dealii::Point<dim>, dim> &facet, const VisitPiece &visit) const;

    /// Whether x is finite and, up to round_off(), in the box (along periodic directions: not
    /// absurdly far away).
    bool inside(const dealii::Point<dim> &x) const;

  private:
    using Polygon = std::vector<Corner>;

    /// The coordinate in base cells; in the face of the box where x is in it within round-off.
    double coordinate(const dealii::Point<dim> &x, unsigned int a) const;

    /// Cuts along the faces of the base cells across directions a, a + 1, ...
    void cut_base(const Polygon &polygon,
                  unsigned int a,
                  unsigned int index,
                  unsigned int stride,
                  const VisitPiece &visit) const;

    /// Cuts a piece inside a node of the tree along the node's middle planes.
    void cut_node(const Polygon &polygon, unsigned int index, const VisitPiece &visit) const;

    struct Node
    {
      int first_child;   // or -1
      unsigned int cell; // number of the owned leaf, or not_here
    };

    std::vector<Node> nodes;
    Lattice<dim> base;           // of the base cells
    dealii::Tensor<1, dim> near; // round_off(), in base cells; 0 where periodic
  };
} // namespace feib

#endif
