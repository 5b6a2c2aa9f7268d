// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_direct_solver_h
#define feib_plugins_navier_stokes_direct_solver_h

#include <feib/implicit_load.h>

#include <deal.II/lac/petsc_sparse_matrix.h>

#include <petscksp.h>

#include <functional>
#include <vector>

namespace feib
{
  /// The factorised saddle point matrix [A -B^T; -B 0] of all velocity and pressure unknowns, by
  /// MUMPS through PETSc: L D L^T when A is symmetric, L U otherwise. In an enclosed flow the first
  /// pressure unknown is held at zero.
  template <int dim>
  class DirectSolver
  {
  public:
    static constexpr unsigned int n_local =
      EulerianSpace<dim>::n_velocity + EulerianSpace<dim>::n_pressure;

    /// The matrix of a cell, velocity unknowns first.
    using CellMatrix = std::function<void(unsigned int cell, dealii::FullMatrix<double> &matrix)>;

    DirectSolver()                     = default;
    DirectSolver(const DirectSolver &) = delete;
    ~DirectSolver();

    /// Assembles and factorises, with the sum of the products added to the velocity block.
    /// @p symmetric: whether the cells' matrices are. Collective. Throws RunFailure when MUMPS
    /// fails.
    void factorize(const EulerianSpace<dim> &space,
                   const CellMatrix &cell_matrix,
                   bool symmetric,
                   const std::vector<typename ImplicitLoad<dim>::Product> &products = {});

    /// (u, p) = matrix^{-1} (f, g) for condensed f; constrained entries of u are zero. Collective.
    void
    solve(const VelocityVector &f, const PressureVector &g, VelocityVector &u, PressureVector &p);

  private:
    void clear();

    void number_unknowns(const EulerianSpace<dim> &space);

    /// Those of the space, and the pressure held at zero.
    void make_constraints(const EulerianSpace<dim> &space);

    /// The number of a velocity or pressure unknown among all unknowns.
    dealii::types::global_dof_index number_of_velocity(dealii::types::global_dof_index i) const;
    dealii::types::global_dof_index number_of_pressure(dealii::types::global_dof_index i) const;

    void assemble(const EulerianSpace<dim> &space,
                  const CellMatrix &cell_matrix,
                  dealii::PETScWrappers::MPI::SparseMatrix &matrix) const;

    /// matrix += left^T middle right
    void add_product(Mat matrix,
                     const EulerianSpace<dim> &space,
                     const typename ImplicitLoad<dim>::Product &product) const;

    /// Factorises an assembled matrix.
    void run_mumps(Mat matrix, bool symmetric);

    /// Tries to, with that room; 0, or the error of MUMPS.
    int try_mumps(Mat matrix, bool symmetric);

    // Numbers of all unknowns: of each rank first its velocities, then its pressures.
    unsigned int numbering_revision = 0;
    dealii::IndexSet owned;
    std::vector<dealii::types::global_dof_index> cell_indices;
    std::vector<dealii::types::global_dof_index> first_velocity, first_pressure; // of each rank
    dealii::AffineConstraints<double> constraints;

    KSP solver          = nullptr;
    int room            = 60; // per cent more than MUMPS expects to need; grows where it must
    Vec right_hand_side = nullptr, solution = nullptr;
  };
} // namespace feib

#endif
