// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_refinement_strategy_cell_tree_h
#define feib_refinement_strategy_cell_tree_h

#include <feib/eulerian_space.h>
#include <feib/immersed_structure.h>
#include <feib/lattice.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace feib
{
  /// Where a cell is among all cells of its level: on the lattice whose units they are.
  template <int dim>
  using Place = typename Lattice<dim>::Place;

  /// A sorted set of places.
  template <int dim>
  using Places = std::vector<Place<dim>>;

  template <typename T>
  void
  make_set(std::vector<T> &places)
  {
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
  }


  /// Adds the units that the simplex of these (scaled) corners touches, by separating axes: a unit
  /// is left out when there is a direction along which it and the simplex do not overlap.
  template <int dim>
  void add_touched(const Lattice<dim> &lattice,
                   const std::vector<dealii::Tensor<1, dim>> &corners,
                   Places<dim> &places);

  /// Adds @p layers of neighbours, across corners too.
  template <int dim>
  void dilate(const Lattice<dim> &lattice, Places<dim> &places, long layers);

  /// The cells of one level that elements of the structures touch. Throws RunFailure.
  template <int dim>
  Places<dim> touched_cells(const Lattice<dim> &lattice,
                            const std::vector<ImmersedStructure<dim>> &structures);

  /// A number of cells that elements of the structures touch at least, from their measure.
  template <int dim>
  double least_touched_cells(const Lattice<dim> &lattice,
                             const std::vector<ImmersedStructure<dim>> &structures);


  /// The mesh that a strategy asks for, as the cells that are split: the same on all ranks, and
  /// balanced by itself, so that the mesh that is asked for is the mesh that comes out.
  template <int dim>
  class CellTree
  {
  public:
    /// All cells coarser than @p minimum_level are split, and none of @p level.
    CellTree(const Domain<dim> &domain, int minimum_level, int level);

    const Lattice<dim> &
    lattice(const int l) const
    {
      return lattices[l];
    }

    /// Asks for the cell of level @p l at @p place to exist: its parent is split.
    void ask_for(int l, Place<dim> place);

    /// Splits what else has to be: the neighbours of a cell that is split must exist.
    void balance();

    /// Whether the places of so many cells are too many to hold, so that an estimate of their
    /// number must do.
    static bool too_large(double n_cells);

    /// Number of active cells of the mesh.
    std::uint64_t n_cells() const;

    /// Sets the flags of the locally owned cells that lead towards this mesh, level by level.
    void mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
              const EulerianSpace<dim> &space) const;

  private:
    /// Whether the cell of level @p l around @p x is split.
    bool is_split(int l, const dealii::Point<dim> &x) const;

    int minimum_level, level;
    std::vector<Lattice<dim>> lattices;
    std::vector<Places<dim>> splits;
  };
} // namespace feib

#endif
