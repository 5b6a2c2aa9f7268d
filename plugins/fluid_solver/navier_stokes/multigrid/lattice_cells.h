// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_lattice_cells_h
#define feib_plugins_navier_stokes_lattice_cells_h

#include "multigrid/key_table.h"

#include <feib/eulerian_space.h>
#include <feib/lattice.h>

#include <array>
#include <cstdint>
#include <vector>

namespace feib
{
  /// All cells of a mesh of the box, of all ranks, on one lattice: places are counted in half edges
  /// of the smallest cell of the finest mesh, so that every Q2 node has one. The lattice of the
  /// levels of one multigrid hierarchy is the same; coarsening goes on beyond the base cells of the
  /// domain.
  template <int dim>
  class LatticeCells
  {
  public:
    using Place = typename Lattice<dim>::Place;

    static constexpr unsigned int n_children = 1 << dim;

    struct Cell
    {
      Place lower;
      std::int64_t size; // the edge, even

      /// The place @p i, lexicographic, of those that divide the cell into @p parts in each
      /// direction.
      Place
      place(unsigned int i, const unsigned int parts) const
      {
        Place result = lower;
        for (unsigned int a = 0; a < dim; ++a, i /= parts + 1)
          result[a] += size / parts * (i % (parts + 1));
        return result;
      }

      /// Where the cell of twice the size begins that this one is a child of.
      Place
      parent() const
      {
        Place result;
        for (unsigned int a = 0; a < dim; ++a)
          result[a] = lower[a] / (2 * size) * (2 * size);
        return result;
      }
    };

    /// The mesh of the space. Collective.
    explicit LatticeCells(const EulerianSpace<dim> &space);

    /// Where a cell of the coarser mesh comes from: its children, lexicographic, or the same cell.
    struct Family
    {
      bool refined = false;
      std::array<unsigned int, n_children> children; // or the same cell, first

      unsigned int
      size() const
      {
        return refined ? n_children : 1;
      }
    };

    /// Whether there is a coarser mesh fit for multigrid. A uniform mesh needs an even number of
    /// cells in each direction, and at least 4 (8 where periodic).
    bool coarsens() const;

    /// The mesh without every family of cells that 2:1 balance (across faces, edges and corners)
    /// lets go. A family becomes a cell of the rank of its first member.
    LatticeCells coarsened(std::vector<Family> &families) const;

    const Lattice<dim> &
    lattice() const
    {
      return units;
    }

    const std::vector<Cell> &
    cells() const
    {
      return cell_list;
    }

    /// The cells of rank r are first(r), ..., first(r + 1) - 1.
    unsigned int
    first(const unsigned int rank) const
    {
      return first_cells[rank];
    }

    unsigned int rank_of(unsigned int cell) const;

    bool
    uniform() const
    {
      return smallest == largest;
    }

    /// The number of the cell of given size at a place, or KeyTable::none.
    unsigned int find(Place place, std::int64_t size) const;

    /// The rank that owns a node: the first of those whose cells have it.
    unsigned int owner_of_node(const Place &place) const;

  private:
    LatticeCells() = default;

    void index();

    /// The cells of the family that cell @p c is a member of, when all are cells of its size.
    bool find_family(unsigned int c, std::array<unsigned int, n_children> &members) const;

    /// Of each cell, whether its family becomes a cell of the coarser mesh.
    std::vector<bool> cells_that_go() const;

    /// Adds the places of the cells of twice the size that have to stay beside cell @p c, as it
    /// stays: all members of the families that touch it.
    void block_families(unsigned int c, KeyTable &blocked) const;

    Lattice<dim> units;
    std::vector<Cell> cell_list;
    std::vector<unsigned int> first_cells;
    std::int64_t smallest, largest;
    KeyTable table; // of the lower corners: no two cells share one
  };
} // namespace feib

#endif
