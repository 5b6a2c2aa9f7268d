// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_lattice_h
#define feib_plugins_navier_stokes_lattice_h

#include <feib/eulerian_space.h>

#include <array>
#include <cstdint>
#include <vector>

namespace feib
{
  /// An index from 64 bit keys to numbers.
  class KeyTable
  {
  public:
    static constexpr unsigned int none = static_cast<unsigned int>(-1);

    explicit KeyTable(std::size_t n_expected = 0);

    /// The number of the key, or none.
    unsigned int
    find(const std::uint64_t key) const
    {
      for (std::size_t i = hash(key) & mask;; i = (i + 1) & mask)
        if (numbers[i] == none || keys[i] == key)
          return numbers[i];
    }

    /// The number of the key, which becomes @p number when the key is new.
    unsigned int insert(std::uint64_t key, unsigned int number);

  private:
    static std::size_t
    hash(std::uint64_t key)
    {
      key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9;
      return key ^ (key >> 27);
    }

    std::vector<std::uint64_t> keys;
    std::vector<unsigned int> numbers;
    std::size_t mask, size = 0;
  };


  /// All cells of a mesh of the box, of all ranks, in integers: places are counted in half edges of
  /// the smallest cell of the finest mesh, so that every Q2 node has one. The unit of the levels of
  /// one multigrid hierarchy is the same; coarsening goes on beyond the base cells of the domain.
  template <int dim>
  class Lattice
  {
  public:
    using Place = std::array<std::uint32_t, dim>;

    static constexpr unsigned int n_children = 1 << dim;

    struct Cell
    {
      Place lower;
      std::uint32_t size; // the edge
    };

    /// The mesh of the space. Collective.
    explicit Lattice(const EulerianSpace<dim> &space);

    /// Where a cell of the coarser mesh comes from: its children, lexicographic, or the same cell.
    struct Family
    {
      bool refined = false;
      std::array<unsigned int, n_children> children; // or the same cell, first
    };

    /// Whether there is a coarser mesh fit for multigrid. A uniform mesh needs an even number of
    /// cells in each direction, and at least 4 (8 where periodic).
    bool coarsens() const;

    /// The mesh without every family of cells that 2:1 balance (across faces, edges and corners)
    /// lets go. A family becomes a cell of the rank of its first member.
    Lattice coarsened(std::vector<Family> &families) const;

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

    /// The physical edges of a cell of size 1.
    const dealii::Tensor<1, dim> &
    unit() const
    {
      return unit_size;
    }

    bool
    periodic(const unsigned int direction) const
    {
      return periodic_directions[direction];
    }

    /// The number of units along a direction.
    std::uint32_t
    extent(const unsigned int direction) const
    {
      return extents[direction];
    }

    /// Wraps periodic directions. Returns false when the place is not in the box (for nodes: in the
    /// closed box).
    bool wrap(std::array<std::int64_t, dim> &place, bool closed) const;

    static std::uint64_t
    key(const Place &place)
    {
      std::uint64_t result = 0;
      for (unsigned int a = 0; a < dim; ++a)
        result |= std::uint64_t(place[a]) << (dim == 2 ? 32 * a : 21 * a);
      return result;
    }

    /// The number of the cell of given size at a place, or KeyTable::none.
    unsigned int find(const std::array<std::int64_t, dim> &place, std::uint32_t size) const;

    /// The rank that owns a node: the first of those whose cells have it.
    unsigned int owner_of_node(const Place &place) const;

  private:
    Lattice() = default;

    void index();

    std::vector<Cell> cell_list;
    std::vector<unsigned int> first_cells;
    dealii::Tensor<1, dim> unit_size;
    std::array<std::uint32_t, dim> extents;
    std::array<bool, dim> periodic_directions;
    std::uint32_t smallest, largest;
    KeyTable table; // of the lower corners: no two cells share one
  };
} // namespace feib

#endif
