// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_level_space_h
#define feib_plugins_navier_stokes_level_space_h

#include "multigrid/hanging_nodes.h"
#include "multigrid/lattice_cells.h"
#include "operators/cell_kernels.h"

#include <map>
#include <memory>
#include <set>
#include <vector>

namespace feib
{
  template <typename Number>
  using LevelVector = dealii::LinearAlgebra::distributed::Vector<Number>;

  /// Digit @p a of the lexicographic number i of a node (or of another @p base).
  inline unsigned int
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

  /// Values of the quadratic shape functions of an edge at quarters of it, 0, 1, ..., 4.
  constexpr double quarters[5][3] = {{1, 0, 0},
                                     {3 / 8., 3 / 4., -1 / 8.},
                                     {0, 1, 0},
                                     {-1 / 8., 3 / 4., 3 / 8.},
                                     {0, 0, 1}};


  /// The unknowns of Q2 and discontinuous P1 on one mesh of a multigrid hierarchy: this rank's
  /// cells, in batches of equal size, and what their nodes are called. Boundary values are zero.
  ///
  /// Velocities: unknown dim * node + component; hanging nodes have a place, which expand() fills
  /// and condense() empties. Elsewhere entries of hanging nodes and of prescribed components are
  /// zero, or do not count. Pressures: unknown k of the cell in lane l of batch b is
  /// (b * n_pressure + k) * lanes + l. The cell there is that of the slot b * lanes + l.
  template <int dim>
  class LevelSpace
  {
  public:
    static constexpr unsigned int lanes      = Batch<float>::lanes;
    static constexpr unsigned int n          = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_pressure = EulerianSpace<dim>::n_pressure;

    using Size   = dealii::Tensor<1, dim>;
    using Family = typename LatticeCells<dim>::Family;
    using Place  = typename Lattice<dim>::Place;

    /// @p replicated: every rank has all cells. @p coarser and @p families: the next mesh of the
    /// hierarchy, if any, whose cells need to know the nodes of their children. Collective.
    LevelSpace(const LatticeCells<dim> &mesh,
               const Domain<dim> &domain,
               MPI_Comm communicator,
               bool replicated,
               const LatticeCells<dim> *coarser,
               const std::vector<Family> *families);

    // --- vectors

    template <typename Number>
    void
    reinit_velocity(LevelVector<Number> &v) const
    {
      v.reinit(velocity_partitioner);
    }

    template <typename Number>
    void
    reinit_pressure(LevelVector<Number> &p) const
    {
      p.reinit(pressure_partitioner);
    }

    /// Ghost values and hanging nodes from the others.
    template <typename Number>
    void
    expand(LevelVector<Number> &v) const
    {
      v.update_ghost_values();
      hanging_nodes.expand(v.begin());
    }

    /// The transpose of expand(): what hanging nodes got goes to their masters; prescribed
    /// components become zero.
    template <typename Number>
    void
    condense(LevelVector<Number> &v) const
    {
      hanging_nodes.condense(v.begin());
      v.compress(dealii::VectorOperation::add);
      for (const unsigned int i : inactive_unknowns)
        v.begin()[i] = 0;
    }

    /// What hanging nodes have goes to their masters, on this rank.
    void
    condense_here(LevelVector<float> &v) const
    {
      hanging_nodes.condense(v.begin());
    }

    /// Whether the unknown of the velocity is prescribed or hanging, so that it does not count.
    bool
    inactive(const unsigned int unknown) const
    {
      return inactive_flags[unknown];
    }

    // --- cells

    bool
    is_replicated() const
    {
      return communicator == MPI_COMM_SELF;
    }

    /// The number of batches, and of cells in a batch.
    unsigned int
    n_batches() const
    {
      return batches.size();
    }
    unsigned int
    n_filled(const unsigned int batch) const
    {
      return batches[batch].filled;
    }
    Size
    cell_size(const unsigned int batch) const
    {
      return batches[batch].edge * unit;
    }

    /// dim times the node, for the nodes of a batch: node i of lane l at i * lanes + l.
    const unsigned int *
    nodes(const unsigned int batch) const
    {
      return &node_table[batch * n * lanes];
    }

    /// dim times node i of the cell in a slot.
    unsigned int
    node(const unsigned int slot, const unsigned int i) const
    {
      return node_table[(slot / lanes * n + i) * lanes + slot % lanes];
    }

    /// Pressure k of the cell in a slot.
    static unsigned int
    pressure(const unsigned int slot, const unsigned int k)
    {
      return (slot / lanes * n_pressure + k) * lanes + slot % lanes;
    }

    /// Where in the batches the cells are that this rank has, in the order of the mesh.
    const std::vector<unsigned int> &
    slots() const
    {
      return slot_of_cell;
    }

    /// The same for a cell of the mesh that this rank has.
    unsigned int
    slot(const unsigned int cell) const
    {
      return slot_of_cell[cell - first_cell];
    }

    /// A number that tells cells apart, the same for any division between ranks.
    std::uint64_t
    cell_key(const unsigned int slot) const
    {
      return cell_keys[slot];
    }

    /// Whether the cell in a slot has hanging nodes.
    bool
    has_hanging_nodes(const unsigned int slot) const
    {
      return hanging_cells[slot];
    }

    /// The nodes that those of the cell in a slot get their values from (dim times their number),
    /// and how much of it each of the n gets.
    using Sources = std::map<unsigned int, std::array<double, n>>;
    Sources sources(unsigned int slot) const;

    // --- the mesh as a whole

    /// The sizes of the cells of all ranks.
    const std::vector<Size> &
    sizes() const
    {
      return all_sizes;
    }

    /// The shortest edge of a cell.
    double smallest_size() const;

    /// The longest edge of a cell over its shortest; the same for all cells.
    double aspect_ratio() const;

    /// Whether open faces of different directions meet.
    bool
    has_open_corners() const
    {
      return open_corners;
    }

    // --- while transfer is set up

    /// dim times the node at a place of the closed box.
    unsigned int node_at(Place place, const Lattice<dim> &lattice) const;

    /// The local index of pressure k of a cell of the mesh: this rank's, or a child of one of its
    /// cells of the coarser mesh.
    unsigned int local_pressure(unsigned int cell, unsigned int k) const;

    /// Frees what node_at() needs.
    void
    forget_places()
    {
      node_index = KeyTable();
      places     = {};
    }

  private:
    using Cell        = typename LatticeCells<dim>::Cell;
    using GlobalIndex = dealii::types::global_dof_index;
    using Masters     = typename HangingNodes<dim>::Masters;

    struct BatchOfCells
    {
      double edge; // in units of the lattice
      unsigned int filled;
    };

    /// Puts the cells into batches. Returns the cell of each slot.
    std::vector<unsigned int> make_batches(const LatticeCells<dim> &mesh, unsigned int end);

    unsigned int insert_node(Place place, const Lattice<dim> &lattice);

    void find_hanging_nodes(const LatticeCells<dim> &mesh);

    /// The nodes of a cell that hang on the cell beside its parent, in the direction of @p step.
    void hang_nodes(const Cell &cell,
                    unsigned int slot,
                    const std::array<int, dim> &step,
                    const Lattice<dim> &lattice,
                    std::vector<bool> &known);

    /// The children, on other ranks, of this rank's cells of the coarser mesh.
    std::set<unsigned int> find_ghost_cells(const LatticeCells<dim> &mesh,
                                            const LatticeCells<dim> *coarser,
                                            const std::vector<Family> *families) const;

    /// Numbers the nodes: this rank's first, in the order met, then the others.
    void number_nodes(const LatticeCells<dim> &mesh);

    /// The local numbers of nodes of other ranks, from @p number of this rank's; returns their
    /// global ones.
    dealii::IndexSet number_ghosts(const std::map<unsigned int, std::vector<unsigned int>> &asked,
                                   GlobalIndex first_node,
                                   GlobalIndex n_nodes,
                                   unsigned int n_owned,
                                   std::vector<unsigned int> &number) const;

    void number_pressures(const LatticeCells<dim> &mesh, const std::set<unsigned int> &ghost_cells);

    void find_prescribed(const Lattice<dim> &lattice, const Domain<dim> &domain);

    const MPI_Comm communicator; // MPI_COMM_SELF for replicated levels
    const Size unit;
    const unsigned int first_cell; // of this rank in the mesh
    std::vector<Size> all_sizes;
    std::vector<BatchOfCells> batches;
    std::vector<unsigned int> node_table;
    std::vector<unsigned int> slot_of_cell; // of this rank's cells in the order of the mesh
    std::vector<std::uint64_t> cell_keys;   // by slot
    std::vector<bool> hanging_cells;        // by slot

    HangingNodes<dim> hanging_nodes;

    // While setting up: all nodes known here.
    KeyTable node_index;
    std::vector<Place> places;

    std::vector<bool> inactive_flags;
    std::vector<unsigned int> inactive_unknowns; // owned
    bool open_corners = false;

    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> velocity_partitioner,
      pressure_partitioner;
    std::map<unsigned int, std::vector<unsigned int>> ghost_pressure_table;
  };
} // namespace feib

#endif
