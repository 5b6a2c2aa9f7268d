// SPDX-License-Identifier: LGPL-2.1-or-later
#include "stokes_solver.h"

#include "convective_blocks.h"

#include <feib/error.h>
#include <feib/log.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/la_parallel_block_vector.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>

#include <iomanip>
#include <sstream>

namespace feib
{
  namespace
  {
    using BlockVector = dealii::LinearAlgebra::distributed::BlockVector<double>;

    /// The matrix, with the second row times a weight.
    template <int dim>
    struct Jacobian
    {
      const StokesEquations<dim> &equations;
      double weight;

      void
      vmult(BlockVector &dst, const BlockVector &src) const
      {
        const EulerianSpace<dim> &space = equations.space;
        VelocityVector v                = space.make_velocity();
        v.copy_locally_owned_data_from(src.block(0));
        space.distribute(v, true);
        VelocityVector &result = dst.block(0);
        PressureVector &g      = dst.block(1);
        result                 = 0.;
        g                      = 0.;
        equations.operators.subtract_stokes(equations.rate, v, src.block(1), result, g);
        if (equations.velocity)
          equations.add_convection(-1., v, result);
        result.compress(dealii::VectorOperation::add);
        g.compress(dealii::VectorOperation::add);
        result *= -1.;
        if (equations.load)
          equations.load->apply(result, v);
        space.condense(result);
        g *= -weight;
      }
    };

    /// The inverse, or something like it.
    template <class Inverse>
    struct Preconditioner
    {
      Inverse &inverse;
      double weight;

      void
      vmult(BlockVector &dst, const BlockVector &src) const
      {
        PressureVector g = src.block(1);
        g /= weight;
        inverse.solve(src.block(0), g, dst.block(0), dst.block(1));
      }
    };

    std::string
    history(const std::vector<double> &residuals, const double initial)
    {
      std::ostringstream text;
      text << std::setprecision(2);
      const unsigned int stride = std::max<unsigned int>(1, residuals.size() / 12);
      for (unsigned int i = 0; i < residuals.size(); i += stride)
        text << (i > 0 ? ", " : "") << residuals[i] / initial;
      if ((residuals.size() - 1) % stride != 0)
        text << ", " << residuals.back() / initial;
      return text.str();
    }
  } // namespace


  template <int dim>
  typename StokesSolver<dim>::Method
  StokesSolver<dim>::choose(const Equations &equations) const
  {
    if (wanted != Method::automatic)
      return wanted;
    // Where the factorisation is cheap and is all there is to do, and where multigrid lacks what is
    // in the matrix.
    const auto n_cells              = equations.space.triangulation().n_global_active_cells();
    const unsigned int small        = equations.velocity ? 0 : dim == 2 ? 1100 : 64;
    constexpr unsigned int bearable = dim == 2 ? 20000 : 1000;
    constexpr double large_cfl      = 8;
    const auto &terms               = equations.operators.terms();
    const bool lacking =
      equations.load || terms.grad_div > 10 * terms.mu || equations.cfl > large_cfl;
    return n_cells <= (lacking ? bearable : small) ? Method::direct : Method::multigrid;
  }


  template <int dim>
  void
  StokesSolver<dim>::prepare(const Equations &equations)
  {
    const Method chosen = choose(equations);
    // With convection beyond this CFL number, the blocks without it lose their grip.
    constexpr double moderate = 8;
    const bool now_convective = chosen == Method::multigrid && equations.cfl > moderate;
    // The last step of a run may differ from the others by round-off only.
    const bool same = revision == equations.space.revision() && operators == &equations.operators &&
                      std::abs(rate - equations.rate) <= 1e-10 * rate;
    if (same && chosen == method && now_convective == convective)
      return;
    const auto &terms = equations.operators.terms();
    if (chosen == Method::multigrid)
      multigrid.prepare(
        equations.space,
        {terms.rho * equations.rate, terms.mu, terms.symmetric ? terms.mu : 0., terms.grad_div},
        !now_convective);
    if (told.insert(chosen).second)
      log::info(chosen == Method::direct ? "linear solver: direct"
                                         : "linear solver: multigrid, " + multigrid.describe());
    method                 = chosen;
    convective             = now_convective;
    revision               = equations.space.revision();
    rate                   = equations.rate;
    operators              = &equations.operators;
    factor_outdated        = true;
    factor_with_convection = false;
  }


  template <int dim>
  void
  StokesSolver<dim>::forget()
  {
    operators        = nullptr;
    method           = Method::automatic;
    factor_with_load = false;
    excess = uses = last_uses = 0;
  }


  template <int dim>
  void
  StokesSolver<dim>::factorize(const Equations &equations)
  {
    constexpr unsigned int n_u = FluidOperators<dim>::n_u, n_p = FluidOperators<dim>::n_p;
    const ImplicitLoad<dim> *load = factor_with_load ? equations.load : nullptr;
    std::map<unsigned int, std::vector<double>> of_level;
    factor_outdated = true; // should this fail
    direct.factorize(
      equations.space,
      [&](const unsigned int c, dealii::FullMatrix<double> &matrix) {
        std::vector<double> &velocity = of_level[equations.space.cells()[c].level];
        if (velocity.empty())
          velocity = equations.operators.velocity_matrix(equations.space, c, equations.rate);
        const std::vector<double> &divergence =
          equations.operators.divergence_matrix(equations.space, c);
        const std::vector<double> convection =
          factor_with_convection ? equations.operators.convection().matrix(c, *equations.velocity)
                                 : std::vector<double>(n_u * n_u, 0.);
        for (unsigned int i = 0; i < n_u; ++i)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(i, j) = velocity[i * n_u + j] + convection[i * n_u + j];
        for (unsigned int k = 0; k < n_p; ++k)
          for (unsigned int j = 0; j < n_u; ++j)
            matrix(n_u + k, j) = matrix(j, n_u + k) = -divergence[k * n_u + j];
      },
      !factor_with_convection,
      load ? load->matrix() : std::vector<typename ImplicitLoad<dim>::Product>());
    factor_outdated = false;
    excess          = 0;
    last_uses       = uses;
    uses            = 0;
  }


  template <int dim>
  void
  StokesSolver<dim>::renew_factorization(const Equations &equations)
  {
    // Rent or buy: a factorisation costs about as much as this many solutions with it. Once so many
    // were spent on the lack of the implicit load, or on the load of an old geometry, it pays.
    constexpr unsigned int price = 30;
    if (excess > price)
      factor_outdated = factor_with_load = true;
    if (factor_outdated)
      factorize(equations);
  }


  template <int dim>
  unsigned int
  StokesSolver<dim>::solve(const Equations &equations,
                           const VelocityVector &r,
                           const PressureVector &g,
                           const double weight,
                           const double target,
                           VelocityVector &du,
                           PressureVector &dp)
  {
    prepare(equations);
    if (method == Method::direct)
      {
        renew_factorization(equations);
        if (!equations.velocity && !equations.load)
          {
            direct.solve(r, g, du, dp);
            return 1;
          }
      }
    BlockVector right_hand_side(2), solution(2);
    right_hand_side.block(0).reinit(r, true);
    right_hand_side.block(1).reinit(g, true);
    right_hand_side.collect_sizes();
    right_hand_side.block(0).copy_locally_owned_data_from(r);
    right_hand_side.block(1).copy_locally_owned_data_from(g);
    right_hand_side.block(1) *= weight;
    solution.reinit(right_hand_side);
    const unsigned int n = iterate(equations, weight, target, right_hand_side, solution);
    ++uses;
    du.copy_locally_owned_data_from(solution.block(0));
    dp.copy_locally_owned_data_from(solution.block(1));
    return n;
  }


  template <int dim>
  unsigned int
  StokesSolver<dim>::iterate(const Equations &equations,
                             const double weight,
                             const double target,
                             const BlockVector &right_hand_side,
                             BlockVector &solution)
  {
    // Past this many iterations a factorisation is too old, or lacks too much. One that served no
    // second step will hardly be followed by one that does.
    const bool multigrids        = method == Method::multigrid;
    constexpr unsigned int usual = 3;
    const unsigned int stalled   = multigrids ? 300 : uses > 0 && last_uses == 1 ? 8 : 30;
    unsigned int total           = 0;
    for (const bool last_try : {multigrids, true})
      {
        dealii::SolverControl control(last_try && !multigrids ? 10 * stalled : stalled,
                                      target,
                                      false,
                                      false);
        control.enable_history_data();
        try
          {
            try_to_iterate(equations,
                           weight,
                           multigrids ? 40
                           : last_try ? 100
                                      : stalled,
                           control,
                           right_hand_side,
                           solution);
            if (!multigrids && equations.load && control.last_step() > usual)
              excess += control.last_step() - usual;
            return total + control.last_step();
          }
        catch (const dealii::SolverControl::NoConvergence &failure)
          {
            total += failure.last_step;
            if (last_try)
              throw RunFailure(
                "the linear solver (" + std::string(multigrids ? "multigrid" : "direct") +
                ") stopped after " + std::to_string(total) +
                " iterations; its residuals, relative to the first: " +
                history(control.get_history_data(), right_hand_side.l2_norm()) +
                (multigrids ? "; try \"linear_solver\": \"direct\", or a smaller step" : ""));
            log::debug(
              "factorising the fluid matrix anew, with all there is; the last one served " +
              std::to_string(uses) + " solutions");
            factor_with_load       = equations.load != nullptr;
            factor_with_convection = equations.velocity != nullptr;
            factorize(equations);
            solution = 0.;
          }
      }
    return total; // never reached: the last try returns or throws
  }


  template <int dim>
  void
  StokesSolver<dim>::try_to_iterate(const Equations &equations,
                                    const double weight,
                                    const unsigned int memory,
                                    dealii::SolverControl &control,
                                    const BlockVector &right_hand_side,
                                    BlockVector &solution)
  {
    using FGMRES = dealii::SolverFGMRES<BlockVector>;
    FGMRES fgmres(control, typename FGMRES::AdditionalData(memory));
    const Jacobian<dim> jacobian{equations, weight};
    const auto solve_with = [&](auto &inverse) {
      using Inverse = std::remove_reference_t<decltype(inverse)>;
      fgmres.solve(jacobian, solution, right_hand_side, Preconditioner<Inverse>{inverse, weight});
    };
    if (convective)
      {
        ConvectiveBlocks<dim> blocks(equations, multigrid);
        solve_with(blocks);
      }
    else if (method == Method::multigrid)
      solve_with(multigrid);
    else
      solve_with(direct);
  }


  template class StokesSolver<2>;
  template class StokesSolver<3>;
} // namespace feib
