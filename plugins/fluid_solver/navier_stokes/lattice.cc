// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lattice.h"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  KeyTable::KeyTable(const std::size_t n_expected)
  {
    std::size_t capacity = 16;
    while (capacity < 2 * n_expected)
      capacity *= 2;
    keys.assign(capacity, 0);
    numbers.assign(capacity, none);
    mask = capacity - 1;
  }


  unsigned int
  KeyTable::insert(const std::uint64_t key, const unsigned int number)
  {
    if (4 * (size + 1) > 3 * keys.size())
      {
        KeyTable larger(2 * keys.size());
        for (std::size_t i = 0; i < keys.size(); ++i)
          if (numbers[i] != none)
            larger.insert(keys[i], numbers[i]);
        *this = std::move(larger);
      }
    std::size_t i = hash(key) & mask;
    for (; numbers[i] != none; i = (i + 1) & mask)
      if (keys[i] == key)
        return numbers[i];
    keys[i]    = key;
    numbers[i] = number;
    ++size;
    return number;
  }


  template <int dim>
  Lattice<dim>::Lattice(const EulerianSpace<dim> &space)
  {
    const Domain<dim> &box      = space.domain();
    const MPI_Comm communicator = space.communicator();
    unsigned int depth          = 0;
    for (const auto &cell : space.cells())
      depth = std::max(depth, cell.level);
    depth = dealii::Utilities::MPI::max(depth, communicator);
    for (unsigned int a = 0; a < dim; ++a)
      {
        extents[a]             = box.cells[a] << (depth + 1);
        unit_size[a]           = (box.upper[a] - box.lower[a]) / extents[a];
        periodic_directions[a] = box.periodic(a);
      }

    std::vector<std::uint32_t> mine;
    mine.reserve((dim + 1) * space.cells().size());
    for (const auto &cell : space.cells())
      {
        for (unsigned int a = 0; a < dim; ++a)
          mine.push_back(std::lround((cell.lower[a] - box.lower[a]) / unit_size[a]));
        mine.push_back(2u << (depth - cell.level));
      }
    const auto add = [&](const std::vector<std::uint32_t> &numbers) {
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
    if (dealii::Utilities::MPI::n_mpi_processes(communicator) == 1)
      add(mine);
    else
      for (const auto &numbers : dealii::Utilities::MPI::all_gather(communicator, mine))
        add(numbers);
    index();
  }


  template <int dim>
  void
  Lattice<dim>::index()
  {
    table    = KeyTable(cell_list.size());
    smallest = static_cast<std::uint32_t>(-1);
    largest  = 0;
    for (unsigned int c = 0; c < cell_list.size(); ++c)
      {
        table.insert(key(cell_list[c].lower), c);
        smallest = std::min(smallest, cell_list[c].size);
        largest  = std::max(largest, cell_list[c].size);
      }
  }


  template <int dim>
  unsigned int
  Lattice<dim>::rank_of(const unsigned int cell) const
  {
    return std::upper_bound(first_cells.begin(), first_cells.end(), cell) - first_cells.begin() - 1;
  }


  template <int dim>
  bool
  Lattice<dim>::wrap(std::array<std::int64_t, dim> &place, const bool closed) const
  {
    for (unsigned int a = 0; a < dim; ++a)
      if (periodic_directions[a])
        {
          if (place[a] < 0)
            place[a] += extents[a];
          else if (place[a] >= extents[a])
            place[a] -= extents[a];
        }
      else if (place[a] < 0 || place[a] > extents[a] || (!closed && place[a] == extents[a]))
        return false;
    return true;
  }


  template <int dim>
  unsigned int
  Lattice<dim>::find(const std::array<std::int64_t, dim> &place, const std::uint32_t size) const
  {
    std::array<std::int64_t, dim> wrapped = place;
    if (!wrap(wrapped, false))
      return KeyTable::none;
    Place lower;
    std::copy_n(wrapped.begin(), dim, lower.begin());
    const unsigned int c = table.find(key(lower));
    return c != KeyTable::none && cell_list[c].size == size ? c : KeyTable::none;
  }


  template <int dim>
  unsigned int
  Lattice<dim>::owner_of_node(const Place &place) const
  {
    unsigned int first = static_cast<unsigned int>(-1);
    for (unsigned int corner = 0; corner < n_children; ++corner)
      {
        // The unit box beside the node.
        std::array<std::int64_t, dim> unit_box;
        for (unsigned int a = 0; a < dim; ++a)
          unit_box[a] = std::int64_t(place[a]) - (corner >> a & 1);
        if (!wrap(unit_box, false))
          continue;
        for (std::uint32_t size = smallest; size <= largest; size *= 2)
          {
            std::array<std::int64_t, dim> lower;
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
  Lattice<dim>::coarsens() const
  {
    for (unsigned int a = 0; a < dim; ++a)
      if (uniform() && (extents[a] % (2 * smallest) != 0 ||
                        extents[a] / smallest < (periodic_directions[a] ? 8 : 4)))
        return false;
    return true;
  }


  template <int dim>
  Lattice<dim>
  Lattice<dim>::coarsened(std::vector<Family> &families) const
  {
    // Families are judged from the smallest cells up: whether one may become a cell of twice the
    // size depends only on smaller cells that stay and would touch it.
    std::vector<bool> goes(cell_list.size(), false);
    KeyTable blocked;
    for (std::uint32_t size = smallest; size <= largest; size *= 2)
      {
        bool even = true;
        for (unsigned int a = 0; a < dim; ++a)
          even = even && extents[a] % (2 * size) == 0;
        for (unsigned int c = 0; c < cell_list.size(); ++c)
          {
            const Cell &cell = cell_list[c];
            if (cell.size != size || goes[c])
              continue;
            bool complete = even && blocked.find(key(cell.lower)) == KeyTable::none;
            std::array<unsigned int, n_children> members;
            for (unsigned int child = 0; child < n_children && complete; ++child)
              {
                std::array<std::int64_t, dim> place;
                for (unsigned int a = 0; a < dim; ++a)
                  place[a] = cell.lower[a] / (2 * size) * (2 * size) + (child >> a & 1) * size;
                members[child] = find(place, size);
                complete       = members[child] != KeyTable::none &&
                           blocked.find(key(cell_list[members[child]].lower)) == KeyTable::none;
              }
            if (complete)
              for (const unsigned int member : members)
                goes[member] = true;
          }
        // What stays keeps the families beside it: each member of those touched is blocked.
        if (size < largest)
          {
            KeyTable next;
            for (unsigned int c = 0; c < cell_list.size(); ++c)
              if (cell_list[c].size == size && !goes[c])
                {
                  const auto &lower         = cell_list[c].lower;
                  const std::int64_t parent = 4 * std::int64_t(size); // of a cell of 2 size
                  for (unsigned int corner = 0; corner < n_children; ++corner)
                    {
                      std::array<std::int64_t, dim> place;
                      for (unsigned int a = 0; a < dim; ++a)
                        place[a] = corner >> a & 1 ? std::int64_t(lower[a]) + size
                                                   : std::int64_t(lower[a]) - 1;
                      if (!wrap(place, false))
                        continue;
                      for (unsigned int child = 0; child < n_children; ++child)
                        {
                          Place member;
                          for (unsigned int a = 0; a < dim; ++a)
                            member[a] = place[a] / parent * parent +
                                        (child >> a & 1) * 2 * std::int64_t(size);
                          next.insert(key(member), 1);
                        }
                    }
                }
            blocked = std::move(next);
          }
      }
    Lattice coarse;
    coarse.extents             = extents;
    coarse.unit_size           = unit_size;
    coarse.periodic_directions = periodic_directions;
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
                for (unsigned int a = 0; a < dim; ++a)
                  cell.lower[a] = cell.lower[a] / (2 * cell.size) * (2 * cell.size);
                for (unsigned int child = 0; child < n_children; ++child)
                  {
                    std::array<std::int64_t, dim> place;
                    for (unsigned int a = 0; a < dim; ++a)
                      place[a] = cell.lower[a] + (child >> a & 1) * cell.size;
                    family.children[child]       = find(place, cell.size);
                    done[family.children[child]] = true;
                  }
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


  template class Lattice<2>;
  template class Lattice<3>;
} // namespace feib
