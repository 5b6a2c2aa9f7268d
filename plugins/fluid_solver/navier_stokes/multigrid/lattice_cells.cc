// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/lattice_cells.h"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <limits>

namespace feib
{
  template <int dim>
  LatticeCells<dim>::LatticeCells(const EulerianSpace<dim> &space)
  {
    units = space.lattice();
    std::vector<std::int64_t> mine;
    mine.reserve((dim + 1) * space.cells().size());
    for (const auto &cell : space.cells())
      {
        const Place lower = units.nearest(cell.lower);
        mine.insert(mine.end(), lower.begin(), lower.end());
        mine.push_back(units.nearest(cell.lower + cell.size)[0] - lower[0]);
      }
    const auto add = [&](const std::vector<std::int64_t> &numbers) {
      for (std::size_t i = 0; i < numbers.size(); i += dim + 1)
        {
          Cell cell;
          std::copy_n(&numbers[i], dim, cell.lower.begin());
          cell.size = numbers[i + dim];
          cell_list.push_back(cell);
        }
      first_cells.push_back(cell_list.size());
    };
    first_cells.push_back(0);
    if (dealii::Utilities::MPI::n_mpi_processes(space.communicator()) == 1)
      add(mine);
    else
      for (const auto &numbers : dealii::Utilities::MPI::all_gather(space.communicator(), mine))
        add(numbers);
    index();
  }


  template <int dim>
  void
  LatticeCells<dim>::index()
  {
    table    = KeyTable(cell_list.size());
    smallest = std::numeric_limits<std::int64_t>::max();
    largest  = 0;
    for (unsigned int c = 0; c < cell_list.size(); ++c)
      {
        table.insert(units.key(cell_list[c].lower), c);
        smallest = std::min(smallest, cell_list[c].size);
        largest  = std::max(largest, cell_list[c].size);
      }
  }


  template <int dim>
  unsigned int
  LatticeCells<dim>::rank_of(const unsigned int cell) const
  {
    return std::upper_bound(first_cells.begin(), first_cells.end(), cell) - first_cells.begin() - 1;
  }


  template <int dim>
  unsigned int
  LatticeCells<dim>::find(Place place, const std::int64_t size) const
  {
    if (!units.wrap(place))
      return KeyTable::none;
    const unsigned int c = table.find(units.key(place));
    return c != KeyTable::none && cell_list[c].size == size ? c : KeyTable::none;
  }


  template <int dim>
  unsigned int
  LatticeCells<dim>::owner_of_node(const Place &place) const
  {
    unsigned int first = static_cast<unsigned int>(-1);
    for (unsigned int corner = 0; corner < n_children; ++corner)
      {
        // The unit box beside the node.
        Place unit_box;
        for (unsigned int a = 0; a < dim; ++a)
          unit_box[a] = place[a] - (corner >> a & 1);
        if (!units.wrap(unit_box))
          continue;
        for (std::int64_t size = smallest; size <= largest; size *= 2)
          {
            Place lower;
            for (unsigned int a = 0; a < dim; ++a)
              lower[a] = unit_box[a] / size * size;
            const unsigned int c = find(lower, size);
            if (c == KeyTable::none)
              continue;
            bool is_node = true;
            for (unsigned int a = 0; a < dim; ++a)
              is_node = is_node && (unit_box[a] + (corner >> a & 1) - lower[a]) % (size / 2) == 0;
            if (is_node)
              first = std::min(first, rank_of(c));
            break;
          }
      }
    return first;
  }


  template <int dim>
  bool
  LatticeCells<dim>::coarsens() const
  {
    for (unsigned int a = 0; a < dim; ++a)
      if (uniform() && (units.extent(a) % (2 * smallest) != 0 ||
                        units.extent(a) / smallest < (units.periodic(a) ? 8 : 4)))
        return false;
    return true;
  }


  template <int dim>
  bool
  LatticeCells<dim>::find_family(const unsigned int c,
                                 std::array<unsigned int, n_children> &members) const
  {
    const Cell parent{cell_list[c].parent(), 2 * cell_list[c].size};
    for (unsigned int a = 0; a < dim; ++a)
      if (units.extent(a) % parent.size != 0)
        return false;
    for (unsigned int child = 0; child < n_children; ++child)
      {
        Place place = parent.lower;
        for (unsigned int a = 0; a < dim; ++a)
          place[a] += (child >> a & 1) * cell_list[c].size;
        members[child] = find(place, cell_list[c].size);
        if (members[child] == KeyTable::none)
          return false;
      }
    return true;
  }


  template <int dim>
  void
  LatticeCells<dim>::block_families(const unsigned int c, KeyTable &blocked) const
  {
    const Cell &cell          = cell_list[c];
    const std::int64_t parent = 4 * cell.size; // of a cell of twice the size
    for (unsigned int corner = 0; corner < n_children; ++corner)
      {
        Place place;
        for (unsigned int a = 0; a < dim; ++a)
          place[a] = corner >> a & 1 ? cell.lower[a] + cell.size : cell.lower[a] - 1;
        if (!units.wrap(place))
          continue;
        for (unsigned int child = 0; child < n_children; ++child)
          {
            Place member;
            for (unsigned int a = 0; a < dim; ++a)
              member[a] = place[a] / parent * parent + (child >> a & 1) * 2 * cell.size;
            blocked.insert(units.key(member), 1);
          }
      }
  }


  template <int dim>
  std::vector<bool>
  LatticeCells<dim>::cells_that_go() const
  {
    // Families are judged from the smallest cells up: whether one may become a cell of twice the
    // size depends only on smaller cells that stay and would touch it.
    std::vector<bool> goes(cell_list.size(), false);
    KeyTable blocked;
    const auto is_blocked = [&](const unsigned int c) {
      return blocked.find(units.key(cell_list[c].lower)) != KeyTable::none;
    };
    for (std::int64_t size = smallest; size <= largest; size *= 2)
      {
        std::array<unsigned int, n_children> members;
        for (unsigned int c = 0; c < cell_list.size(); ++c)
          if (cell_list[c].size == size && !goes[c] && !is_blocked(c) && find_family(c, members) &&
              std::none_of(members.begin(), members.end(), is_blocked))
            for (const unsigned int member : members)
              goes[member] = true;
        KeyTable next;
        for (unsigned int c = 0; c < cell_list.size(); ++c)
          if (size < largest && cell_list[c].size == size && !goes[c])
            block_families(c, next);
        blocked = std::move(next);
      }
    return goes;
  }


  template <int dim>
  LatticeCells<dim>
  LatticeCells<dim>::coarsened(std::vector<Family> &families) const
  {
    const std::vector<bool> goes = cells_that_go();
    LatticeCells coarse;
    coarse.units = units;
    coarse.first_cells.assign(1, 0);
    families.clear();
    std::vector<bool> done(cell_list.size(), false);
    for (unsigned int rank = 0; rank + 1 < first_cells.size(); ++rank)
      {
        for (unsigned int c = first_cells[rank]; c < first_cells[rank + 1]; ++c)
          {
            if (done[c])
              continue;
            Family family;
            family.refined = goes[c];
            Cell cell      = cell_list[c];
            if (!goes[c])
              family.children[0] = c;
            else
              {
                find_family(c, family.children);
                for (const unsigned int child : family.children)
                  done[child] = true;
                cell.lower = cell.parent();
                cell.size *= 2;
              }
            coarse.cell_list.push_back(cell);
            families.push_back(family);
          }
        coarse.first_cells.push_back(coarse.cell_list.size());
      }
    coarse.index();
    return coarse;
  }


  template class LatticeCells<2>;
  template class LatticeCells<3>;
} // namespace feib
