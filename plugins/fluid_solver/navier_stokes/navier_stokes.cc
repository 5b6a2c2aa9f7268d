// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cell_operators.h"
#include "direct_solver.h"
#include "fluid_integrals.h"
#include "navier_stokes_schema.h"

#include <feib/error.h>
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
#include <iomanip>
#include <optional>
#include <sstream>

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

    /// What is tested with R v instead of v.
    enum class Reconstructed
    {
      none,
      body_force,
      all
    };

    Convection
    convection_of(const std::string &name)
    {
      return name == "none"       ? Convection::none
             : name == "explicit" ? Convection::explicit_extrapolation
                                  : Convection::implicit;
    }

    ConvectiveForm
    convective_form_of(const std::string &name)
    {
      return name == "skew_symmetric" ? ConvectiveForm::skew_symmetric
             : name == "convective"   ? ConvectiveForm::convective
                                      : ConvectiveForm::rotational;
    }

    Reconstructed
    reconstructed_of(const std::string &name)
    {
      return name == "none"         ? Reconstructed::none
             : name == "body_force" ? Reconstructed::body_force
                                    : Reconstructed::all;
    }

    using BlockVector = dealii::LinearAlgebra::distributed::BlockVector<double>;
  } // namespace


  /// Backward Euler steps of the incompressible Navier-Stokes equations, see the README.
  ///
  /// Every step is a residual and its correction: with the boundary values set in the first guess,
  /// the correction obeys homogeneous constraints, and one loop serves the linear step (one
  /// correction by the factorisation), Newton's method and an implicit load (corrections by
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

    double
    density() const override
    {
      return rho;
    }

    double
    viscosity() const override
    {
      return mu;
    }

    Balance
    balance(const Space &space) const override
    {
      return fluid_balance(space, operators, rho);
    }

  private:
    static constexpr unsigned int n   = CellOperators<dim>::n;
    static constexpr unsigned int n_u = CellOperators<dim>::n_u;
    static constexpr unsigned int n_p = CellOperators<dim>::n_p;

    /// Dense matrices of a cell; all cells of a level have the same size.
    struct LevelMatrices
    {
      std::vector<double> velocity;   // alpha M + mu K + gamma D
      std::vector<double> mass;       // rho M
      std::vector<double> viscous;    // mu K + gamma D
      std::vector<double> divergence; // (div u, q)
    };

    struct Norms
    {
      double momentum = 0, divergence = 0, divergence_scale = 0;
    };

    /// What is left of the equations at a velocity and a pressure.
    struct Residual
    {
      VelocityVector momentum; // condensed
      VelocityVector reaction; // not condensed: the force of the walls where velocity is prescribed
      PressureVector divergence;
      Norms norms;
      double implicit_load = 0; // norm, condensed
    };

    std::vector<LevelMatrices> level_matrices(const Space &space, double alpha) const;

    /// The nearest velocity (in L2) that is discretely divergence-free.
    void project(Space &space);

    void prepare(const Space &space, double dt);

    void find_outflow_faces(const Space &space);

    void factorize(const Space &space, const VelocityVector *w, const ImplicitLoad<dim> *load);

    void
    assemble_body_force(const Space &space, const double time)
    {
      body_force->set_time(time);
      body_force_load =
        load_of_body_force(space, *body_force, reconstruction ? &*reconstruction : nullptr);
    }

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

    /// All that does not depend on the unknowns: load, inertia of u^n, body force and the
    /// extrapolated convection, which is also given alone.
    VelocityVector
    fixed_forces(const Space &space, const Step &step, VelocityVector &explicit_convection);

    Residual
    residual(const Space &space, const Step &step, const VelocityVector &fixed_forces) const;

    /// Throws RunFailure when the box is closed and what goes in does not come out.
    void check_net_flux(const Space &space, const Residual &residual) const;

    unsigned int correct(const Space &space,
                         const Step &step,
                         const Residual &residual,
                         double reduction,
                         VelocityVector &du,
                         PressureVector &dp);

    /// Puts the powers of the step that led to the state of the space into the report.
    void account(const Space &space,
                 const Residual &residual,
                 const VelocityVector &explicit_convection,
                 Report &report) const;

    // What the case says.
    const double rho, mu, grad_div, tolerance;
    const unsigned int max_iterations;
    const bool symmetric;
    const ConvectiveForm convective_form;
    const Convection convection;
    const Reconstructed reconstructed;
    const std::string pointer;
    std::unique_ptr<dealii::Function<dim>> body_force, initial_velocity;
    bool body_force_varies = false;

    // What is kept from step to step.
    std::optional<Reconstruction<dim>> reconstruction;
    CellOperators<dim> operators; // with the reconstruction when all is tested with it
    unsigned int revision = 0;
    double factor_dt      = 0;
    std::vector<LevelMatrices> levels;
    std::vector<unsigned int> outflow_faces; // per cell, bit f for face f
    DirectSolver<dim> direct;
    bool factor_outdated        = true;
    bool factor_with_load       = false; // the implicit load is, or should be, in the factorisation
    bool factor_with_convection = false;
    unsigned int iterations     = 0; // beyond the few that a fresh factorisation takes, since then
    unsigned int uses           = 0; // corrections computed with the factorisation,
    unsigned int last_uses      = 0; // and with the one before
    VelocityVector body_force_load;
  };


  template <int dim>
  NavierStokes<dim>::NavierStokes(const Parameters &parameters)
    : rho(parameters.number("density"))
    , mu(parameters.number("viscosity"))
    , grad_div(parameters.number("grad_div"))
    , tolerance(parameters.number("tolerance"))
    , max_iterations(parameters.integer("max_iterations"))
    , symmetric(parameters.string("viscous_form") == "symmetric")
    , convective_form(convective_form_of(parameters.string("convective_form")))
    , convection(convection_of(parameters.string("convection")))
    , reconstructed(reconstructed_of(parameters.string("reconstruction")))
    , pointer(parameters.pointer())
  {
    if (reconstructed == Reconstructed::all && convection != Convection::none &&
        convective_form == ConvectiveForm::skew_symmetric)
      parameters.fail("reconstruction",
                      "\"all\" tests convection with the reconstruction, which has no "
                      "skew-symmetric form: set convective_form to \"convective\" or "
                      "\"rotational\", or convection to \"none\"");
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
    const Domain<dim> &box = space.domain();
    if (convection != Convection::none && convective_form == ConvectiveForm::rotational)
      for (const auto &face : box.faces)
        if (face.condition == BoundaryCondition::outflow)
          throw Error(pointer + "/convective_form",
                      "\"rotational\" cannot be used with a face of condition outflow, where it "
                      "would set the total pressure p + rho |u|^2/2 to zero: use "
                      "\"skew_symmetric\" or \"convective\"");
    if (reconstructed != Reconstructed::none)
      {
        dealii::Tensor<1, dim> size;
        for (unsigned int a = 0; a < dim; ++a)
          size[a] = (box.upper[a] - box.lower[a]) / box.cells[a];
        reconstruction.emplace(size); // the same for the cells of all levels
        if (reconstructed == Reconstructed::all)
          operators = CellOperators<dim>(&*reconstruction);
      }
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
    // Boundary values alone are not divergence-free either.
    if (space.velocity.linfty_norm() > 0)
      project(space);
  }


  template <int dim>
  void
  NavierStokes<dim>::project(Space &space)
  {
    // Without the reconstruction, as |R v| is no norm: on uniform meshes some v has R v = 0.
    const CellOperators<dim> plain;
    levels           = level_matrices(space, rho);
    VelocityVector r = space.make_velocity(), du = space.make_velocity();
    PressureVector g = space.make_pressure(), multiplier = space.make_pressure();
    apply_stokes(space, space.velocity, space.pressure, r, g);
    g.compress(dealii::VectorOperation::add);
    r.zero_out_ghost_values();
    r = 0.;
    direct.factorize(
      space,
      [&](const unsigned int c, dealii::FullMatrix<double> &matrix) {
        const LevelMatrices &local = levels[space.cells()[c].level];
        const std::vector<double> mass =
          plain.velocity_matrix(space.cells()[c].size, rho, 0., symmetric);
        for (unsigned int i = 0; i < n_u; ++i)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(i, j) = mass[i * n_u + j];
        for (unsigned int k = 0; k < n_p; ++k)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(n_u + k, j) = matrix(j, n_u + k) = -local.divergence[k * n_u + j];
      },
      true);
    revision = 0; // neither the matrices nor the factorisation are those of a step
    direct.solve(r, g, du, multiplier);
    space.distribute(du, true);
    space.velocity.zero_out_ghost_values();
    space.velocity += du;
    space.distribute(space.velocity, false);
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
            matrices.velocity =
              operators.velocity_matrix(cell.size, alpha, mu, symmetric, grad_div);
            matrices.mass       = operators.velocity_matrix(cell.size, rho, 0., symmetric);
            matrices.viscous    = operators.velocity_matrix(cell.size, 0., mu, symmetric, grad_div);
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
      assemble_body_force(space, 0.);
    if (revision != space.revision())
      find_outflow_faces(space);
    revision               = space.revision();
    factor_dt              = dt;
    factor_outdated        = true;
    factor_with_convection = false;
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
  NavierStokes<dim>::factorize(const Space &space,
                               const VelocityVector *w,
                               const ImplicitLoad<dim> *load)
  {
    direct.factorize(
      space,
      [&](const unsigned int c, dealii::FullMatrix<double> &matrix) {
        const auto &cell           = space.cells()[c];
        const LevelMatrices &local = levels[cell.level];
        for (unsigned int i = 0; i < n_u; ++i)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(i, j) = local.velocity[i * n_u + j];
        if (w)
          {
            double local_w[n_u];
            for (unsigned int i = 0; i < n_u; ++i)
              local_w[i] = w->local_element(space.velocity_dofs(c)[i]);
            const std::vector<double> convective = operators.convection_matrix(
              cell.size, local_w, rho, convective_form, outflow_faces[c]);
            for (unsigned int i = 0; i < n_u; ++i)
              for (unsigned int j = 0; j < n_u; ++j)
                matrix(i, j) += convective[i * n_u + j];
          }
        for (unsigned int k = 0; k < n_p; ++k)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(n_u + k, j) = matrix(j, n_u + k) = -local.divergence[k * n_u + j];
      },
      w == nullptr,
      load ? load->matrix() : std::vector<typename ImplicitLoad<dim>::Product>());
    factor_outdated        = false;
    factor_with_convection = w != nullptr;
    iterations             = 0;
    last_uses              = uses;
    uses                   = 0;
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
        operators.add_convection(space.cells()[c].size,
                                 local_w,
                                 local_u,
                                 factor * rho,
                                 convective_form,
                                 local,
                                 outflow_faces[c]);
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
                             const Residual &residual,
                             const double reduction,
                             VelocityVector &du,
                             PressureVector &dp)
  {
    // Rent or buy: a factorisation costs about as much as this many solutions with it. Once so many
    // were spent on the lack of the implicit load, or on the load of an old geometry, it pays.
    constexpr unsigned int price = 30;
    if (iterations > price)
      factor_outdated = factor_with_load = true;
    if (factor_outdated)
      factorize(space,
                factor_with_convection ? &space.velocity : nullptr,
                factor_with_load ? step.implicit_load : nullptr);
    if (convection != Convection::implicit && !step.implicit_load)
      {
        direct.solve(residual.momentum, residual.divergence, du, dp);
        return 1;
      }
    const VelocityVector &u = space.velocity;

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
        if (step.implicit_load)
          step.implicit_load->apply(result, v);
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

    // Past this many iterations the factorisation is too old, or lacks too much. One that served
    // no second step will hardly be followed by one that does.
    constexpr unsigned int usual = 3;
    const unsigned int stalled   = uses > 0 && last_uses == 1 ? 8 : 30;

    BlockVector right_hand_side(2), solution(2);
    right_hand_side.block(0).reinit(residual.momentum, true);
    right_hand_side.block(1).reinit(residual.divergence, true);
    right_hand_side.collect_sizes();
    right_hand_side.block(0).copy_locally_owned_data_from(residual.momentum);
    right_hand_side.block(1).copy_locally_owned_data_from(residual.divergence);
    solution.reinit(right_hand_side);

    const Jacobian jacobian{*this, space, step, u};
    const Preconditioner preconditioner{direct};
    unsigned int total = 0;
    for (const bool last_try : {false, true})
      {
        dealii::SolverControl control(last_try ? 10 * stalled : stalled,
                                      reduction * right_hand_side.l2_norm(),
                                      false,
                                      false);
        dealii::SolverFGMRES<BlockVector> fgmres(
          control,
          typename dealii::SolverFGMRES<BlockVector>::AdditionalData(last_try ? 100 : stalled));
        try
          {
            fgmres.solve(jacobian, solution, right_hand_side, preconditioner);
            total += control.last_step();
            if (step.implicit_load && control.last_step() > usual)
              iterations += control.last_step() - usual;
            break;
          }
        catch (const dealii::SolverControl::NoConvergence &failure)
          {
            total += failure.last_step;
            if (last_try)
              throw RunFailure("the linear solver stopped after " + std::to_string(total) +
                               " iterations at residual " + std::to_string(failure.last_residual));
            log::debug(
              "factorising the fluid matrix anew, with all there is; the last one served " +
              std::to_string(uses) + " solutions");
            factor_with_load = step.implicit_load != nullptr;
            factorize(space, convection == Convection::implicit ? &u : nullptr, step.implicit_load);
            solution = 0.;
          }
      }
    ++uses;
    du.copy_locally_owned_data_from(solution.block(0));
    dp.copy_locally_owned_data_from(solution.block(1));
    return total;
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
  VelocityVector
  NavierStokes<dim>::fixed_forces(const Space &space,
                                  const Step &step,
                                  VelocityVector &explicit_convection)
  {
    VelocityVector fixed = space.make_velocity();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const std::vector<double> &mass = levels[space.cells()[c].level].mass;
        const unsigned int *dofs        = space.velocity_dofs(c);
        double local[n_u];
        for (unsigned int j = 0; j < n_u; ++j)
          local[j] = space.old_velocity.local_element(dofs[j]) / step.dt;
        for (unsigned int i = 0; i < n_u; ++i)
          {
            double sum = 0;
            for (unsigned int j = 0; j < n_u; ++j)
              sum += mass[i * n_u + j] * local[j];
            fixed.local_element(dofs[i]) += sum;
          }
      }
    fixed.compress(dealii::VectorOperation::add);
    if (convection == Convection::explicit_extrapolation)
      {
        const VelocityVector w = extrapolated_velocity(space, step.dt);
        explicit_convection    = space.make_velocity();
        add_convection(space, w, w, 1., explicit_convection);
        explicit_convection.compress(dealii::VectorOperation::add);
        fixed -= explicit_convection;
      }
    fixed += step.load;
    if (body_force)
      {
        if (body_force_varies)
          assemble_body_force(space, step.time);
        fixed += body_force_load;
      }
    return fixed;
  }


  template <int dim>
  typename NavierStokes<dim>::Residual
  NavierStokes<dim>::residual(const Space &space,
                              const Step &step,
                              const VelocityVector &fixed_forces) const
  {
    Residual result;
    result.momentum   = space.make_velocity();
    result.divergence = space.make_pressure();
    apply_stokes(space, space.velocity, space.pressure, result.momentum, result.divergence);
    if (convection == Convection::implicit)
      add_convection(space, space.velocity, space.velocity, -1., result.momentum);
    result.momentum.compress(dealii::VectorOperation::add);
    result.divergence.compress(dealii::VectorOperation::add);
    result.momentum += fixed_forces;
    if (step.implicit_load)
      {
        VelocityVector load = space.make_velocity();
        step.implicit_load->evaluate(space.velocity, load);
        result.momentum += load;
        space.condense(load);
        result.implicit_load = load.l2_norm();
      }
    // Where the velocity is prescribed, what is left over is the reaction; elsewhere nothing is.
    result.reaction = result.momentum;
    space.condense(result.momentum);
    result.norms = norms(space, result.momentum, result.divergence);
    if (!std::isfinite(result.norms.momentum) || !std::isfinite(result.norms.divergence))
      throw RunFailure("the fluid's residual is not finite at time " + std::to_string(step.time));
    return result;
  }


  template <int dim>
  void
  NavierStokes<dim>::check_net_flux(const Space &space, const Residual &residual) const
  {
    double flux = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      flux += residual.divergence.local_element(space.pressure_dofs(c)[0]);
    flux = dealii::Utilities::MPI::sum(flux, space.communicator());
    if (space.domain().enclosed() && std::abs(flux) > 1e-8 * residual.norms.divergence_scale)
      throw RunFailure("the prescribed boundary velocities, as interpolated on this mesh, carry a "
                       "net flux of " +
                       std::to_string(flux) +
                       " out of the box, which is closed: give a face the condition outflow");
  }


  template <int dim>
  void
  NavierStokes<dim>::account(const Space &space,
                             const Residual &residual,
                             const VelocityVector &explicit_convection,
                             Report &report) const
  {
    double u[n_u], du[n_u], dissipation = 0, increment = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const LevelMatrices &local = levels[space.cells()[c].level];
        for (unsigned int i = 0; i < n_u; ++i)
          {
            u[i]  = space.velocity.local_element(space.velocity_dofs(c)[i]);
            du[i] = u[i] - space.old_velocity.local_element(space.velocity_dofs(c)[i]);
          }
        dissipation += CellOperators<dim>::quadratic_form(local.viscous, u);
        increment += .5 * CellOperators<dim>::quadratic_form(local.mass, du);
      }
    report.dissipation      = dealii::Utilities::MPI::sum(dissipation, space.communicator());
    report.increment_energy = dealii::Utilities::MPI::sum(increment, space.communicator());
    if (convection == Convection::explicit_extrapolation)
      report.convection_power = explicit_convection * space.velocity;
    else if (convection == Convection::implicit)
      {
        VelocityVector force = space.make_velocity();
        add_convection(space, space.velocity, space.velocity, 1., force);
        force.compress(dealii::VectorOperation::add);
        report.convection_power = force * space.velocity;
      }
    for (const auto &face : space.domain().faces)
      if (face.condition == BoundaryCondition::velocity)
        {
          report.boundary_power = -(residual.reaction * space.velocity);
          break;
        }
    if (body_force)
      report.body_force_power = body_force_load * space.velocity;
  }


  template <int dim>
  typename NavierStokes<dim>::Report
  NavierStokes<dim>::advance(Space &space, const Step &step)
  {
    prepare(space, step.dt);
    space.set_time(step.time);
    space.distribute(space.velocity, false);

    VelocityVector explicit_convection;
    const VelocityVector fixed = fixed_forces(space, step, explicit_convection);
    VelocityVector condensed   = fixed;
    space.condense(condensed);
    const bool linear =
      convection != Convection::implicit && (!step.implicit_load || step.implicit_load->linear());

    Report report;
    Residual present = residual(space, step, fixed);
    check_net_flux(space, present);
    const double scale =
      std::max({condensed.l2_norm(), present.implicit_load, present.norms.momentum});
    std::ostringstream history;
    history << std::setprecision(2);
    while (true)
      {
        const Norms &norms = present.norms;
        const bool first   = report.nonlinear_iterations == 0;
        history << (first ? "" : ", ") << norms.momentum / scale;
        if (norms.divergence_scale > 0)
          history << " (" << norms.divergence / norms.divergence_scale << ")";
        // The divergence is a linear equation: any correction solves it as far as round-off allows.
        if (first ? scale == 0. && norms.divergence == 0.
                  : norms.momentum <= tolerance * scale &&
                      norms.divergence <= tolerance * norms.divergence_scale)
          break;
        if (report.nonlinear_iterations >= max_iterations)
          throw RunFailure(
            "the fluid step to time " + std::to_string(step.time) +
            " did not reach its tolerance in " + std::to_string(max_iterations) +
            " iterations; relative residuals of momentum (and divergence): " + history.str());

        // A linear problem is solved at once; Newton's method converges quadratically while each
        // linear residual is the square of the nonlinear one.
        const double target = .3 * tolerance * scale / std::max(norms.momentum, tolerance * scale);
        const double reduction =
          std::max(target, linear ? 1e-13 : std::min(1e-4, norms.momentum / scale));
        VelocityVector du = space.make_velocity();
        PressureVector dp = space.make_pressure();
        report.linear_iterations += correct(space, step, present, reduction, du, dp);
        ++report.nonlinear_iterations;
        space.distribute(du, true);
        dp.update_ghost_values();

        // Where the load is not linear, the step is shortened until the load is defined and the
        // residual falls.
        const double before = norms.momentum;
        for (double length = 1, taken = 0;; length /= 2)
          {
            space.velocity.zero_out_ghost_values();
            space.pressure.zero_out_ghost_values();
            space.velocity.add(length - taken, du);
            space.pressure.add(length - taken, dp);
            taken = length;
            if (space.domain().enclosed())
              remove_mean_pressure(space);
            space.distribute(space.velocity, false);
            space.pressure.update_ghost_values();
            constexpr double shortest = 1. / 32;
            try
              {
                present = residual(space, step, fixed);
                if (linear || !step.implicit_load || length <= shortest ||
                    present.norms.momentum <=
                      std::max(tolerance * scale, (1 - .1 * length) * before))
                  break;
              }
            catch (const RunFailure &)
              {
                if (linear || length <= shortest)
                  throw;
              }
          }
      }
    account(space, present, explicit_convection, report);
    return report;
  }
} // namespace feib


FEIB_PLUGIN("navier_stokes", "1.0", registry)
{
  registry.add<feib::FluidSolver, feib::NavierStokes>("navier_stokes", navier_stokes_schema);
}
