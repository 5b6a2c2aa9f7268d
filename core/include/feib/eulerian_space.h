// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_eulerian_space_h
#define feib_eulerian_space_h

#include <feib/archive.h>
#include <feib/cartesian_forest.h>
#include <feib/domain.h>
#include <feib/flat_constraints.h>
#include <feib/lattice.h>

#include <deal.II/base/partitioner.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/fe_dgp.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/mapping_cartesian.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <deque>
#include <functional>
#include <memory>
#include <vector>

namespace feib
{
  using VelocityVector = dealii::LinearAlgebra::distributed::Vector<double>;
  using PressureVector = dealii::LinearAlgebra::distributed::Vector<double>;

  /// The mesh of the box, the Q2 velocity and discontinuous P1 pressure spaces on it, their
  /// constraints and the state of the fluid: what solver, couplings, refinement and output share.
  ///
  /// Cells are offered twice: as deal.II iterators, and as flat arrays (cells(), velocity_dofs(),
  /// pressure_dofs()) for loops that run in every step.
  template <int dim>
  class EulerianSpace
  {
  public:
    /// Velocity nodes of a cell and velocity unknowns of a cell.
    static constexpr unsigned int n_nodes    = dim == 2 ? 9 : 27;
    static constexpr unsigned int n_velocity = dim * n_nodes;
    static constexpr unsigned int n_pressure = dim + 1;

    /// A locally owned cell.
    struct Cell
    {
      dealii::Point<dim> lower;
      dealii::Tensor<1, dim> size;
      unsigned int level; // 0: a base cell
    };

    /// A face of a locally owned cell in the boundary of the box, and the number of the domain's
    /// condition at its centre.
    struct BoundaryFace
    {
      unsigned int cell, face, condition;
    };

    EulerianSpace(Domain<dim> domain, MPI_Comm communicator = MPI_COMM_WORLD);
    EulerianSpace(const EulerianSpace &) = delete;

    // --- mesh and spaces

    const Domain<dim> &domain() const;
    MPI_Comm communicator() const;

    /// The base cells of the domain and what they were split into. The trees of the forest are
    /// larger than base cells where the numbers of cells allow, so that levels of deal.II count
    /// from there: see level().
    const dealii::parallel::distributed::Triangulation<dim> &triangulation() const;

    /// How often a base cell was halved to give @p cell, which must not be artificial.
    int
    level(const dealii::CellAccessor<dim> &cell) const
    {
      return cell.level() - int(base_level);
    }

    const dealii::DoFHandler<dim> &velocity_handler() const;
    const dealii::DoFHandler<dim> &pressure_handler() const;
    const dealii::MappingCartesian<dim> &mapping() const;

    /// Hanging nodes, periodicity and velocity boundary conditions at the time of set_time(); after
    /// that of three arguments the values of distribute() are on the way, these are of its end.
    const dealii::AffineConstraints<double> &constraints() const;

    /// Counts the changes of mesh and spaces; what depends on them compares it.
    unsigned int revision() const;

    /// Marks and executes refinement until @p mark sets no flag on any rank (or once only), moving
    /// the state to the new mesh when there is one. Base cells are not coarsened. Returns whether
    /// the mesh changed. Throws RunFailure, and leaves the mesh, when the cells would be too small
    /// for a Lattice. Collective.
    using Mark = std::function<void(dealii::parallel::distributed::Triangulation<dim> &)>;
    bool adapt(const Mark &mark, bool repeat);

    /// Evaluates the velocity boundary conditions at time t. In an enclosed box, a net flux of the
    /// size of the error of interpolation is spread over what goes in and out, so that there is
    /// none. Throws RunFailure when a condition is not finite at a node, or when more goes in than
    /// out. Collective.
    void set_time(double t);

    /// The same for t, @p share of the way along a step that ends at @p end: on the straight line
    /// from old_velocity to the conditions there. With those at t a scheme that goes on along a
    /// half step would mirror for ever by what old_velocity misses its own, as it does after a
    /// kink.
    void set_time(double t, double share, double end);

    /// What is wrong with the velocity boundary conditions at the first of these times when
    /// something is; the same that set_time() refuses. Leaves the present time. Collective.
    Issues check_boundary(const std::vector<double> &times);

    /// The share of the flux through the boundary that was spread to make the net flux zero; 0:
    /// none had to be.
    double spread_flux() const;

    // --- flat access to the locally owned cells

    const std::vector<Cell> &cells() const;

    /// In the order of cells(); none across periodic directions.
    const std::vector<BoundaryFace> &boundary_faces() const;

    /// The local indices (VelocityVector::local_element) of the velocity unknowns of cell @p c:
    /// n_velocity of them, component by component, nodes lexicographic (x fastest) at 0, 1/2, 1.
    const unsigned int *
    velocity_dofs(const unsigned int c) const
    {
      return &velocity_dof_table[c * n_velocity];
    }

    /// The local indices of the pressure unknowns of cell @p c, in the order of FE_DGP(1); the
    /// first basis function is 1.
    const unsigned int *
    pressure_dofs(const unsigned int c) const
    {
      return &pressure_dof_table[c * n_pressure];
    }

    const CartesianForest<dim> &forest() const;

    /// The places of all nodes, in half edges of the smallest cell of any rank.
    const Lattice<dim> &lattice() const;

    /// The smallest edge of any cell, over all ranks: h_x.
    double smallest_edge() const;

    /// Values of the n_nodes scalar shape functions at a place of the unit cell.
    static void shape_values(const dealii::Point<dim> &unit, double *values);

    // --- vectors

    /// A zero velocity (pressure) with ghost entries for the cells this rank knows.
    VelocityVector make_velocity() const;
    PressureVector make_pressure() const;

    /// From a compressed vector over all degrees of freedom to the constrained space: the value of
    /// a constrained unknown is given to its masters (C^T) and set to zero. Boundary values count
    /// as zero.
    void condense(VelocityVector &v) const;

    /// The same for hanging nodes and periodic images alone: prescribed unknowns keep what they
    /// have and get what hangs on them, which makes a residual the reaction. Collective.
    void condense_continuity(VelocityVector &v) const;

    /// Sets constrained entries from their masters. With @p homogeneous, prescribed values count as
    /// zero.
    void distribute(VelocityVector &v, bool homogeneous) const;

    // --- the state

    VelocityVector velocity;       ///< u at the end of the present step
    VelocityVector old_velocity;   ///< u^n, the last accepted state
    VelocityVector older_velocity; ///< u^{n-1}
    PressureVector pressure;       ///< p, at the time of the state

    /// A pressure that belongs to another time than the state.
    struct EarlierPressure
    {
      double time = 0;
      PressureVector values;

      void
      archive(Archive &archive)
      {
        archive("time", time);
        archive("values", values);
      }
    };

    /// The latest first, kept by schemes that solve for pressures within a step.
    std::deque<EarlierPressure> earlier_pressures;
    double old_dt = 0; ///< t^n - t^{n-1}; 0 before the second step

    /// The state between two steps; the mesh too where the medium is persistent, so that reading
    /// changes the mesh. Collective.
    void archive(Archive &archive);

  private:
    /// The lattice of the mesh, or (@p refined) of the one that the flags lead to. Throws
    /// RunFailure when there is no room for its nodes. Collective.
    Lattice<dim> make_lattice(bool refined) const;
    void distribute_dofs();
    void make_constraints(double t);
    void flatten_constraints();
    void find_boundary_faces();
    Issues absent_parts() const; // conditions that hold nowhere
    void archive_mesh(Archive &archive);
    std::vector<unsigned char> levels_in_order() const; // deal.II's, of all cells of all ranks

    Domain<dim> box;
    MPI_Comm mpi_communicator;
    dealii::parallel::distributed::Triangulation<dim> mesh;
    dealii::MappingCartesian<dim> cartesian_mapping;
    dealii::FESystem<dim> velocity_fe;
    dealii::FE_DGP<dim> pressure_fe;
    dealii::DoFHandler<dim> velocity_dof_handler, pressure_dof_handler;
    dealii::AffineConstraints<double> velocity_constraints;
    Issues boundary_issues;  // of the present time
    double spread_share = 0; // of the flux through the boundary
    dealii::IndexSet relevant_velocity;
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> velocity_partitioner,
      pressure_partitioner;
    CartesianForest<dim> locator;
    Lattice<dim> node_lattice;
    std::vector<Cell> cell_list;
    std::vector<BoundaryFace> boundary_face_list;
    std::vector<unsigned int> velocity_dof_table, pressure_dof_table;
    unsigned int base_level      = 0; // of deal.II's levels, that of the base cells
    unsigned int revision_number = 0;
    std::uint64_t fingerprint    = 0; // tells meshes apart, the same for any division between ranks
    double smallest_edge_length = 0, present_time = 0;
    double constraints_time = 0; // of velocity_constraints

    FlatConstraints flat_constraints;
    bool on_the_way = false; // set_time(t, share, end) has changed them

    /// Made when asked for.
    struct Continuity
    {
      std::shared_ptr<const dealii::Utilities::MPI::Partitioner> partitioner;
      FlatConstraints constraints;
    };
    mutable std::unique_ptr<const Continuity> continuity;
  };
} // namespace feib

#endif
