// SPDX-License-Identifier: LGPL-2.1-or-later
#include "direct/direct_solver.h"

#include <feib/error.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/petsc_sparse_matrix.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>
#include <memory>

namespace feib
{
  namespace
  {
    void
    check(const PetscErrorCode code, const std::string &what)
    {
      if (code != 0)
        throw RunFailure("the direct solver failed in " + what + " (PETSc error " +
                         std::to_string(code) + ")");
    }

    /// The rank that owns unknown i, given the first unknown of each.
    unsigned int
    rank_of(const std::vector<dealii::types::global_dof_index> &first,
            const dealii::types::global_dof_index i)
    {
      return std::upper_bound(first.begin(), first.end(), i) - first.begin() - 1;
    }


    /// A matrix of PETSc that is destroyed with its holder.
    struct Destroy
    {
      void
      operator()(Mat matrix) const
      {
        MatDestroy(&matrix);
      }
    };
    using MatrixHolder = std::unique_ptr<std::remove_pointer_t<Mat>, Destroy>;


    /// A sparse matrix from entries in any order, of any rank's rows.
    MatrixHolder
    matrix_from_entries(const MPI_Comm communicator,
                        const PetscInt local_rows,
                        const PetscInt local_columns,
                        const MatrixEntries &entries)
    {
      std::vector<PetscInt> rows, columns;
      std::vector<PetscScalar> values;
      for (const MatrixEntry &entry : entries)
        {
          rows.push_back(entry.row);
          columns.push_back(entry.column);
          values.push_back(entry.value);
        }
      Mat matrix;
      check(MatCreate(communicator, &matrix), "set-up");
      MatrixHolder holder(matrix);
      check(MatSetSizes(matrix, local_rows, local_columns, PETSC_DETERMINE, PETSC_DETERMINE),
            "set-up");
      check(MatSetType(matrix, MATAIJ), "set-up");
      check(MatSetPreallocationCOO(matrix, rows.size(), rows.data(), columns.data()), "set-up");
      check(MatSetValuesCOO(matrix, values.data(), ADD_VALUES), "set-up");
      return holder;
    }
  } // namespace


  template <int dim>
  DirectSolver<dim>::~DirectSolver()
  {
    clear();
  }


  template <int dim>
  void
  DirectSolver<dim>::clear()
  {
    KSPDestroy(&solver);
    VecDestroy(&right_hand_side);
    VecDestroy(&solution);
  }


  template <int dim>
  void
  DirectSolver<dim>::number_unknowns(const EulerianSpace<dim> &space)
  {
    const MPI_Comm communicator = space.communicator();
    const auto velocities =
      dealii::Utilities::MPI::all_gather(communicator,
                                         space.velocity_handler().n_locally_owned_dofs());
    const auto pressures =
      dealii::Utilities::MPI::all_gather(communicator,
                                         space.pressure_handler().n_locally_owned_dofs());
    const unsigned int n_ranks = velocities.size();
    first_velocity.assign(n_ranks + 1, 0);
    first_pressure.assign(n_ranks + 1, 0);
    for (unsigned int r = 0; r < n_ranks; ++r)
      {
        first_velocity[r + 1] = first_velocity[r] + velocities[r];
        first_pressure[r + 1] = first_pressure[r] + pressures[r];
      }

    const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(communicator);
    const auto total        = first_velocity[n_ranks] + first_pressure[n_ranks];
    owned                   = dealii::IndexSet(total);
    owned.add_range(first_velocity[rank] + first_pressure[rank],
                    first_velocity[rank + 1] + first_pressure[rank + 1]);

    const auto &velocity_partitioner = *space.velocity.get_partitioner();
    const auto &pressure_partitioner = *space.pressure.get_partitioner();
    cell_indices.clear();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        for (unsigned int i = 0; i < EulerianSpace<dim>::n_velocity; ++i)
          cell_indices.push_back(
            number_of_velocity(velocity_partitioner.local_to_global(space.velocity_dofs(c)[i])));
        for (unsigned int i = 0; i < EulerianSpace<dim>::n_pressure; ++i)
          cell_indices.push_back(
            number_of_pressure(pressure_partitioner.local_to_global(space.pressure_dofs(c)[i])));
      }
  }


  template <int dim>
  void
  DirectSolver<dim>::make_constraints(const EulerianSpace<dim> &space)
  {
    dealii::IndexSet relevant = owned;
    std::vector<dealii::types::global_dof_index> ghosts;
    const auto &velocity_lines = space.constraints().get_local_lines();
    for (const auto i : velocity_lines)
      {
        ghosts.push_back(number_of_velocity(i));
        if (space.constraints().is_constrained(i))
          for (const auto &entry : *space.constraints().get_constraint_entries(i))
            ghosts.push_back(number_of_velocity(entry.first));
      }
    ghosts.insert(ghosts.end(), cell_indices.begin(), cell_indices.end());
    std::sort(ghosts.begin(), ghosts.end());
    relevant.add_indices(ghosts.begin(), ghosts.end());

    constraints.reinit(relevant);
    for (const auto i : velocity_lines)
      if (space.constraints().is_constrained(i))
        {
          const auto row = number_of_velocity(i);
          constraints.add_line(row);
          for (const auto &[master, weight] : *space.constraints().get_constraint_entries(i))
            constraints.add_entry(row, number_of_velocity(master), weight);
        }
    const auto pinned = number_of_pressure(0);
    if (space.domain().enclosed() && relevant.is_element(pinned))
      constraints.add_line(pinned);
    constraints.close();
  }


  template <int dim>
  dealii::types::global_dof_index
  DirectSolver<dim>::number_of_velocity(const dealii::types::global_dof_index i) const
  {
    return i + first_pressure[rank_of(first_velocity, i)];
  }


  template <int dim>
  dealii::types::global_dof_index
  DirectSolver<dim>::number_of_pressure(const dealii::types::global_dof_index i) const
  {
    return i + first_velocity[rank_of(first_pressure, i) + 1];
  }


  template <int dim>
  void
  DirectSolver<dim>::add_product(Mat matrix,
                                 const EulerianSpace<dim> &space,
                                 const typename ImplicitLoad<dim>::Product &product) const
  {
    const MPI_Comm communicator = space.communicator();
    const unsigned int rank     = dealii::Utilities::MPI::this_mpi_process(communicator);
    const unsigned int n_ranks  = dealii::Utilities::MPI::n_mpi_processes(communicator);
    const auto share            = [&](const std::uint64_t n) -> PetscInt {
      return n * (rank + 1) / n_ranks - n * rank / n_ranks;
    };
    // A constrained unknown hands its entry to its masters.
    const auto condensed = [&](const MatrixEntries &entries) {
      MatrixEntries result;
      for (const MatrixEntry &entry : entries)
        if (!space.constraints().is_constrained(entry.column))
          result.push_back({entry.row, number_of_velocity(entry.column), entry.value});
        else
          for (const auto &[master, weight] :
               *space.constraints().get_constraint_entries(entry.column))
            result.push_back({entry.row, number_of_velocity(master), weight * entry.value});
      return result;
    };
    const PetscInt columns = owned.n_elements();
    const MatrixHolder right =
      matrix_from_entries(communicator, share(product.n_right), columns, condensed(product.right));
    const MatrixHolder middle = matrix_from_entries(communicator,
                                                    share(product.n_left),
                                                    share(product.n_right),
                                                    product.middle);
    Mat result;
    if (product.symmetric)
      check(MatPtAP(middle.get(), right.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &result),
            "a product");
    else
      {
        const MatrixHolder left = matrix_from_entries(communicator,
                                                      share(product.n_left),
                                                      columns,
                                                      condensed(product.left));
        Mat half;
        check(MatMatMult(middle.get(), right.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &half),
              "a product");
        const MatrixHolder half_holder(half);
        check(MatTransposeMatMult(left.get(), half, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &result),
              "a product");
      }
    const MatrixHolder result_holder(result);
    check(MatAXPY(matrix, 1., result, DIFFERENT_NONZERO_PATTERN), "a sum");
  }


  template <int dim>
  void
  DirectSolver<dim>::assemble(const EulerianSpace<dim> &space,
                              const CellMatrix &cell_matrix,
                              dealii::PETScWrappers::MPI::SparseMatrix &matrix) const
  {
    std::vector<dealii::types::global_dof_index> indices(n_local);
    const auto indices_of = [&](const unsigned int c) -> const auto &
    {
      std::copy_n(cell_indices.begin() + c * n_local, n_local, indices.begin());
      return indices;
    };
    dealii::DynamicSparsityPattern pattern(constraints.get_local_lines());
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      constraints.add_entries_local_to_global(indices_of(c), pattern, false);
    dealii::SparsityTools::distribute_sparsity_pattern(pattern,
                                                       owned,
                                                       space.communicator(),
                                                       constraints.get_local_lines());
    matrix.reinit(owned, owned, pattern, space.communicator());

    dealii::FullMatrix<double> local(n_local, n_local);
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        local = 0;
        cell_matrix(c, local);
        constraints.distribute_local_to_global(local, indices_of(c), matrix);
      }
    matrix.compress(dealii::VectorOperation::add);
  }


  template <int dim>
  void
  DirectSolver<dim>::factorize(const EulerianSpace<dim> &space,
                               const CellMatrix &cell_matrix,
                               const bool symmetric_cells,
                               const std::vector<typename ImplicitLoad<dim>::Product> &products)
  {
    clear();
    if (numbering_revision != space.revision())
      {
        number_unknowns(space);
        make_constraints(space);
        numbering_revision = space.revision();
      }
    dealii::PETScWrappers::MPI::SparseMatrix matrix;
    assemble(space, cell_matrix, matrix);
    Mat petsc_matrix = matrix.petsc_matrix();
    bool symmetric   = symmetric_cells;
    for (const auto &product : products)
      {
        add_product(petsc_matrix, space, product);
        symmetric = symmetric && product.symmetric;
      }
    check(MatSetOption(petsc_matrix, MAT_SYMMETRIC, symmetric ? PETSC_TRUE : PETSC_FALSE),
          "set-up");
    run_mumps(petsc_matrix, symmetric);
  }


  template <int dim>
  void
  DirectSolver<dim>::run_mumps(Mat matrix, const bool symmetric)
  {
    // Arrays and, on several ranks, buffers that are too small for pivots that were delayed.
    const auto wants_room = [](const int status) {
      return status == -8 || status == -9 || status == -17 || status == -20;
    };
    int status = try_mumps(matrix, symmetric);
    for (; wants_room(status) && room < 1000; status = try_mumps(matrix, symmetric))
      room *= 5;
    if (status != 0)
      throw RunFailure("the factorisation of the fluid matrix failed: MUMPS reports INFOG(1) = " +
                       std::to_string(status) +
                       (wants_room(status) ? ", with " + std::to_string(room) +
                                               " % more room than it expected to need"
                        : status == -13 ? std::string(" (out of memory)")
                                        : ""));
    check(MatCreateVecs(matrix, &solution, &right_hand_side), "set-up");
  }


  template <int dim>
  int
  DirectSolver<dim>::try_mumps(Mat matrix, const bool symmetric)
  {
    KSPDestroy(&solver);
    check(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), &solver), "set-up");
    check(KSPSetOperators(solver, matrix, matrix), "set-up");
    check(KSPSetType(solver, KSPPREONLY), "set-up");
    PC preconditioner;
    check(KSPGetPC(solver, &preconditioner), "set-up");
    check(PCSetType(preconditioner, symmetric ? PCCHOLESKY : PCLU), "set-up");
    check(PCFactorSetMatSolverType(preconditioner, MATSOLVERMUMPS), "set-up");
    check(PCFactorSetUpMatSolverType(preconditioner), "set-up");
    Mat factor;
    check(PCFactorGetMatrix(preconditioner, &factor), "set-up");
    check(MatMumpsSetIcntl(factor, 7, 5), "set-up"); // ordering by METIS
    check(MatMumpsSetIcntl(factor, 14, room), "set-up");
    check(KSPSetUp(solver), "the factorisation");
    PetscInt status = 0;
    check(MatMumpsGetInfog(factor, 1, &status), "the factorisation");
    return std::min<int>(status, 0); // above 0 are warnings
  }


  template <int dim>
  void
  DirectSolver<dim>::solve(const VelocityVector &f,
                           const PressureVector &g,
                           VelocityVector &u,
                           PressureVector &p)
  {
    const unsigned int n_u = f.locally_owned_size(), n_p = g.locally_owned_size();
    PetscScalar *values;
    check(VecGetArray(right_hand_side, &values), "a solve");
    std::copy_n(f.begin(), n_u, values);
    std::copy_n(g.begin(), n_p, values + n_u);
    // Held at zero: the row says so.
    if (n_p > 0 && constraints.is_constrained(owned.nth_index_in_set(n_u)))
      values[n_u] = 0;
    check(VecRestoreArray(right_hand_side, &values), "a solve");
    check(KSPSolve(solver, right_hand_side, solution), "a solve");
    const PetscScalar *result;
    check(VecGetArrayRead(solution, &result), "a solve");
    u.zero_out_ghost_values();
    p.zero_out_ghost_values();
    std::copy_n(result, n_u, u.begin());
    std::copy_n(result + n_u, n_p, p.begin());
    check(VecRestoreArrayRead(solution, &result), "a solve");
  }


  template class DirectSolver<2>;
  template class DirectSolver<3>;
} // namespace feib
