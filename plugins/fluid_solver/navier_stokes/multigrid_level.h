// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_multigrid_level_h
#define feib_plugins_navier_stokes_multigrid_level_h

#include "cell_kernels.h"
#include "lattice.h"

#include <deal.II/base/aligned_vector.h>

#include <map>
#include <unordered_map>

namespace feib
{
  template <typename Number>
  using LevelVector = dealii::LinearAlgebra::distributed::Vector<Number>;


  /// Q2 and discontinuous P1 on one mesh of a multigrid hierarchy: this rank's cells, in batches of
  /// equal size, and the forms on them. Boundary values are zero.
  ///
  /// Velocities: unknown dim * node + component; hanging nodes have a place, which expand() fills
  /// and condense() empties. Elsewhere entries of hanging nodes and of prescribed components are
  /// zero, or do not count. Pressures: unknown k of the cell in lane l of batch b is
  /// (b * n_pressure + k) * lanes + l.
  template <int dim>
  class MultigridLevel
  {
  public:
    static constexpr unsigned int lanes      = Batch<float>::lanes;
    static constexpr unsigned int n          = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_pressure = EulerianSpace<dim>::n_pressure;

    using Size   = dealii::Tensor<1, dim>;
    using Family = typename Lattice<dim>::Family;
    using Place  = typename Lattice<dim>::Place;

    /// @p replicated: every rank has all cells. @p coarser and @p families: the next mesh of the
    /// hierarchy, if any, whose cells need to know the nodes of their children. Collective.
    MultigridLevel(const Lattice<dim> &lattice,
                   const Domain<dim> &domain,
                   MPI_Comm communicator,
                   bool replicated,
                   const Lattice<dim> *coarser,
                   const std::vector<Family> *families);

    /// Prepares the transfer from and to @p coarse, the level of the @p coarser mesh. Collective.
    void connect(const MultigridLevel &coarse,
                 const Lattice<dim> &coarser,
                 const std::vector<Family> &families,
                 MPI_Comm world);

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
    void expand(LevelVector<Number> &v) const;

    /// The transpose of expand(): what hanging nodes got goes to their masters; prescribed
    /// components become zero.
    template <typename Number>
    void condense(LevelVector<Number> &v) const;

    // --- forms; arguments are expanded, results of velocity condensed

    /// result = form(u, v)
    template <typename Number>
    void apply_velocity_form(const VelocityForm &form,
                             const LevelVector<Number> &u,
                             LevelVector<Number> &result) const;

    /// result = (p, div v)
    void apply_gradient(const LevelVector<float> &p, LevelVector<float> &result) const;

    /// result = (div u, q)
    void apply_divergence(const LevelVector<float> &u, LevelVector<float> &result) const;

    /// result += factor * Mp^{-1} g, with Mp the mass matrix of the pressure.
    void add_inverse_pressure_mass(float factor,
                                   const LevelVector<float> &g,
                                   LevelVector<float> &result) const;

    /// One over the diagonal (or, with @p row_sums, over the sums of the rows, without those of
    /// other components) of the condensed matrix of the form; zero where the unknown does not
    /// count.
    void
    inverse_diagonal(const VelocityForm &form, bool row_sums, LevelVector<float> &result) const;

    /// The cells' own blocks of B diag(weights) B^T, with B condensed, inverted: of the cell in
    /// lane l of batch b, entry (k, m) at ((b * n_pressure + k) * n_pressure + m) * lanes + l.
    void invert_blocks(LevelVector<float> &weights, dealii::AlignedVector<float> &blocks) const;

    /// The ends of the spectrum of D^{-1} A, with A the matrix of the form and D its diagonal: of
    /// fields on lattices of equal cells that are the same in every cell, or change their sign from
    /// one to the next, direction by direction; where outflows meet, bounds from single cells (A
    /// and D are sums over cells). Near hanging nodes and at an outflow an estimate.
    std::pair<double, double> spectrum(const VelocityForm &form) const;

    /// The shortest edge of a cell.
    double smallest_size() const;

    /// The longest edge of a cell over its shortest; the same for all cells.
    double aspect_ratio() const;

    // --- transfer, with the coarser level given to connect()

    /// fine += P coarse; coarse is expanded
    void prolongate_velocity(const LevelVector<float> &coarse, LevelVector<float> &fine);
    void prolongate_pressure(const LevelVector<float> &coarse, LevelVector<float> &fine);

    /// coarse = P^T fine; for velocities still to be condensed by the coarser level
    void restrict_velocity(LevelVector<float> &fine, LevelVector<float> &coarse) const;
    void restrict_pressure(LevelVector<float> &fine, LevelVector<float> &coarse) const;

    // --- what there is

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

    /// Where in the batches the cells are that this rank has, in the order of the lattice.
    const std::vector<unsigned int> &
    slots() const
    {
      return slot_of_cell;
    }

    /// Whether the unknown of the velocity is prescribed or hanging, so that it does not count.
    bool
    inactive(const unsigned int unknown) const
    {
      return inactive_flags[unknown];
    }

    /// A pseudo-random pressure, which does not depend on the number of ranks.
    void fill_pressure(LevelVector<float> &p) const;

  private:
    struct BatchOfCells
    {
      double edge; // in units of the lattice
      unsigned int filled;
    };

    /// Cells of the coarser level, lane by lane, and their places here: nodes (5^dim of refined
    /// cells, else 3^dim) and pressures (of all children).
    struct Transfer
    {
      bool refined;
      unsigned int filled;
      std::vector<unsigned int> coarse_nodes, fine_nodes, coarse_pressures, fine_pressures;
    };

    static constexpr unsigned int n_fine = dim == 2 ? 25 : 125;
    static constexpr float child_slope   = LineMatrices::root / 4;

    unsigned int insert_node(std::array<std::int64_t, dim> place, const Lattice<dim> &lattice);

    void find_hanging_nodes(const Lattice<dim> &lattice);

    void number_nodes(const Lattice<dim> &lattice,
                      const Lattice<dim> *coarser,
                      const std::vector<Family> *families,
                      bool replicated);

    void find_prescribed(const Lattice<dim> &lattice, const Domain<dim> &domain);

    /// The local index of the k-th pressure of a cell of the lattice, owned or a ghost.
    unsigned int local_pressure(unsigned int cell, unsigned int k) const;

    /// Of each node of a cell, where its value comes from: (dim * node, weight).
    using Masters = std::vector<std::pair<unsigned int, double>>;
    void masters_of(unsigned int slot, std::array<Masters, n> &result) const;

    void sum(LevelVector<float> &v) const;

    MPI_Comm communicator; // MPI_COMM_SELF for replicated levels
    Size unit;
    std::vector<double> edges; // of all cells of the lattice
    std::vector<BatchOfCells> batches;
    std::vector<unsigned int> node_table;
    unsigned int first_cell = 0;            // of this rank in the lattice
    std::vector<unsigned int> slot_of_cell; // of this rank's cells in the order of the lattice
    std::vector<std::uint64_t> cell_keys;   // by slot

    // While setting up: all nodes known here.
    KeyTable node_index;
    std::vector<Place> places;

    // Hanging nodes and their masters, as dim * node.
    std::vector<unsigned int> slaves, first_master, masters;
    std::vector<double> master_weights;
    std::unordered_map<unsigned int, unsigned int> line_of_slave;
    std::vector<bool> hanging_cells; // by slot
    std::vector<bool> inactive_flags;
    bool open_corners = false;                   // outflows meet somewhere
    std::vector<unsigned int> inactive_unknowns; // owned

    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> velocity_partitioner,
      pressure_partitioner;
    std::map<unsigned int, std::vector<unsigned int>> ghost_pressure_table;

    std::vector<Transfer> transfers;
    LevelVector<float> node_weights; // 1 / number of coarse cells a node is in
    LevelVector<float> fine_velocity, fine_pressure;
    MPI_Comm sum_over = MPI_COMM_NULL; // what is restricted is summed over these ranks
  };
} // namespace feib

#endif
