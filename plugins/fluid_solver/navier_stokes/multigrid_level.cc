// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid_level.h"

#include <deal.II/base/mpi.h>
#include <deal.II/lac/lapack_full_matrix.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace feib
{
  namespace
  {
    /// Node (or, with 5 values per direction, fine node) i in direction a.
    unsigned int
    digit(unsigned int i, const unsigned int a, const unsigned int base = 3)
    {
      for (unsigned int b = 0; b < a; ++b)
        i /= base;
      return i % base;
    }

    constexpr unsigned int
    power(const unsigned int base, const unsigned int exponent)
    {
      return exponent == 0 ? 1 : base * power(base, exponent - 1);
    }

    /// Values of the quadratic shape functions of an edge at a quarter of it, for 0, 1, ..., 4.
    constexpr double quarters[5][3] = {{1, 0, 0},
                                       {3 / 8., 3 / 4., -1 / 8.},
                                       {0, 1, 0},
                                       {-1 / 8., 3 / 4., 3 / 8.},
                                       {0, 0, 1}};

    template <typename Number>
    inline const typename Batch<Number>::Values *
    aligned(const Number *values)
    {
      return reinterpret_cast<const typename Batch<Number>::Values *>(values);
    }

    template <typename Number>
    inline typename Batch<Number>::Values *
    aligned(Number *values)
    {
      return reinterpret_cast<typename Batch<Number>::Values *>(values);
    }

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


  // --- set-up

  template <int dim>
  MultigridLevel<dim>::MultigridLevel(const Lattice<dim> &lattice,
                                      const Domain<dim> &domain,
                                      const MPI_Comm world,
                                      const bool replicated,
                                      const Lattice<dim> *coarser,
                                      const std::vector<Family> *families)
    : communicator(replicated ? MPI_COMM_SELF : world)
    , unit(lattice.unit())
  {
    const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(world);
    first_cell              = replicated ? 0 : lattice.first(rank);
    const unsigned int end  = replicated ? lattice.cells().size() : lattice.first(rank + 1);

    std::map<std::uint32_t, std::vector<unsigned int>> by_size;
    for (unsigned int c = first_cell; c < end; ++c)
      by_size[lattice.cells()[c].size].push_back(c);
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

    for (const auto &entry : by_size)
      edges.push_back(entry.first);
    if (!replicated)
      {
        std::set<double> all;
        for (const auto &cell : lattice.cells())
          all.insert(cell.size);
        edges.assign(all.begin(), all.end());
      }

    node_index = KeyTable((power(2, dim) + 1) * (end - first_cell));
    node_table.resize(cell_of_slot.size() * n);
    cell_keys.resize(cell_of_slot.size());
    for (unsigned int slot = 0; slot < cell_of_slot.size(); ++slot)
      {
        const auto &cell = lattice.cells()[cell_of_slot[slot]];
        cell_keys[slot]  = Lattice<dim>::key(cell.lower);
        for (unsigned int i = 0; i < n; ++i)
          {
            std::array<std::int64_t, dim> place;
            for (unsigned int a = 0; a < dim; ++a)
              place[a] = cell.lower[a] + digit(i, a) * (cell.size / 2);
            node_table[(slot / lanes * n + i) * lanes + slot % lanes] = insert_node(place, lattice);
          }
      }
    hanging_cells.assign(cell_of_slot.size(), false);
    if (!lattice.uniform())
      find_hanging_nodes(lattice);
    number_nodes(lattice, coarser, families, replicated);
    find_prescribed(lattice, domain);
  }


  template <int dim>
  unsigned int
  MultigridLevel<dim>::insert_node(std::array<std::int64_t, dim> place, const Lattice<dim> &lattice)
  {
    lattice.wrap(place, true);
    Place node;
    std::copy_n(place.begin(), dim, node.begin());
    const unsigned int number = node_index.insert(Lattice<dim>::key(node), places.size());
    if (number == places.size())
      places.push_back(node);
    return number;
  }


  template <int dim>
  void
  MultigridLevel<dim>::find_hanging_nodes(const Lattice<dim> &lattice)
  {
    const unsigned int n_own = places.size();
    std::vector<bool> known(n_own, false);
    first_master.push_back(0);
    for (unsigned int k = 0; k < slot_of_cell.size(); ++k)
      {
        const auto &cell           = lattice.cells()[first_cell + k];
        const std::uint32_t coarse = 2 * cell.size;
        const unsigned int slot    = slot_of_cell[k];
        std::array<std::int64_t, dim> parent;
        for (unsigned int a = 0; a < dim; ++a)
          parent[a] = cell.lower[a] / coarse * coarse;
        // Over faces and (in 3D) edges, there may be a cell of the parent's size.
        for (unsigned int direction = 0; direction < power(3, dim); ++direction)
          {
            int step[dim];
            unsigned int codimension                = 0;
            bool at_parents_boundary                = true;
            std::array<std::int64_t, dim> neighbour = parent;
            for (unsigned int a = 0; a < dim; ++a)
              {
                step[a] = int(digit(direction, a)) - 1;
                codimension += step[a] != 0;
                neighbour[a] += step[a] * std::int64_t(coarse);
                if (step[a] != 0)
                  at_parents_boundary =
                    at_parents_boundary && (cell.lower[a] == parent[a]) == (step[a] < 0);
              }
            if (codimension == 0 || codimension == dim || !at_parents_boundary ||
                lattice.find(neighbour, coarse) == KeyTable::none)
              continue;
            for (unsigned int i = 0; i < n; ++i)
              {
                // In quarters of the parent's edge; on the entity shared, hanging when odd
                // somewhere.
                unsigned int quarter[dim];
                bool shared = true, hangs = false;
                for (unsigned int a = 0; a < dim; ++a)
                  {
                    quarter[a] = 2 * (cell.lower[a] != parent[a]) + digit(i, a);
                    if (step[a] != 0)
                      shared = shared && quarter[a] == (step[a] < 0 ? 0 : 4);
                    hangs = hangs || quarter[a] % 2 == 1;
                  }
                if (!shared || !hangs)
                  continue;
                hanging_cells[slot] = true;
                const unsigned int number =
                  node_table[(slot / lanes * n + i) * lanes + slot % lanes];
                if (known[number])
                  continue;
                known[number] = true;
                slaves.push_back(number);
                for (unsigned int j = 0; j < n; ++j)
                  {
                    double weight = 1;
                    std::array<std::int64_t, dim> place;
                    for (unsigned int a = 0; a < dim; ++a)
                      {
                        weight *= quarters[quarter[a]][digit(j, a)];
                        place[a] = parent[a] + digit(j, a) * std::int64_t(cell.size);
                      }
                    if (weight != 0)
                      {
                        masters.push_back(insert_node(place, lattice));
                        master_weights.push_back(weight);
                      }
                  }
                first_master.push_back(masters.size());
              }
          }
      }
  }


  template <int dim>
  void
  MultigridLevel<dim>::number_nodes(const Lattice<dim> &lattice,
                                    const Lattice<dim> *coarser,
                                    const std::vector<Family> *families,
                                    const bool replicated)
  {
    using dealii::types::global_dof_index;
    const unsigned int rank    = dealii::Utilities::MPI::this_mpi_process(communicator);
    const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator);

    // The children, on other ranks, of this rank's cells of the next mesh.
    std::set<unsigned int> ghost_cells;
    if (coarser && !replicated && n_ranks > 1)
      for (unsigned int c = coarser->first(rank); c < coarser->first(rank + 1); ++c)
        for (unsigned int child = 0; child < ((*families)[c].refined ? power(2, dim) : 1u); ++child)
          if (lattice.rank_of((*families)[c].children[child]) != rank)
            ghost_cells.insert((*families)[c].children[child]);
    for (const unsigned int c : ghost_cells)
      for (unsigned int i = 0; i < n; ++i)
        {
          std::array<std::int64_t, dim> place;
          for (unsigned int a = 0; a < dim; ++a)
            place[a] = lattice.cells()[c].lower[a] + digit(i, a) * (lattice.cells()[c].size / 2);
          insert_node(place, lattice);
        }

    // Own nodes first, in the order met; then the others by their global number.
    std::vector<unsigned int> number(places.size()); // the new one
    std::map<unsigned int, std::vector<std::uint64_t>> asked;
    std::map<unsigned int, std::vector<unsigned int>> asked_nodes;
    unsigned int n_owned = 0;
    for (unsigned int i = 0; i < places.size(); ++i)
      {
        const unsigned int owner = n_ranks == 1 ? 0 : lattice.owner_of_node(places[i]);
        if (owner == rank)
          number[i] = n_owned++;
        else
          {
            asked[owner].push_back(Lattice<dim>::key(places[i]));
            asked_nodes[owner].push_back(i);
          }
      }
    const auto [first_node, n_nodes] = sum_before(n_owned, communicator);
    dealii::IndexSet owned(n_nodes * dim), ghosts(n_nodes * dim);
    owned.add_range(first_node * dim, (first_node + n_owned) * dim);
    if (n_ranks > 1)
      {
        std::map<unsigned int, std::vector<global_dof_index>> replies;
        for (const auto &[from, keys] : dealii::Utilities::MPI::some_to_some(communicator, asked))
          for (const std::uint64_t key : keys)
            replies[from].push_back(first_node + number[node_index.find(key)]);
        std::vector<std::pair<global_dof_index, unsigned int>> found;
        for (const auto &[from, globals] :
             dealii::Utilities::MPI::some_to_some(communicator, replies))
          for (unsigned int k = 0; k < globals.size(); ++k)
            found.emplace_back(globals[k], asked_nodes[from][k]);
        std::sort(found.begin(), found.end());
        for (unsigned int k = 0; k < found.size(); ++k)
          {
            ghosts.add_range(found[k].first * dim, (found[k].first + 1) * dim);
            number[found[k].second] = n_owned + k;
          }
      }
    ghosts.compress();
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
          node_index.insert(Lattice<dim>::key(places[i]), i);
      }
    for (auto *list : {&node_table, &slaves, &masters})
      for (unsigned int &node : *list)
        node = dim * number[node];
    for (unsigned int s = 0; s < slaves.size(); ++s)
      line_of_slave[slaves[s]] = s;

    // Pressures.
    const unsigned int n_own_pressures       = batches.size() * lanes * n_pressure;
    const auto [first_pressure, n_pressures] = sum_before(n_own_pressures, communicator);
    dealii::IndexSet owned_pressures(n_pressures), ghost_pressures(n_pressures);
    owned_pressures.add_range(first_pressure, first_pressure + n_own_pressures);
    std::map<unsigned int, global_dof_index> first_of_ghost; // of the first function
    if (n_ranks > 1)
      {
        std::map<unsigned int, std::vector<unsigned int>> asked_cells;
        for (const unsigned int c : ghost_cells)
          asked_cells[lattice.rank_of(c)].push_back(c);
        std::map<unsigned int, std::vector<global_dof_index>> replies;
        for (const auto &[from, cells] :
             dealii::Utilities::MPI::some_to_some(communicator, asked_cells))
          for (const unsigned int c : cells)
            {
              const unsigned int slot = slot_of_cell[c - first_cell];
              replies[from].push_back(first_pressure + slot / lanes * lanes * n_pressure +
                                      slot % lanes);
            }
        for (const auto &[from, firsts] :
             dealii::Utilities::MPI::some_to_some(communicator, replies))
          for (unsigned int k = 0; k < firsts.size(); ++k)
            first_of_ghost[asked_cells[from][k]] = firsts[k];
        for (const auto &entry : first_of_ghost)
          for (unsigned int k = 0; k < n_pressure; ++k)
            ghost_pressures.add_index(entry.second + k * lanes);
      }
    ghost_pressures.compress();
    pressure_partitioner = std::make_shared<dealii::Utilities::MPI::Partitioner>(owned_pressures,
                                                                                 ghost_pressures,
                                                                                 communicator);
    for (const auto &[cell, first] : first_of_ghost)
      for (unsigned int k = 0; k < n_pressure; ++k)
        ghost_pressure_table[cell].push_back(
          pressure_partitioner->global_to_local(first + k * lanes));
  }


  template <int dim>
  void
  MultigridLevel<dim>::find_prescribed(const Lattice<dim> &lattice, const Domain<dim> &domain)
  {
    unsigned int open_directions = 0;
    for (unsigned int a = 0; a < dim; ++a)
      if (domain.faces[2 * a].condition == BoundaryCondition::outflow ||
          domain.faces[2 * a + 1].condition == BoundaryCondition::outflow)
        ++open_directions;
    open_corners = open_directions > 1;
    inactive_flags.assign(places.size() * dim, false);
    for (const unsigned int slave : slaves)
      for (unsigned int a = 0; a < dim; ++a)
        inactive_flags[slave + a] = true;
    for (unsigned int i = 0; i < places.size(); ++i)
      for (unsigned int f = 0; f < 2 * dim; ++f)
        if (places[i][f / 2] == (f % 2 == 0 ? 0 : lattice.extent(f / 2)))
          switch (domain.faces[f].condition)
            {
              case BoundaryCondition::no_slip:
              case BoundaryCondition::velocity:
                for (unsigned int a = 0; a < dim; ++a)
                  inactive_flags[i * dim + a] = true;
                break;
              case BoundaryCondition::free_slip:
                inactive_flags[i * dim + f / 2] = true;
                break;
              case BoundaryCondition::outflow:
              case BoundaryCondition::periodic:
                break;
            }
    for (unsigned int i = 0; i < velocity_partitioner->locally_owned_size(); ++i)
      if (inactive_flags[i])
        inactive_unknowns.push_back(i);
  }


  template <int dim>
  void
  MultigridLevel<dim>::connect(const MultigridLevel &coarse,
                               const Lattice<dim> &coarse_lattice,
                               const std::vector<Family> &families,
                               const MPI_Comm world)
  {
    const bool replicated        = communicator == MPI_COMM_SELF;
    const bool coarse_replicated = coarse.communicator == MPI_COMM_SELF;
    const unsigned int rank      = dealii::Utilities::MPI::this_mpi_process(world);
    sum_over                     = coarse_replicated && !replicated ? world : MPI_COMM_NULL;
    const unsigned int begin     = replicated ? 0 : coarse_lattice.first(rank);
    const unsigned int end =
      replicated ? coarse_lattice.cells().size() : coarse_lattice.first(rank + 1);

    reinit_velocity(node_weights);
    reinit_velocity(fine_velocity);
    reinit_pressure(fine_pressure);
    transfers.clear();
    for (const bool refined : {false, true})
      {
        std::vector<unsigned int> chosen;
        for (unsigned int c = begin; c < end; ++c)
          if (families[c].refined == refined)
            chosen.push_back(c);
        const unsigned int per_direction    = refined ? 5 : 3;
        const unsigned int n_here           = power(per_direction, dim);
        const unsigned int n_here_pressures = (refined ? power(2, dim) : 1) * n_pressure;
        for (unsigned int first = 0; first < chosen.size(); first += lanes)
          {
            Transfer transfer;
            transfer.refined = refined;
            transfer.filled  = std::min<unsigned int>(lanes, chosen.size() - first);
            transfer.coarse_nodes.resize(n * lanes);
            transfer.coarse_pressures.resize(n_pressure * lanes);
            transfer.fine_nodes.resize(n_here * lanes);
            transfer.fine_pressures.resize(n_here_pressures * lanes);
            for (unsigned int l = 0; l < lanes; ++l)
              {
                const unsigned int c    = chosen[first + std::min(l, transfer.filled - 1)];
                const unsigned int slot = coarse.slot_of_cell[c - coarse.first_cell];
                for (unsigned int i = 0; i < n; ++i)
                  transfer.coarse_nodes[i * lanes + l] =
                    coarse.node_table[(slot / lanes * n + i) * lanes + slot % lanes];
                for (unsigned int k = 0; k < n_pressure; ++k)
                  transfer.coarse_pressures[k * lanes + l] =
                    (slot / lanes * n_pressure + k) * lanes + slot % lanes;
                const auto &cell = coarse_lattice.cells()[c];
                for (unsigned int i = 0; i < n_here; ++i)
                  {
                    std::array<std::int64_t, dim> place;
                    for (unsigned int a = 0; a < dim; ++a)
                      place[a] = cell.lower[a] +
                                 digit(i, a, per_direction) * (cell.size / (per_direction - 1));
                    coarse_lattice.wrap(place, true);
                    Place node;
                    std::copy_n(place.begin(), dim, node.begin());
                    transfer.fine_nodes[i * lanes + l] =
                      dim * node_index.find(Lattice<dim>::key(node));
                  }
                for (unsigned int child = 0; child < n_here_pressures / n_pressure; ++child)
                  for (unsigned int k = 0; k < n_pressure; ++k)
                    transfer.fine_pressures[(child * n_pressure + k) * lanes + l] =
                      local_pressure(families[c].children[child], k);
              }
            transfers.push_back(std::move(transfer));
          }
      }

    for (const Transfer &transfer : transfers)
      for (unsigned int i = 0; i < transfer.fine_nodes.size(); ++i)
        if (i % lanes < transfer.filled)
          for (unsigned int a = 0; a < dim; ++a)
            node_weights.local_element(transfer.fine_nodes[i] + a) += 1;
    node_weights.compress(dealii::VectorOperation::add);
    for (unsigned int i = 0; i < node_weights.locally_owned_size(); ++i)
      node_weights.local_element(i) = inactive_flags[i] || node_weights.local_element(i) == 0
                                        ? 0
                                        : 1 / node_weights.local_element(i);
    node_weights.update_ghost_values();
    // The tables have it all now.
    node_index = KeyTable();
  }


  template <int dim>
  unsigned int
  MultigridLevel<dim>::local_pressure(const unsigned int cell, const unsigned int k) const
  {
    if (cell >= first_cell && cell < first_cell + slot_of_cell.size())
      {
        const unsigned int slot = slot_of_cell[cell - first_cell];
        return (slot / lanes * n_pressure + k) * lanes + slot % lanes;
      }
    return ghost_pressure_table.at(cell)[k];
  }


  // --- hanging nodes

  template <int dim>
  template <typename Number>
  void
  MultigridLevel<dim>::expand(LevelVector<Number> &v) const
  {
    v.update_ghost_values();
    Number *values = v.begin();
    for (unsigned int s = 0; s < slaves.size(); ++s)
      for (unsigned int a = 0; a < dim; ++a)
        {
          double value = 0;
          for (unsigned int m = first_master[s]; m < first_master[s + 1]; ++m)
            value += master_weights[m] * values[masters[m] + a];
          values[slaves[s] + a] = value;
        }
  }


  template <int dim>
  template <typename Number>
  void
  MultigridLevel<dim>::condense(LevelVector<Number> &v) const
  {
    Number *values = v.begin();
    for (unsigned int s = 0; s < slaves.size(); ++s)
      for (unsigned int a = 0; a < dim; ++a)
        {
          const Number value = values[slaves[s] + a];
          for (unsigned int m = first_master[s]; m < first_master[s + 1]; ++m)
            values[masters[m] + a] += master_weights[m] * value;
          values[slaves[s] + a] = 0;
        }
    v.compress(dealii::VectorOperation::add);
    for (const unsigned int i : inactive_unknowns)
      values[i] = 0;
  }


  template <int dim>
  void
  MultigridLevel<dim>::masters_of(const unsigned int slot, std::array<Masters, n> &result) const
  {
    for (unsigned int i = 0; i < n; ++i)
      {
        const unsigned int node = node_table[(slot / lanes * n + i) * lanes + slot % lanes];
        const auto found        = line_of_slave.find(node);
        result[i].clear();
        if (found == line_of_slave.end())
          result[i].emplace_back(node, 1.);
        else
          for (unsigned int m = first_master[found->second]; m < first_master[found->second + 1];
               ++m)
            result[i].emplace_back(masters[m], master_weights[m]);
      }
  }


  // --- forms

  template <int dim>
  template <typename Number>
  void
  MultigridLevel<dim>::apply_velocity_form(const VelocityForm &form,
                                           const LevelVector<Number> &u,
                                           LevelVector<Number> &result) const
  {
    using V                      = typename Batch<Number>::Values;
    constexpr unsigned int width = Batch<Number>::lanes;
    result                       = 0;
    const Number *from           = u.begin();
    Number *to                   = result.begin();
    for (unsigned int b = 0; b < batches.size(); ++b)
      for (unsigned int part = 0; part < batches[b].filled; part += width)
        {
          const unsigned int filled   = std::min(width, batches[b].filled - part);
          const unsigned int *indices = nodes(b) + part;
          const auto gather_component = [&](const unsigned int a, V *local) {
            for (unsigned int i = 0; i < n; ++i)
              local[i] = gather(from + a, indices + i * lanes);
          };
          const auto scatter_component = [&](const unsigned int a, const V *product) {
            for (unsigned int i = 0; i < n; ++i)
              scatter_add(product[i], indices + i * lanes, filled, to + a);
          };
          if (form.couples())
            {
              V local[dim * n], product[dim * n];
              for (unsigned int a = 0; a < dim; ++a)
                gather_component(a, local + a * n);
              feib::apply_velocity_form<dim, Number>(form, cell_size(b), local, product);
              for (unsigned int a = 0; a < dim; ++a)
                scatter_component(a, product + a * n);
            }
          else
            {
              // All components are alike, and one at a time stays in the registers.
              const CellFactors<dim, Number> factors(form, cell_size(b), 0);
              V local[n], product[n];
              for (unsigned int a = 0; a < dim; ++a)
                {
                  gather_component(a, local);
                  apply_helmholtz<dim>(factors, local, product);
                  scatter_component(a, product);
                }
            }
        }
    condense(result);
  }


  template <int dim>
  void
  MultigridLevel<dim>::apply_gradient(const LevelVector<float> &p, LevelVector<float> &result) const
  {
    using V           = Batch<float>::Values;
    result            = 0;
    const V *pressure = aligned(p.begin());
    float *to         = result.begin();
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        const Size size = cell_size(b);
        for_directions<dim>([&](const auto a) {
          V product[n];
          feib::apply_gradient<dim, a>(float(cell_volume(size) / size[a.value]),
                                       pressure + b * n_pressure,
                                       product);
          for (unsigned int i = 0; i < n; ++i)
            scatter_add(product[i], nodes(b) + i * lanes, batches[b].filled, to + a);
        });
      }
    condense(result);
  }


  template <int dim>
  void
  MultigridLevel<dim>::apply_divergence(const LevelVector<float> &u,
                                        LevelVector<float> &result) const
  {
    using V           = Batch<float>::Values;
    const float *from = u.begin();
    V *to             = aligned(result.begin());
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        const Size size   = cell_size(b);
        V sum[n_pressure] = {};
        for_directions<dim>([&](const auto a) {
          V local[n];
          for (unsigned int i = 0; i < n; ++i)
            local[i] = gather(from + a, nodes(b) + i * lanes);
          feib::add_divergence<dim, a>(float(cell_volume(size) / size[a.value]), local, sum);
        });
        for (unsigned int k = 0; k < n_pressure; ++k)
          to[b * n_pressure + k] = sum[k];
      }
  }


  template <int dim>
  void
  MultigridLevel<dim>::add_inverse_pressure_mass(const float factor,
                                                 const LevelVector<float> &g,
                                                 LevelVector<float> &result) const
  {
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        const float scale = factor / cell_volume(cell_size(b));
        for (unsigned int i = b * n_pressure * lanes; i < (b + 1) * n_pressure * lanes; ++i)
          result.begin()[i] += scale * g.begin()[i];
      }
  }


  template <int dim>
  void
  MultigridLevel<dim>::inverse_diagonal(const VelocityForm &form,
                                        const bool row_sums,
                                        LevelVector<float> &result) const
  {
    reinit_velocity(result);
    std::array<Masters, n> of_node;
    double matrix[dim][n][n], diagonal[dim][n];
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        // The cell's matrices of the components with themselves; cells of one size are neighbours.
        for (unsigned int a = 0; a < dim && (b == 0 || batches[b].edge != batches[b - 1].edge); ++a)
          for (unsigned int j = 0; j < n; ++j)
            {
              double unit_vector[dim * n] = {}, product[dim * n];
              unit_vector[a * n + j]      = 1;
              feib::apply_velocity_form<dim, double>(form, cell_size(b), unit_vector, product);
              std::copy_n(product + a * n, n, matrix[a][j]);
              diagonal[a][j] =
                row_sums ? std::accumulate(matrix[a][j], matrix[a][j] + n, 0.) : matrix[a][j][j];
            }
        for (unsigned int l = 0; l < batches[b].filled; ++l)
          if (row_sums || !hanging_cells[b * lanes + l])
            for (unsigned int i = 0; i < n; ++i)
              for (unsigned int a = 0; a < dim; ++a)
                result.begin()[nodes(b)[i * lanes + l] + a] += diagonal[a][i];
          else
            {
              masters_of(b * lanes + l, of_node);
              std::map<unsigned int, std::array<double, n>> columns; // of the expansion
              for (unsigned int i = 0; i < n; ++i)
                for (const auto &[master, weight] : of_node[i])
                  columns.try_emplace(master, std::array<double, n>{}).first->second[i] += weight;
              for (const auto &[master, column] : columns)
                for (unsigned int a = 0; a < dim; ++a)
                  {
                    double sum = 0;
                    for (unsigned int i = 0; i < n; ++i)
                      if (column[i] != 0)
                        for (unsigned int j = 0; j < n; ++j)
                          sum += column[i] * matrix[a][i][j] * column[j];
                    result.begin()[master + a] += sum;
                  }
            }
      }
    if (row_sums)
      for (unsigned int s = 0; s < slaves.size(); ++s)
        for (unsigned int a = 0; a < dim; ++a)
          {
            float &sum = result.begin()[slaves[s] + a];
            for (unsigned int m = first_master[s]; m < first_master[s + 1]; ++m)
              result.begin()[masters[m] + a] += master_weights[m] * sum;
            sum = 0;
          }
    result.compress(dealii::VectorOperation::add);
    // Where there is nothing, the inverse is not used.
    for (unsigned int i = 0; i < result.locally_owned_size(); ++i)
      result.begin()[i] = inactive_flags[i] ? 0.f : 1 / result.begin()[i];
  }


  template <int dim>
  void
  MultigridLevel<dim>::invert_blocks(LevelVector<float> &weights,
                                     dealii::AlignedVector<float> &blocks) const
  {
    weights.update_ghost_values();
    blocks.resize_fast(batches.size() * n_pressure * n_pressure * lanes);
    const auto &table = divergence_table<dim>.entry;
    std::array<Masters, n> of_node;
    for (unsigned int b = 0; b < batches.size(); ++b)
      {
        const Size size     = cell_size(b);
        const double volume = cell_volume(size);
        for (unsigned int l = 0; l < lanes; ++l)
          {
            const unsigned int slot                  = b * lanes + l;
            double block[n_pressure][2 * n_pressure] = {};
            const auto add = [&](const double(&column)[n_pressure], const double weight) {
              for (unsigned int k = 0; k < n_pressure; ++k)
                for (unsigned int m = 0; m < n_pressure; ++m)
                  block[k][m] += weight * column[k] * column[m];
            };
            for (unsigned int a = 0; a < dim; ++a)
              if (!hanging_cells[slot])
                for (unsigned int i = 0; i < n; ++i)
                  {
                    double column[n_pressure];
                    for (unsigned int k = 0; k < n_pressure; ++k)
                      column[k] = volume / size[a] * table[a][k][i];
                    add(column, weights.begin()[nodes(b)[i * lanes + l] + a]);
                  }
              else
                {
                  masters_of(slot, of_node);
                  std::map<unsigned int, std::array<double, n_pressure>> columns;
                  for (unsigned int i = 0; i < n; ++i)
                    for (const auto &[master, weight] : of_node[i])
                      {
                        auto &column = columns.try_emplace(master, std::array<double, n_pressure>{})
                                         .first->second;
                        for (unsigned int k = 0; k < n_pressure; ++k)
                          column[k] += weight * volume / size[a] * table[a][k][i];
                      }
                  for (const auto &[master, entries] : columns)
                    {
                      double column[n_pressure];
                      std::copy_n(entries.begin(), n_pressure, column);
                      add(column, weights.begin()[master + a]);
                    }
                }
            // Gauss-Jordan, on a symmetric positive definite matrix.
            for (unsigned int k = 0; k < n_pressure; ++k)
              block[k][n_pressure + k] = 1;
            for (unsigned int k = 0; k < n_pressure; ++k)
              {
                const double pivot = block[k][k];
                for (unsigned int j = 0; j < 2 * n_pressure; ++j)
                  block[k][j] = pivot > 0 ? block[k][j] / pivot : 0.;
                for (unsigned int i = 0; i < n_pressure; ++i)
                  if (i != k)
                    {
                      const double factor = block[i][k];
                      for (unsigned int j = 0; j < 2 * n_pressure; ++j)
                        block[i][j] -= factor * block[k][j];
                    }
              }
            for (unsigned int k = 0; k < n_pressure; ++k)
              for (unsigned int m = 0; m < n_pressure; ++m)
                blocks[((b * n_pressure + k) * n_pressure + m) * lanes + l] =
                  block[k][n_pressure + m];
          }
      }
  }


  template <int dim>
  std::pair<double, double>
  MultigridLevel<dim>::spectrum(const VelocityForm &form) const
  {
    constexpr unsigned int n_velocity = dim * n;
    double least = std::numeric_limits<double>::max(), most = 0;
    for (const double edge : edges)
      {
        double matrix[n_velocity][n_velocity];
        for (unsigned int j = 0; j < n_velocity; ++j)
          {
            double unit_vector[n_velocity] = {};
            unit_vector[j]                 = 1;
            feib::apply_velocity_form<dim, double>(form, edge * unit, unit_vector, matrix[j]);
          }
        // Without coupling, the first component tells all.
        const unsigned int n_components = form.couples() ? dim : 1;
        const unsigned int n_unknowns   = open_corners ? n_components * n : n_components << dim;
        for (unsigned int phase = 0; phase < (open_corners ? 1 : 1 << dim); ++phase)
          {
            // Of each unknown of the cell, which of the lattice's 2^dim per cell and component it
            // is, and its sign.
            unsigned int place[n_velocity];
            int sign[n_velocity];
            dealii::Vector<double> diagonal(n_unknowns), values;
            for (unsigned int i = 0; i < n_components * n; ++i)
              {
                place[i] = open_corners ? i : i / n << dim;
                sign[i]  = 1;
                for (unsigned int a = 0, node = i % n; a < dim && !open_corners; ++a, node /= 3)
                  if (node % 3 == 1)
                    place[i] += 1 << a;
                  else if (node % 3 == 2 && (phase >> a & 1))
                    sign[i] = -sign[i];
                diagonal(place[i]) += matrix[i][i];
              }
            dealii::LAPACKFullMatrix<double> scaled(n_unknowns, n_unknowns);
            for (unsigned int i = 0; i < n_components * n; ++i)
              for (unsigned int j = 0; j < n_components * n; ++j)
                scaled(place[i], place[j]) += sign[i] * sign[j] * matrix[i][j] /
                                              std::sqrt(diagonal(place[i]) * diagonal(place[j]));
            dealii::FullMatrix<double> vectors;
            scaled.compute_eigenvalues_symmetric(-1., 2. * n_velocity, 1e-10, values, vectors);
            least = std::min(least, values[0]);
            most  = std::max(most, values[values.size() - 1]);
          }
      }
    return {least, most};
  }


  template <int dim>
  double
  MultigridLevel<dim>::smallest_size() const
  {
    double least = std::numeric_limits<double>::max();
    for (const double edge : edges)
      for (unsigned int a = 0; a < dim; ++a)
        least = std::min(least, edge * unit[a]);
    return least;
  }


  template <int dim>
  double
  MultigridLevel<dim>::aspect_ratio() const
  {
    double least = unit[0], most = unit[0];
    for (unsigned int a = 1; a < dim; ++a)
      {
        least = std::min(least, unit[a]);
        most  = std::max(most, unit[a]);
      }
    return most / least;
  }


  template <int dim>
  void
  MultigridLevel<dim>::fill_pressure(LevelVector<float> &p) const
  {
    reinit_pressure(p);
    for (unsigned int b = 0; b < batches.size(); ++b)
      for (unsigned int l = 0; l < batches[b].filled; ++l)
        for (unsigned int k = 0; k < n_pressure; ++k)
          {
            std::uint64_t x = (cell_keys[b * lanes + l] + 1) * 0x9e3779b97f4a7c15 + k;
            x               = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
            x               = (x ^ (x >> 27)) * 0x94d049bb133111eb;
            p.begin()[(b * n_pressure + k) * lanes + l] = double(x >> 11) / (1ull << 52) - 1.;
          }
  }


  // --- transfer

  namespace
  {
    /// Along direction @p a, from 3 to 5 values (or, transposed, back): the directions before have
    /// 5 already, those after still 3.
    template <int dim, unsigned int a, bool transpose, typename V>
    inline void
    interpolate_line(const V *in, V *out)
    {
      constexpr unsigned int below = power(5, a), above = power(3, dim - 1 - a);
      for (unsigned int high = 0; high < above; ++high)
        for (unsigned int low = 0; low < below; ++low)
          {
            if (!transpose)
              for (unsigned int q = 0; q < 5; ++q)
                {
                  V sum = {};
                  for (unsigned int i = 0; i < 3; ++i)
                    if (quarters[q][i] != 0)
                      sum += float(quarters[q][i]) * in[(high * 3 + i) * below + low];
                  out[(high * 5 + q) * below + low] = sum;
                }
            else
              for (unsigned int i = 0; i < 3; ++i)
                {
                  V sum = {};
                  for (unsigned int q = 0; q < 5; ++q)
                    if (quarters[q][i] != 0)
                      sum += float(quarters[q][i]) * in[(high * 5 + q) * below + low];
                  out[(high * 3 + i) * below + low] = sum;
                }
          }
    }

    template <int dim, bool transpose, typename V>
    inline void
    interpolate(const V *in, V *out)
    {
      constexpr unsigned int most = power(5, dim);
      if constexpr (dim == 2)
        {
          V between[most];
          interpolate_line<2, transpose ? 1 : 0, transpose>(in, between);
          interpolate_line<2, transpose ? 0 : 1, transpose>(between, out);
        }
      else
        {
          V between[most], more[most];
          interpolate_line<3, transpose ? 2 : 0, transpose>(in, between);
          interpolate_line<3, 1, transpose>(between, more);
          interpolate_line<3, transpose ? 0 : 2, transpose>(more, out);
        }
    }
  } // namespace


  template <int dim>
  void
  MultigridLevel<dim>::prolongate_velocity(const LevelVector<float> &coarse,
                                           LevelVector<float> &fine)
  {
    using V             = Batch<float>::Values;
    fine_velocity       = 0;
    const float *from   = coarse.begin();
    const float *weight = node_weights.begin();
    float *to           = fine_velocity.begin();
    for (const Transfer &transfer : transfers)
      for (unsigned int a = 0; a < dim; ++a)
        {
          V in[n], out[n_fine];
          for (unsigned int i = 0; i < n; ++i)
            in[i] = gather(from + a, &transfer.coarse_nodes[i * lanes]);
          if (transfer.refined)
            interpolate<dim, false>(in, out);
          else
            std::copy_n(in, n, out);
          for (unsigned int i = 0; i < transfer.fine_nodes.size() / lanes; ++i)
            for (unsigned int l = 0; l < transfer.filled; ++l)
              {
                const unsigned int k = transfer.fine_nodes[i * lanes + l] + a;
                to[k] += weight[k] * out[i][l];
              }
        }
    fine_velocity.compress(dealii::VectorOperation::add);
    for (unsigned int i = 0; i < fine.locally_owned_size(); ++i)
      fine.begin()[i] += to[i];
  }


  template <int dim>
  void
  MultigridLevel<dim>::restrict_velocity(LevelVector<float> &fine, LevelVector<float> &coarse) const
  {
    using V = Batch<float>::Values;
    fine.update_ghost_values();
    coarse              = 0;
    const float *from   = fine.begin();
    const float *weight = node_weights.begin();
    float *to           = coarse.begin();
    for (const Transfer &transfer : transfers)
      for (unsigned int a = 0; a < dim; ++a)
        {
          V in[n_fine], out[n];
          for (unsigned int i = 0; i < transfer.fine_nodes.size() / lanes; ++i)
            in[i] = gather(from + a, &transfer.fine_nodes[i * lanes]) *
                    gather(weight + a, &transfer.fine_nodes[i * lanes]);
          if (transfer.refined)
            interpolate<dim, true>(in, out);
          else
            std::copy_n(in, n, out);
          for (unsigned int i = 0; i < n; ++i)
            scatter_add(out[i], &transfer.coarse_nodes[i * lanes], transfer.filled, to + a);
        }
    if (sum_over != MPI_COMM_NULL)
      sum(coarse);
  }


  // A linear function of the parent in a child: with c = -1, 1 for the halves, the value at the
  // child's centre and half the slopes.
  template <int dim>
  void
  MultigridLevel<dim>::prolongate_pressure(const LevelVector<float> &coarse,
                                           LevelVector<float> &fine)
  {
    using V           = Batch<float>::Values;
    fine_pressure     = 0;
    const float *from = coarse.begin();
    float *to         = fine_pressure.begin();
    for (const Transfer &transfer : transfers)
      {
        V in[n_pressure];
        for (unsigned int k = 0; k < n_pressure; ++k)
          in[k] = gather(from, &transfer.coarse_pressures[k * lanes]);
        for (unsigned int child = 0; child < transfer.fine_pressures.size() / lanes / n_pressure;
             ++child)
          {
            V out[n_pressure];
            std::copy_n(in, n_pressure, out);
            if (transfer.refined)
              for (unsigned int a = 0; a < dim; ++a)
                {
                  out[0] += (child >> a & 1 ? 1.f : -1.f) * child_slope * in[a + 1];
                  out[a + 1] = .5f * in[a + 1];
                }
            for (unsigned int k = 0; k < n_pressure; ++k)
              scatter_add(out[k],
                          &transfer.fine_pressures[(child * n_pressure + k) * lanes],
                          transfer.filled,
                          to);
          }
      }
    fine_pressure.compress(dealii::VectorOperation::add);
    for (unsigned int i = 0; i < fine.locally_owned_size(); ++i)
      fine.begin()[i] += to[i];
  }


  template <int dim>
  void
  MultigridLevel<dim>::restrict_pressure(LevelVector<float> &fine, LevelVector<float> &coarse) const
  {
    using V = Batch<float>::Values;
    fine.update_ghost_values();
    coarse            = 0;
    const float *from = fine.begin();
    float *to         = coarse.begin();
    for (const Transfer &transfer : transfers)
      {
        V out[n_pressure] = {};
        for (unsigned int child = 0; child < transfer.fine_pressures.size() / lanes / n_pressure;
             ++child)
          {
            V in[n_pressure];
            for (unsigned int k = 0; k < n_pressure; ++k)
              in[k] = gather(from, &transfer.fine_pressures[(child * n_pressure + k) * lanes]);
            if (transfer.refined)
              for (unsigned int a = 0; a < dim; ++a)
                out[a + 1] += .5f * in[a + 1] + (child >> a & 1 ? 1.f : -1.f) * child_slope * in[0];
            else
              for (unsigned int a = 0; a < dim; ++a)
                out[a + 1] += in[a + 1];
            out[0] += in[0];
          }
        for (unsigned int k = 0; k < n_pressure; ++k)
          scatter_add(out[k], &transfer.coarse_pressures[k * lanes], transfer.filled, to);
      }
    if (sum_over != MPI_COMM_NULL)
      sum(coarse);
  }


  template <int dim>
  void
  MultigridLevel<dim>::sum(LevelVector<float> &v) const
  {
    MPI_Allreduce(MPI_IN_PLACE, v.begin(), v.locally_owned_size(), MPI_FLOAT, MPI_SUM, sum_over);
  }


#define FEIB_INSTANTIATE(dim, Number)                                                 \
  template void MultigridLevel<dim>::expand(LevelVector<Number> &) const;             \
  template void MultigridLevel<dim>::condense(LevelVector<Number> &) const;           \
  template void MultigridLevel<dim>::apply_velocity_form(const VelocityForm &,        \
                                                         const LevelVector<Number> &, \
                                                         LevelVector<Number> &) const;

  template class MultigridLevel<2>;
  template class MultigridLevel<3>;
  FEIB_INSTANTIATE(2, float)
  FEIB_INSTANTIATE(2, double)
  FEIB_INSTANTIATE(3, float)
  FEIB_INSTANTIATE(3, double)
} // namespace feib
