// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/level_space.h"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <numeric>
#include <set>

namespace feib
{
  namespace
  {
    /// The sum over the ranks before this one, and over all.
    std::pair<dealii::types::global_dof_index, dealii::types::global_dof_index>
    sum_before(const dealii::types::global_dof_index mine, const MPI_Comm communicator)
    {
      const auto all  = dealii::Utilities::MPI::all_gather(communicator, mine);
      const auto rank = dealii::Utilities::MPI::this_mpi_process(communicator);
      using dealii::types::global_dof_index;
      return {std::accumulate(all.begin(), all.begin() + rank, global_dof_index(0)),
              std::accumulate(all.begin(), all.end(), global_dof_index(0))};
    }
  } // namespace


  template <int dim>
  LevelSpace<dim>::LevelSpace(const LatticeCells<dim> &mesh,
                              const Domain<dim> &domain,
                              const MPI_Comm world,
                              const bool replicated,
                              const LatticeCells<dim> *coarser,
                              const std::vector<Family> *families)
    : communicator(replicated ? MPI_COMM_SELF : world)
    , unit(mesh.lattice().unit())
    , first_cell(replicated ? 0 : mesh.first(dealii::Utilities::MPI::this_mpi_process(world)))
  {
    const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(world);
    const unsigned int end  = replicated ? mesh.cells().size() : mesh.first(rank + 1);
    const std::vector<unsigned int> cell_of_slot = make_batches(mesh, end);

    std::set<double> edges;
    for (const Cell &cell : mesh.cells())
      edges.insert(cell.size);
    for (const double edge : edges)
      all_sizes.push_back(edge * unit);

    node_index = KeyTable((power(2, dim) + 1) * (end - first_cell));
    node_table.resize(cell_of_slot.size() * n);
    cell_keys.resize(cell_of_slot.size());
    for (unsigned int slot = 0; slot < cell_of_slot.size(); ++slot)
      {
        const Cell &cell = mesh.cells()[cell_of_slot[slot]];
        cell_keys[slot]  = mesh.lattice().key(cell.lower);
        for (unsigned int i = 0; i < n; ++i)
          node_table[(slot / lanes * n + i) * lanes + slot % lanes] =
            insert_node(cell.place(i, 2), mesh.lattice());
      }
    hanging_cells.assign(cell_of_slot.size(), false);
    if (!mesh.uniform())
      find_hanging_nodes(mesh);

    const std::set<unsigned int> ghost_cells = find_ghost_cells(mesh, coarser, families);
    for (const unsigned int c : ghost_cells)
      for (unsigned int i = 0; i < n; ++i)
        insert_node(mesh.cells()[c].place(i, 2), mesh.lattice());
    number_nodes(mesh);
    number_pressures(mesh, ghost_cells);
    find_prescribed(mesh.lattice(), domain);
  }


  template <int dim>
  std::vector<unsigned int>
  LevelSpace<dim>::make_batches(const LatticeCells<dim> &mesh, const unsigned int end)
  {
    std::map<std::int64_t, std::vector<unsigned int>> by_size;
    for (unsigned int c = first_cell; c < end; ++c)
      by_size[mesh.cells()[c].size].push_back(c);
    slot_of_cell.resize(end - first_cell);
    std::vector<unsigned int> cell_of_slot;
    for (const auto &[size, cells] : by_size)
      for (unsigned int first = 0; first < cells.size(); first += lanes)
        {
          const unsigned int filled = std::min<unsigned int>(lanes, cells.size() - first);
          for (unsigned int l = 0; l < lanes; ++l)
            {
              // The lanes that are left repeat a cell; nothing is taken from them.
              const unsigned int c = cells[first + std::min(l, filled - 1)];
              if (l < filled)
                slot_of_cell[c - first_cell] = batches.size() * lanes + l;
              cell_of_slot.push_back(c);
            }
          batches.push_back({double(size), filled});
        }
    return cell_of_slot;
  }


  template <int dim>
  unsigned int
  LevelSpace<dim>::insert_node(Place place, const Lattice<dim> &lattice)
  {
    lattice.wrap(place, true);
    const unsigned int number = node_index.insert(lattice.key(place), places.size());
    if (number == places.size())
      places.push_back(place);
    return number;
  }


  template <int dim>
  unsigned int
  LevelSpace<dim>::node_at(Place place, const Lattice<dim> &lattice) const
  {
    lattice.wrap(place, true);
    return dim * node_index.find(lattice.key(place));
  }


  // --- hanging nodes

  template <int dim>
  void
  LevelSpace<dim>::find_hanging_nodes(const LatticeCells<dim> &mesh)
  {
    std::vector<bool> known(places.size(), false);
    for (unsigned int k = 0; k < slot_of_cell.size(); ++k)
      {
        const Cell &cell   = mesh.cells()[first_cell + k];
        const Place parent = cell.parent();
        // Over faces and (in 3D) edges, there may be a cell of the parent's size.
        for (unsigned int direction = 0; direction < power(3, dim); ++direction)
          {
            std::array<int, dim> step;
            unsigned int codimension = 0;
            bool at_parents_boundary = true;
            Place neighbour          = parent;
            for (unsigned int a = 0; a < dim; ++a)
              {
                step[a] = int(digit(direction, a)) - 1;
                codimension += step[a] != 0;
                neighbour[a] += step[a] * 2 * cell.size;
                if (step[a] != 0)
                  at_parents_boundary =
                    at_parents_boundary && (cell.lower[a] == parent[a]) == (step[a] < 0);
              }
            if (codimension > 0 && codimension < dim && at_parents_boundary &&
                mesh.find(neighbour, 2 * cell.size) != KeyTable::none)
              hang_nodes(cell, slot_of_cell[k], step, mesh.lattice(), known);
          }
      }
  }


  template <int dim>
  void
  LevelSpace<dim>::hang_nodes(const Cell &cell,
                              const unsigned int slot,
                              const std::array<int, dim> &step,
                              const Lattice<dim> &lattice,
                              std::vector<bool> &known)
  {
    const Cell parent{cell.parent(), 2 * cell.size};
    for (unsigned int i = 0; i < n; ++i)
      {
        // In quarters of the parent's edge; on the entity shared, hanging when odd somewhere.
        unsigned int quarter[dim];
        bool shared = true, hangs = false;
        for (unsigned int a = 0; a < dim; ++a)
          {
            quarter[a] = 2 * (cell.lower[a] != parent.lower[a]) + digit(i, a);
            if (step[a] != 0)
              shared = shared && quarter[a] == (step[a] < 0 ? 0 : 4);
            hangs = hangs || quarter[a] % 2 == 1;
          }
        if (!shared || !hangs)
          continue;
        hanging_cells[slot]       = true;
        const unsigned int number = node(slot, i);
        if (known[number])
          continue;
        known[number] = true;
        Masters masters;
        for (unsigned int j = 0; j < n; ++j)
          {
            double weight = 1;
            for (unsigned int a = 0; a < dim; ++a)
              weight *= quarters[quarter[a]][digit(j, a)];
            if (weight != 0)
              masters.emplace_back(insert_node(parent.place(j, 2), lattice), weight);
          }
        hanging_nodes.add(number, masters);
      }
  }


  template <int dim>
  typename LevelSpace<dim>::Sources
  LevelSpace<dim>::sources(const unsigned int slot) const
  {
    Sources result;
    Masters masters;
    for (unsigned int i = 0; i < n; ++i)
      {
        hanging_nodes.find_masters(node(slot, i), masters);
        for (const auto &[master, weight] : masters)
          result.try_emplace(master, std::array<double, n>{}).first->second[i] += weight;
      }
    return result;
  }


  // --- numbering

  template <int dim>
  std::set<unsigned int>
  LevelSpace<dim>::find_ghost_cells(const LatticeCells<dim> &mesh,
                                    const LatticeCells<dim> *coarser,
                                    const std::vector<Family> *families) const
  {
    std::set<unsigned int> result;
    if (coarser && dealii::Utilities::MPI::n_mpi_processes(communicator) > 1)
      {
        const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(communicator);
        for (unsigned int c = coarser->first(rank); c < coarser->first(rank + 1); ++c)
          for (unsigned int child = 0; child < (*families)[c].size(); ++child)
            if (mesh.rank_of((*families)[c].children[child]) != rank)
              result.insert((*families)[c].children[child]);
      }
    return result;
  }


  template <int dim>
  void
  LevelSpace<dim>::number_nodes(const LatticeCells<dim> &mesh)
  {
    const unsigned int rank    = dealii::Utilities::MPI::this_mpi_process(communicator);
    const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator);
    std::vector<unsigned int> number(places.size()); // the new one
    std::map<unsigned int, std::vector<unsigned int>> asked;
    unsigned int n_owned = 0;
    for (unsigned int i = 0; i < places.size(); ++i)
      if (const unsigned int owner = n_ranks == 1 ? 0 : mesh.owner_of_node(places[i]);
          owner == rank)
        number[i] = n_owned++;
      else
        asked[owner].push_back(i);

    const auto [first_node, n_nodes] = sum_before(n_owned, communicator);
    dealii::IndexSet owned(n_nodes * dim), ghosts(n_nodes * dim);
    owned.add_range(first_node * dim, (first_node + n_owned) * dim);
    if (n_ranks > 1)
      ghosts = number_ghosts(asked, first_node, n_nodes, n_owned, number);
    velocity_partitioner =
      std::make_shared<dealii::Utilities::MPI::Partitioner>(owned, ghosts, communicator);

    std::vector<Place> sorted(places.size());
    for (unsigned int i = 0; i < places.size(); ++i)
      sorted[number[i]] = places[i];
    places.swap(sorted);
    if (n_ranks > 1)
      {
        node_index = KeyTable(places.size());
        for (unsigned int i = 0; i < places.size(); ++i)
          node_index.insert(mesh.lattice().key(places[i]), i);
      }
    for (unsigned int &node : node_table)
      node = dim * number[node];
    hanging_nodes.rename([&](const unsigned int node) { return dim * number[node]; });
  }


  template <int dim>
  dealii::IndexSet
  LevelSpace<dim>::number_ghosts(const std::map<unsigned int, std::vector<unsigned int>> &asked,
                                 const GlobalIndex first_node,
                                 const GlobalIndex n_nodes,
                                 const unsigned int n_owned,
                                 std::vector<unsigned int> &number) const
  {
    using dealii::Utilities::MPI::some_to_some;
    std::map<unsigned int, std::vector<std::uint64_t>> questions;
    for (const auto &[owner, nodes] : asked)
      for (const unsigned int node : nodes)
        questions[owner].push_back(Lattice<dim>::key(places[node]));
    std::map<unsigned int, std::vector<GlobalIndex>> replies;
    for (const auto &[from, keys] : some_to_some(communicator, questions))
      for (const std::uint64_t key : keys)
        replies[from].push_back(first_node + number[node_index.find(key)]);
    std::vector<std::pair<GlobalIndex, unsigned int>> found;
    for (const auto &[from, globals] : some_to_some(communicator, replies))
      for (unsigned int k = 0; k < globals.size(); ++k)
        found.emplace_back(globals[k], asked.at(from)[k]);
    std::sort(found.begin(), found.end());
    dealii::IndexSet ghosts(n_nodes * dim);
    for (unsigned int k = 0; k < found.size(); ++k)
      {
        ghosts.add_range(found[k].first * dim, (found[k].first + 1) * dim);
        number[found[k].second] = n_owned + k;
      }
    ghosts.compress();
    return ghosts;
  }


  template <int dim>
  void
  LevelSpace<dim>::number_pressures(const LatticeCells<dim> &mesh,
                                    const std::set<unsigned int> &ghost_cells)
  {
    using dealii::Utilities::MPI::some_to_some;
    const unsigned int n_own                 = batches.size() * lanes * n_pressure;
    const auto [first_pressure, n_pressures] = sum_before(n_own, communicator);
    dealii::IndexSet owned(n_pressures), ghosts(n_pressures);
    owned.add_range(first_pressure, first_pressure + n_own);
    std::map<unsigned int, GlobalIndex> first_of_ghost; // of the first function
    if (dealii::Utilities::MPI::n_mpi_processes(communicator) > 1)
      {
        std::map<unsigned int, std::vector<unsigned int>> asked;
        for (const unsigned int c : ghost_cells)
          asked[mesh.rank_of(c)].push_back(c);
        std::map<unsigned int, std::vector<GlobalIndex>> replies;
        for (const auto &[from, cells] : some_to_some(communicator, asked))
          for (const unsigned int c : cells)
            replies[from].push_back(first_pressure + pressure(slot(c), 0));
        for (const auto &[from, firsts] : some_to_some(communicator, replies))
          for (unsigned int k = 0; k < firsts.size(); ++k)
            first_of_ghost[asked[from][k]] = firsts[k];
        for (const auto &entry : first_of_ghost)
          for (unsigned int k = 0; k < n_pressure; ++k)
            ghosts.add_index(entry.second + k * lanes);
      }
    ghosts.compress();
    pressure_partitioner =
      std::make_shared<dealii::Utilities::MPI::Partitioner>(owned, ghosts, communicator);
    for (const auto &[cell, first] : first_of_ghost)
      for (unsigned int k = 0; k < n_pressure; ++k)
        ghost_pressure_table[cell].push_back(
          pressure_partitioner->global_to_local(first + k * lanes));
  }


  template <int dim>
  unsigned int
  LevelSpace<dim>::local_pressure(const unsigned int cell, const unsigned int k) const
  {
    if (cell >= first_cell && cell < first_cell + slot_of_cell.size())
      return pressure(slot(cell), k);
    return ghost_pressure_table.at(cell)[k];
  }


  // --- boundary conditions

  template <int dim>
  void
  LevelSpace<dim>::find_prescribed(const Lattice<dim> &lattice, const Domain<dim> &domain)
  {
    std::set<unsigned int> open_directions;
    for (const auto &condition : domain.conditions)
      if (condition.open())
        open_directions.insert(condition.normal());
    open_corners = open_directions.size() > 1;
    inactive_flags.assign(places.size() * dim, false);
    for (const unsigned int slave : hanging_nodes.nodes())
      for (unsigned int a = 0; a < dim; ++a)
        inactive_flags[slave + a] = true;
    for (unsigned int i = 0; i < places.size(); ++i)
      for (unsigned int f = 0; f < 2 * dim; ++f)
        if (!domain.periodic(f / 2) && places[i][f / 2] == (f % 2 == 0 ? 0 : lattice.extent(f / 2)))
          {
            const dealii::Point<dim> x = domain.place(lattice.share(places[i]));
            const auto &condition      = domain.conditions[domain.condition_at_node(f, x)];
            for (unsigned int a = 0; a < dim; ++a)
              if (condition.prescribes(a))
                inactive_flags[i * dim + a] = true;
          }
    for (unsigned int i = 0; i < velocity_partitioner->locally_owned_size(); ++i)
      if (inactive_flags[i])
        inactive_unknowns.push_back(i);
  }


  // --- geometry

  template <int dim>
  double
  LevelSpace<dim>::smallest_size() const
  {
    double least = std::numeric_limits<double>::max();
    for (const Size &size : all_sizes)
      for (unsigned int a = 0; a < dim; ++a)
        least = std::min(least, size[a]);
    return least;
  }


  template <int dim>
  double
  LevelSpace<dim>::aspect_ratio() const
  {
    double least = unit[0], most = unit[0];
    for (unsigned int a = 1; a < dim; ++a)
      {
        least = std::min(least, unit[a]);
        most  = std::max(most, unit[a]);
      }
    return most / least;
  }


  template class LevelSpace<2>;
  template class LevelSpace<3>;
} // namespace feib
