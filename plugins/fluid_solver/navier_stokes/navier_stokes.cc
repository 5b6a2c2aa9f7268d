// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cell_operators.h"
#include "direct_solver.h"
#include "navier_stokes_schema.h"

#include <feib/expression.h>
#include <feib/fluid_solver.h>
#include <feib/log.h>
#include <feib/plugin.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/la_parallel_block_vector.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>

#include <cmath>

namespace feib
{
  namespace
  {
    enum class Convection
    {
      none,
      explicit_extrapolation,
      implicit
    };

    using BlockVector = dealii::LinearAlgebra::distributed::BlockVector<double>;
  } // namespace


  /// Backward Euler steps of the incompressible Navier-Stokes equations, see the README.
  ///
  /// Every step is a residual and its correction: with the boundary values set in the first guess,
  /// the correction obeys homogeneous constraints, and one loop serves the linear step (one
  /// correction by the factorisation), Newton's method and an added operator (corrections by
  /// FGMRES, preconditioned by the factorisation).
  template <int dim>
  class NavierStokes : public FluidSolver<dim>
  {
  public:
    using Base    = FluidSolver<dim>;
    using Step    = typename Base::Step;
    using Report  = typename Base::Report;
    using Balance = typename Base::Balance;
    using Space   = EulerianSpace<dim>;

    explicit NavierStokes(const Parameters &parameters);

    void initialize(Space &space) override;

    Report advance(Space &space, const Step &step) override;

    Balance balance(const Space &space) const override;

  private:
    static constexpr unsigned int n   = CellOperators<dim>::n;
    static constexpr unsigned int n_u = CellOperators<dim>::n_u;
    static constexpr unsigned int n_p = CellOperators<dim>::n_p;

    /// Dense matrices of a cell; all cells of a level have the same size.
    struct LevelMatrices
    {
      std::vector<double> velocity;   // alpha M + mu K
      std::vector<double> mass;       // rho M
      std::vector<double> divergence; // (div u, q)
    };

    struct Norms
    {
      double momentum = 0, divergence = 0, divergence_scale = 0;
    };

    std::vector<LevelMatrices> level_matrices(const Space &space, double alpha) const;

    void prepare(const Space &space, double dt);

    void find_outflow_faces(const Space &space);

    void factorize_stokes(const Space &space);

    void factorize_oseen(const Space &space, const VelocityVector &w);

    VelocityVector body_force_vector(const Space &space, double time) const;

    VelocityVector extrapolated_velocity(const Space &space, double dt) const;

    void add_convection(const Space &space,
                        const VelocityVector &w,
                        const VelocityVector &u,
                        double factor,
                        VelocityVector &result) const;

    /// r = forces - A u + B^T p, g = B u over all unknowns, not condensed.
    void apply_stokes(const Space &space,
                      const VelocityVector &u,
                      const PressureVector &p,
                      VelocityVector &r,
                      PressureVector &g) const;

    Norms norms(const Space &space, const VelocityVector &r, const PressureVector &g) const;

    void remove_mean_pressure(Space &space) const;

    unsigned int correct(const Space &space,
                         const Step &step,
                         const VelocityVector &u,
                         const VelocityVector &r,
                         const PressureVector &g,
                         VelocityVector &du,
                         PressureVector &dp);

    // What the case says.
    const double rho, mu, tolerance;
    const unsigned int max_iterations;
    const bool symmetric, skew;
    Convection convection;
    std::unique_ptr<dealii::Function<dim>> body_force, initial_velocity;
    bool body_force_varies = false;

    // What is kept from step to step.
    const CellOperators<dim> operators;
    unsigned int revision = 0;
    double factor_dt      = 0;
    std::vector<LevelMatrices> levels;
    std::vector<unsigned int> outflow_faces; // per cell, bit f for face f
    DirectSolver<dim> direct;
    VelocityVector body_force_load;
    double boundary_power = 0;
  };


  template <int dim>
  NavierStokes<dim>::NavierStokes(const Parameters &parameters)
    : rho(parameters.number("density"))
    , mu(parameters.number("viscosity"))
    , tolerance(parameters.number("tolerance"))
    , max_iterations(parameters.integer("max_iterations"))
    , symmetric(parameters.string("viscous_form") == "symmetric")
    , skew(parameters.string("convective_form") == "skew_symmetric")
  {
    const std::string name = parameters.string("convection");
    convection             = name == "none"       ? Convection::none
                             : name == "explicit" ? Convection::explicit_extrapolation
                                                  : Convection::implicit;
    if (parameters.has("body_force"))
      {
        body_force = parse_expressions<dim>(parameters, "body_force", dim, Variables::space_time);
        body_force_varies = depends_on_time(parameters, "body_force");
      }
    if (parameters.has("initial_velocity"))
      initial_velocity =
        parse_expressions<dim>(parameters, "initial_velocity", dim, Variables::space_time);
  }


  template <int dim>
  void
  NavierStokes<dim>::initialize(Space &space)
  {
    space.set_time(0.);
    space.velocity = 0.;
    if (initial_velocity)
      {
        space.velocity.zero_out_ghost_values();
        const unsigned int n_owned = space.velocity.locally_owned_size();
        dealii::Vector<double> value(dim);
        for (unsigned int c = 0; c < space.cells().size(); ++c)
          for (unsigned int i = 0; i < n; ++i)
            {
              // Nodes are lexicographic at 0, 1/2 and 1 in each direction.
              dealii::Point<dim> x = space.cells()[c].lower;
              unsigned int rest    = i;
              for (unsigned int a = 0; a < dim; ++a, rest /= 3)
                x[a] += space.cells()[c].size[a] * (rest % 3) / 2.;
              initial_velocity->vector_value(x, value);
              for (unsigned int a = 0; a < dim; ++a)
                if (const unsigned int dof = space.velocity_dofs(c)[a * n + i]; dof < n_owned)
                  space.velocity.local_element(dof) = value[a];
            }
      }
    space.distribute(space.velocity, false);
    space.pressure = 0.;
    space.pressure.update_ghost_values();
  }


  template <int dim>
  std::vector<typename NavierStokes<dim>::LevelMatrices>
  NavierStokes<dim>::level_matrices(const Space &space, const double alpha) const
  {
    std::vector<LevelMatrices> result;
    for (const auto &cell : space.cells())
      {
        if (cell.level >= result.size())
          result.resize(cell.level + 1);
        LevelMatrices &matrices = result[cell.level];
        if (matrices.velocity.empty())
          {
            matrices.velocity   = operators.velocity_matrix(cell.size, alpha, mu, symmetric);
            matrices.mass       = operators.velocity_matrix(cell.size, rho, 0., symmetric);
            matrices.divergence = operators.divergence_matrix(cell.size);
          }
      }
    return result;
  }


  template <int dim>
  void
  NavierStokes<dim>::prepare(const Space &space, const double dt)
  {
    // The last step of a run may differ from the others by round-off only.
    const bool same_dt = std::abs(dt - factor_dt) <= 1e-10 * dt;
    if (revision == space.revision() && same_dt)
      return;
    levels = level_matrices(space, rho / dt);
    if (revision != space.revision() && body_force && !body_force_varies)
      body_force_load = body_force_vector(space, 0.);
    if (revision != space.revision())
      find_outflow_faces(space);
    revision  = space.revision();
    factor_dt = dt;
    factorize_stokes(space);
  }


  template <int dim>
  void
  NavierStokes<dim>::find_outflow_faces(const Space &space)
  {
    const Domain<dim> &box = space.domain();
    outflow_faces.assign(space.cells().size(), 0);
    for (unsigned int f = 0; f < 2 * dim; ++f)
      if (box.faces[f].condition == BoundaryCondition::outflow)
        for (unsigned int c = 0; c < space.cells().size(); ++c)
          {
            const auto &cell      = space.cells()[c];
            const double distance = f % 2 == 0
                                      ? cell.lower[f / 2] - box.lower[f / 2]
                                      : box.upper[f / 2] - cell.lower[f / 2] - cell.size[f / 2];
            if (std::abs(distance) < .5 * cell.size[f / 2])
              outflow_faces[c] |= 1U << f;
          }
  }


  template <int dim>
  void
  NavierStokes<dim>::factorize_stokes(const Space &space)
  {
    direct.factorize(
      space,
      [&](const unsigned int c, dealii::FullMatrix<double> &matrix) {
        const LevelMatrices &local = levels[space.cells()[c].level];
        for (unsigned int i = 0; i < n_u; ++i)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(i, j) = local.velocity[i * n_u + j];
        for (unsigned int k = 0; k < n_p; ++k)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(n_u + k, j) = matrix(j, n_u + k) = -local.divergence[k * n_u + j];
      },
      true);
  }


  template <int dim>
  void
  NavierStokes<dim>::factorize_oseen(const Space &space, const VelocityVector &w)
  {
    direct.factorize(
      space,
      [&](const unsigned int c, dealii::FullMatrix<double> &matrix) {
        const auto &cell           = space.cells()[c];
        const LevelMatrices &local = levels[cell.level];
        double local_w[n_u];
        for (unsigned int i = 0; i < n_u; ++i)
          local_w[i] = w.local_element(space.velocity_dofs(c)[i]);
        const std::vector<double> convective =
          operators.convection_matrix(cell.size, local_w, rho, skew, outflow_faces[c]);
        for (unsigned int i = 0; i < n_u; ++i)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(i, j) =
              local.velocity[i * n_u + j] + (i / n == j / n ? convective[(i % n) * n + j % n] : 0.);
        for (unsigned int k = 0; k < n_p; ++k)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(n_u + k, j) = matrix(j, n_u + k) = -local.divergence[k * n_u + j];
      },
      false);
  }


  template <int dim>
  VelocityVector
  NavierStokes<dim>::body_force_vector(const Space &space, const double time) const
  {
    VelocityVector result = space.make_velocity();
    body_force->set_time(time);
    std::vector<dealii::Point<dim>> points(operators.points.size());
    std::vector<dealii::Vector<double>> values(points.size(), dealii::Vector<double>(dim));
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const auto &cell = space.cells()[c];
        double det       = 1;
        for (unsigned int a = 0; a < dim; ++a)
          det *= cell.size[a];
        for (unsigned int q = 0; q < points.size(); ++q)
          for (unsigned int a = 0; a < dim; ++a)
            points[q][a] = cell.lower[a] + cell.size[a] * operators.points[q][a];
        body_force->vector_value_list(points, values);
        const unsigned int *dofs = space.velocity_dofs(c);
        for (unsigned int q = 0; q < points.size(); ++q)
          for (unsigned int a = 0; a < dim; ++a)
            for (unsigned int i = 0; i < n; ++i)
              result.local_element(dofs[a * n + i]) +=
                det * operators.weights[q] * values[q][a] * operators.phi[q][i];
      }
    result.compress(dealii::VectorOperation::add);
    return result;
  }


  template <int dim>
  VelocityVector
  NavierStokes<dim>::extrapolated_velocity(const Space &space, const double dt) const
  {
    VelocityVector result = space.make_velocity();
    const double ratio    = space.old_dt > 0 ? dt / space.old_dt : 0.;
    result.equ(1. + ratio, space.old_velocity);
    if (ratio > 0)
      result.add(-ratio, space.older_velocity);
    result.update_ghost_values();
    return result;
  }


  template <int dim>
  void
  NavierStokes<dim>::add_convection(const Space &space,
                                    const VelocityVector &w,
                                    const VelocityVector &u,
                                    const double factor,
                                    VelocityVector &result) const
  {
    double local_w[n_u], local_u[n_u], local[n_u];
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const unsigned int *dofs = space.velocity_dofs(c);
        for (unsigned int i = 0; i < n_u; ++i)
          {
            local_w[i] = w.local_element(dofs[i]);
            local_u[i] = u.local_element(dofs[i]);
            local[i]   = 0;
          }
        operators.add_convection(
          space.cells()[c].size, local_w, local_u, factor * rho, skew, local, outflow_faces[c]);
        for (unsigned int i = 0; i < n_u; ++i)
          result.local_element(dofs[i]) += local[i];
      }
  }


  template <int dim>
  void
  NavierStokes<dim>::apply_stokes(const Space &space,
                                  const VelocityVector &u,
                                  const PressureVector &p,
                                  VelocityVector &r,
                                  PressureVector &g) const
  {
    double local_u[n_u], local_p[n_p];
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const LevelMatrices &local        = levels[space.cells()[c].level];
        const unsigned int *dofs          = space.velocity_dofs(c);
        const unsigned int *pressure_dofs = space.pressure_dofs(c);
        for (unsigned int i = 0; i < n_u; ++i)
          local_u[i] = u.local_element(dofs[i]);
        for (unsigned int k = 0; k < n_p; ++k)
          local_p[k] = p.local_element(pressure_dofs[k]);
        for (unsigned int i = 0; i < n_u; ++i)
          {
            const double *row = &local.velocity[i * n_u];
            double sum        = 0;
            for (unsigned int j = 0; j < n_u; ++j)
              sum -= row[j] * local_u[j];
            for (unsigned int k = 0; k < n_p; ++k)
              sum += local.divergence[k * n_u + i] * local_p[k];
            r.local_element(dofs[i]) += sum;
          }
        for (unsigned int k = 0; k < n_p; ++k)
          {
            const double *row = &local.divergence[k * n_u];
            double sum        = 0;
            for (unsigned int j = 0; j < n_u; ++j)
              sum += row[j] * local_u[j];
            g.local_element(pressure_dofs[k]) += sum;
          }
      }
  }


  template <int dim>
  typename NavierStokes<dim>::Norms
  NavierStokes<dim>::norms(const Space &space,
                           const VelocityVector &r,
                           const PressureVector &g) const
  {
    // The scale of the divergence: the largest flux through a cell, of the state of the space.
    double scale = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        double det       = 1;
        const auto &size = space.cells()[c].size;
        double sum       = 0;
        for (unsigned int a = 0; a < dim; ++a)
          {
            det *= size[a];
            double largest = 0;
            for (unsigned int i = 0; i < n; ++i)
              largest =
                std::max(largest,
                         std::abs(space.velocity.local_element(space.velocity_dofs(c)[a * n + i])));
            sum += largest / size[a];
          }
        scale += det * det * sum * sum;
      }
    Norms result;
    result.momentum         = r.l2_norm();
    result.divergence       = g.l2_norm();
    result.divergence_scale = std::sqrt(dealii::Utilities::MPI::sum(scale, space.communicator()));
    return result;
  }


  template <int dim>
  unsigned int
  NavierStokes<dim>::correct(const Space &space,
                             const Step &step,
                             const VelocityVector &u,
                             const VelocityVector &r,
                             const PressureVector &g,
                             VelocityVector &du,
                             PressureVector &dp)
  {
    if (convection != Convection::implicit && !step.added)
      {
        direct.solve(r, g, du, dp);
        return 1;
      }

    struct Jacobian
    {
      const NavierStokes &solver;
      const Space &space;
      const Step &step;
      const VelocityVector &u;

      void
      vmult(BlockVector &dst, const BlockVector &src) const
      {
        VelocityVector v = space.make_velocity();
        PressureVector p = space.make_pressure();
        v.copy_locally_owned_data_from(src.block(0));
        p.copy_locally_owned_data_from(src.block(1));
        space.distribute(v, true);
        VelocityVector result          = space.make_velocity();
        PressureVector result_pressure = space.make_pressure();
        solver.apply_stokes(space, v, p, result, result_pressure);
        if (solver.convection == Convection::implicit)
          {
            solver.add_convection(space, v, u, -1., result);
            solver.add_convection(space, u, v, -1., result);
          }
        result.compress(dealii::VectorOperation::add);
        result_pressure.compress(dealii::VectorOperation::add);
        result *= -1.;
        if (step.added)
          step.added(result, v);
        space.condense(result);
        dst.block(0).copy_locally_owned_data_from(result);
        dst.block(1).equ(-1., result_pressure);
      }
    };

    struct Preconditioner
    {
      DirectSolver<dim> &direct;
      void
      vmult(BlockVector &dst, const BlockVector &src) const
      {
        direct.solve(src.block(0), src.block(1), dst.block(0), dst.block(1));
      }
    };

    // Inexact Newton: each correction to a part of its residual; past this many iterations the
    // factorisation is too old, or lacks the convection.
    constexpr unsigned int stalled = 30;
    constexpr double reduction     = 1e-4;

    BlockVector right_hand_side(2), solution(2);
    right_hand_side.block(0).reinit(r, true);
    right_hand_side.block(1).reinit(g, true);
    right_hand_side.collect_sizes();
    right_hand_side.block(0).copy_locally_owned_data_from(r);
    right_hand_side.block(1).copy_locally_owned_data_from(g);
    solution.reinit(right_hand_side);

    const Jacobian jacobian{*this, space, step, u};
    const Preconditioner preconditioner{direct};
    unsigned int iterations = 0;
    for (const bool last_try : {false, true})
      {
        dealii::SolverControl control(last_try ? 10 * stalled : stalled,
                                      reduction * right_hand_side.l2_norm(),
                                      false,
                                      false);
        dealii::SolverFGMRES<BlockVector> fgmres(
          control, typename dealii::SolverFGMRES<BlockVector>::AdditionalData(stalled));
        try
          {
            fgmres.solve(jacobian, solution, right_hand_side, preconditioner);
            iterations += control.last_step();
            break;
          }
        catch (const dealii::SolverControl::NoConvergence &failure)
          {
            iterations += failure.last_step;
            if (last_try)
              throw RunFailure("the linear solver stopped after " + std::to_string(iterations) +
                               " iterations at residual " + std::to_string(failure.last_residual));
            if (convection == Convection::implicit)
              {
                log::debug("factorising the fluid matrix anew, with convection");
                factorize_oseen(space, u);
              }
            solution = 0.;
          }
      }
    du.copy_locally_owned_data_from(solution.block(0));
    dp.copy_locally_owned_data_from(solution.block(1));
    return iterations;
  }


  template <int dim>
  void
  NavierStokes<dim>::remove_mean_pressure(Space &space) const
  {
    double integral = 0, volume = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        double det = 1;
        for (unsigned int a = 0; a < dim; ++a)
          det *= space.cells()[c].size[a];
        // The other basis functions have no mean.
        integral += det * space.pressure.local_element(space.pressure_dofs(c)[0]);
        volume += det;
      }
    const double mean = dealii::Utilities::MPI::sum(integral, space.communicator()) /
                        dealii::Utilities::MPI::sum(volume, space.communicator());
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      space.pressure.local_element(space.pressure_dofs(c)[0]) -= mean;
  }


  template <int dim>
  typename NavierStokes<dim>::Report
  NavierStokes<dim>::advance(Space &space, const Step &step)
  {
    prepare(space, step.dt);
    space.set_time(step.time);
    space.distribute(space.velocity, false);

    // Everything that does not depend on the unknowns: load, inertia of u^n, body force and the
    // extrapolated convection.
    VelocityVector fixed = space.make_velocity();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const std::vector<double> &mass = levels[space.cells()[c].level].mass;
        const unsigned int *dofs        = space.velocity_dofs(c);
        double local[n];
        for (unsigned int a = 0; a < dim; ++a)
          {
            for (unsigned int j = 0; j < n; ++j)
              local[j] = space.old_velocity.local_element(dofs[a * n + j]) / step.dt;
            for (unsigned int i = 0; i < n; ++i)
              {
                double sum = 0;
                for (unsigned int j = 0; j < n; ++j)
                  sum += mass[i * n_u + j] * local[j];
                fixed.local_element(dofs[a * n + i]) += sum;
              }
          }
      }
    if (convection == Convection::explicit_extrapolation)
      {
        const VelocityVector w = extrapolated_velocity(space, step.dt);
        add_convection(space, w, w, -1., fixed);
      }
    fixed.compress(dealii::VectorOperation::add);
    fixed += step.load;
    if (body_force)
      {
        if (body_force_varies)
          body_force_load = body_force_vector(space, step.time);
        fixed += body_force_load;
      }
    VelocityVector condensed = fixed;
    space.condense(condensed);

    Report report;
    double scale        = condensed.l2_norm();
    const bool enclosed = space.domain().enclosed();
    const bool driven   = [&] {
      for (const auto &face : space.domain().faces)
        if (face.condition == BoundaryCondition::velocity)
          return true;
      return false;
    }();
    std::string history;
    while (true)
      {
        VelocityVector r = space.make_velocity();
        PressureVector g = space.make_pressure();
        apply_stokes(space, space.velocity, space.pressure, r, g);
        if (convection == Convection::implicit)
          add_convection(space, space.velocity, space.velocity, -1., r);
        r.compress(dealii::VectorOperation::add);
        g.compress(dealii::VectorOperation::add);
        r += fixed;
        if (step.added)
          {
            VelocityVector added = space.make_velocity();
            step.added(added, space.velocity);
            r -= added;
          }
        // Where the velocity is prescribed, what is left over is the reaction; elsewhere nothing
        // is.
        VelocityVector reaction = r;
        space.condense(r);

        const Norms size = norms(space, r, g);
        if (!std::isfinite(size.momentum) || !std::isfinite(size.divergence))
          throw RunFailure("the fluid's residual is not finite at time " +
                           std::to_string(step.time));
        if (report.nonlinear_iterations == 0)
          {
            scale = std::max(scale, size.momentum);
            if (enclosed && driven)
              {
                double flux = 0;
                for (unsigned int c = 0; c < space.cells().size(); ++c)
                  flux += g.local_element(space.pressure_dofs(c)[0]);
                flux = dealii::Utilities::MPI::sum(flux, space.communicator());
                if (std::abs(flux) > 1e-8 * size.divergence_scale)
                  throw RunFailure(
                    "the prescribed boundary velocities, as interpolated on this mesh, carry a "
                    "net flux of " +
                    std::to_string(flux) +
                    " out of the box, which is closed: give a face the condition outflow");
              }
          }
        history += (history.empty() ? "" : ", ") + std::to_string(size.momentum / scale);

        // The divergence is a linear equation: any correction solves it as far as round-off allows.
        const bool first = report.nonlinear_iterations == 0;
        if (!first && size.momentum <= tolerance * scale &&
            size.divergence <= tolerance * size.divergence_scale)
          {
            boundary_power = driven ? -(reaction * space.velocity) : 0.;
            break;
          }
        if (first && scale == 0. && size.divergence == 0.)
          {
            boundary_power = 0;
            break;
          }
        if (report.nonlinear_iterations >= max_iterations)
          throw RunFailure("the fluid step to time " + std::to_string(step.time) +
                           " did not reach its tolerance in " + std::to_string(max_iterations) +
                           " iterations; relative residuals: " + history);

        VelocityVector du = space.make_velocity();
        PressureVector dp = space.make_pressure();
        report.linear_iterations += correct(space, step, space.velocity, r, g, du, dp);
        ++report.nonlinear_iterations;
        space.distribute(du, true);
        dp.update_ghost_values();
        space.velocity.zero_out_ghost_values();
        space.pressure.zero_out_ghost_values();
        space.velocity += du;
        space.pressure += dp;
        if (enclosed)
          remove_mean_pressure(space);
        space.distribute(space.velocity, false);
        space.pressure.update_ghost_values();
      }
    return report;
  }


  template <int dim>
  typename NavierStokes<dim>::Balance
  NavierStokes<dim>::balance(const Space &space) const
  {
    struct Forms
    {
      std::vector<double> mass, viscous;
    };
    std::vector<Forms> forms;
    Balance result;
    double u[n_u];
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const auto &cell = space.cells()[c];
        if (cell.level >= forms.size())
          forms.resize(cell.level + 1);
        Forms &local = forms[cell.level];
        if (local.mass.empty())
          {
            local.mass    = operators.velocity_matrix(cell.size, rho, 0., symmetric);
            local.viscous = operators.velocity_matrix(cell.size, 0., mu, symmetric);
          }
        for (unsigned int i = 0; i < n_u; ++i)
          u[i] = space.velocity.local_element(space.velocity_dofs(c)[i]);
        const auto quadratic = [&u](const std::vector<double> &matrix) {
          double sum = 0;
          for (unsigned int i = 0; i < n_u; ++i)
            {
              double row = 0;
              for (unsigned int j = 0; j < n_u; ++j)
                row += matrix[i * n_u + j] * u[j];
              sum += u[i] * row;
            }
          return sum;
        };
        result.kinetic_energy += .5 * quadratic(local.mass);
        result.dissipation += quadratic(local.viscous);

        double det = 1;
        for (unsigned int a = 0; a < dim; ++a)
          det *= cell.size[a];
        for (unsigned int q = 0; q < CellOperators<dim>::n_q; ++q)
          {
            double divergence = 0;
            for (unsigned int a = 0; a < dim; ++a)
              {
                double derivative = 0;
                for (unsigned int i = 0; i < n; ++i)
                  derivative += operators.dphi[a][q][i] * u[a * n + i];
                divergence += derivative / cell.size[a];
              }
            result.divergence += det * operators.weights[q] * divergence * divergence;
          }
        double mean[dim] = {}, moment[dim][dim] = {}; // int u_a, int x_b u_a
        for (unsigned int a = 0; a < dim; ++a)
          {
            for (unsigned int i = 0; i < n; ++i)
              {
                mean[a] += det * operators.mean[i] * u[a * n + i];
                for (unsigned int b = 0; b < dim; ++b)
                  moment[a][b] +=
                    det *
                    (cell.lower[b] * operators.mean[i] + cell.size[b] * operators.moment[b][i]) *
                    u[a * n + i];
              }
            result.momentum[a] += rho * mean[a];
          }
        result.angular_momentum[2] += rho * (moment[1][0] - moment[0][1]);
        if constexpr (dim == 3)
          {
            result.angular_momentum[0] += rho * (moment[2][1] - moment[1][2]);
            result.angular_momentum[1] += rho * (moment[0][2] - moment[2][0]);
          }
        for (unsigned int i = 0; i < n; ++i)
          {
            double square = 0, rate = 0;
            for (unsigned int a = 0; a < dim; ++a)
              {
                square += u[a * n + i] * u[a * n + i];
                rate += std::abs(u[a * n + i]) / cell.size[a];
              }
            result.largest_velocity = std::max(result.largest_velocity, square);
            result.cfl_rate         = std::max(result.cfl_rate, rate);
          }
      }
    const MPI_Comm communicator = space.communicator();
    result.kinetic_energy       = dealii::Utilities::MPI::sum(result.kinetic_energy, communicator);
    result.dissipation          = dealii::Utilities::MPI::sum(result.dissipation, communicator);
    result.divergence = std::sqrt(dealii::Utilities::MPI::sum(result.divergence, communicator));
    result.momentum   = dealii::Utilities::MPI::sum(result.momentum, communicator);
    result.angular_momentum = dealii::Utilities::MPI::sum(result.angular_momentum, communicator);
    result.largest_velocity =
      std::sqrt(dealii::Utilities::MPI::max(result.largest_velocity, communicator));
    result.cfl_rate       = dealii::Utilities::MPI::max(result.cfl_rate, communicator);
    result.boundary_power = boundary_power;
    if (body_force && body_force_load.size() == space.velocity.size())
      result.body_force_power = body_force_load * space.velocity;
    return result;
  }
} // namespace feib


FEIB_PLUGIN("navier_stokes", "1.0", registry)
{
  registry.add<feib::FluidSolver, feib::NavierStokes>("navier_stokes", navier_stokes_schema);
}
