// SPDX-License-Identifier: LGPL-2.1-or-later
#include "body_force_load.h"
#include "cell_kernels.h"
#include "fluid_operators.h"
#include "navier_stokes_schema.h"
#include "stokes_solver.h"

#include <feib/error.h>
#include <feib/expression.h>
#include <feib/failure.h>
#include <feib/fluid_solver.h>
#include <feib/message.h>
#include <feib/plugin.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <deque>
#include <memory>
#include <iomanip>
#include <optional>
#include <sstream>

namespace feib
{
  namespace
  {
    template <int dim>
    typename StokesSolver<dim>::Method
    method_of(const std::string &name)
    {
      using Method = typename StokesSolver<dim>::Method;
      return name == "automatic"   ? Method::automatic
             : name == "multigrid" ? Method::multigrid
                                   : Method::direct;
    }
  } // namespace


  /// Backward Euler steps of the incompressible Navier-Stokes equations, see the README.
  ///
  /// Every step is a residual and its correction: with the boundary values set in the first guess,
  /// the correction obeys homogeneous constraints, and one loop serves the linear step (one
  /// correction), Newton's method and an implicit load.
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

    void check(const CheckContext<dim> &context) override;

    void initialize(Space &space, ImplicitLoad<dim> *masses) override;

    Report advance(Space &space, const Step &step) override;

    void project(Space &space, ImplicitLoad<dim> *masses) override;

    void find_pressure(Space &space, const Step &step) override;

    double
    density() const override
    {
      return operators.terms().rho;
    }

    double
    viscosity() const override
    {
      return operators.terms().mu;
    }

    Balance balance(const Space &space) override;

    void commit() override;

    void archive(Archive &archive) override;

  private:
    static constexpr unsigned int n = EulerianSpace<dim>::n_nodes;

    /// Cycles in single precision tell fluxes from such fractions, not from much smaller ones.
    static constexpr double least_flux = 1e-4;

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

    /// A solution of a step, for the first guess of the next.
    struct Solution
    {
      double time = 0;
      VelocityVector velocity;
      PressureVector pressure;

      void
      archive(Archive &archive)
      {
        archive("time", time);
        archive("velocity", velocity);
        archive("pressure", pressure);
      }
    };

    /// For a new mesh.
    void prepare(const Space &space);

    /// The initial velocity at the nodes, without constraints.
    VelocityVector interpolated_initial_velocity(const Space &space);

    void assemble_body_force(const Space &space, double time);

    /// Whether the pressure of the equations is p + rho/2 |u|^2.
    bool
    total_pressure() const
    {
      return convects && operators.terms().convective_form == ConvectiveForm::rotational;
    }

    /// space.pressure += factor rho/2 |u|^2
    void add_dynamic_pressure(Space &space, double factor) const;

    /// Puts the polynomial in time through the solutions of the last steps into the state.
    void guess(Space &space, const Step &step) const;

    Norms norms(const Space &space, const VelocityVector &r, const PressureVector &g) const;

    /// The force per flux that stops it in a time step, by dimensions, for cells of size @p h.
    double
    impedance(const double h, const double rate) const
    {
      return operators.terms().rho * rate * h + operators.terms().mu / h;
    }

    /// What the divergence is compared with: the fluxes, unless they are next to nothing beside
    /// what momentum of the size @p scale could cause.
    double
    relevant_flux(const Space &space,
                  const double rate,
                  const Norms &residuals,
                  const double scale) const
    {
      double base = 0;
      for (unsigned int a = 0; a < dim; ++a)
        base =
          std::max(base,
                   (space.domain().upper[a] - space.domain().lower[a]) / space.domain().cells[a]);
      return std::max(residuals.divergence_scale,
                      least_flux * scale /
                        std::max(impedance(space.smallest_edge(), rate), impedance(base, rate)));
    }

    void remove_mean_pressure(Space &space) const;

    /// All that does not depend on the unknowns: load, inertia of u^n and body force.
    VelocityVector fixed_forces(const Space &space, const Step &step);

    Residual residual(const Space &space, const Step &step, const VelocityVector &fixed_forces);

    /// Why a step is given up.
    std::string not_converged(const Space &space,
                              const Step &step,
                              unsigned int iterations,
                              const std::string &history) const;

    /// Puts the powers of the step that led to the state of the space into the report.
    void account(const Space &space, const Residual &residual, Report &report) const;

    // What the case says.
    const double tolerance;
    const unsigned int max_iterations;
    const bool convects, reconstructs;
    std::unique_ptr<Expressions<dim>> body_force, initial_velocity;
    bool body_force_varies = false;

    // What is kept from step to step.
    std::optional<Reconstruction<dim>> reconstruction; // for the body force, if wanted
    FluidOperators<dim> operators;
    FluidOperators<dim> inertia; // without viscosity
    StokesSolver<dim> solver;
    unsigned int revision = 0;
    VelocityVector body_force_load;
    std::deque<std::shared_ptr<const Solution>> solutions; // of the last steps, the latest first
    std::shared_ptr<const Solution> provisional;           // the last one of the present step
  };


  template <int dim>
  NavierStokes<dim>::NavierStokes(const Parameters &parameters)
    : tolerance(parameters.number("tolerance"))
    , max_iterations(parameters.integer("max_iterations"))
    , convects(parameters.string("convection") != "none")
    , reconstructs(parameters.string("reconstruction") != "none")
    , operators({parameters.number("density"),
                 parameters.number("viscosity"),
                 parameters.number("grad_div"),
                 parameters.string("viscous_form") == "symmetric",
                 parameters.string("convective_form") == "rotational"
                   ? ConvectiveForm::rotational
                   : ConvectiveForm::skew_symmetric})
    , inertia({parameters.number("density"), 0., 0., false, ConvectiveForm::rotational})
    , solver(method_of<dim>(parameters.string("linear_solver")))
  {
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
  VelocityVector
  NavierStokes<dim>::interpolated_initial_velocity(const Space &space)
  {
    VelocityVector result      = space.make_velocity();
    const unsigned int n_owned = result.locally_owned_size();
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
              result.local_element(dof) = value[a];
        }
    return result;
  }


  template <int dim>
  void
  NavierStokes<dim>::check(const CheckContext<dim> &context)
  {
    const MPI_Comm communicator = context.space.communicator();
    Issues issues;
    if (initial_velocity)
      {
        interpolated_initial_velocity(context.space);
        issues = initial_velocity->not_finite(communicator);
      }
    Issues of_force;
    if (body_force)
      for (const double t : context.times)
        if (of_force.empty() && (t == context.times[0] || body_force_varies))
          {
            body_force->set_time(t);
            load_of_body_force<dim>(context.space, *body_force, nullptr);
            of_force = body_force->not_finite(communicator);
          }
    issues.insert(issues.end(), of_force.begin(), of_force.end());
    if (!issues.empty())
      throw Error(issues);
  }


  template <int dim>
  void
  NavierStokes<dim>::initialize(Space &space, ImplicitLoad<dim> *const masses)
  {
    const Domain<dim> &box = space.domain();
    if (reconstructs)
      {
        dealii::Tensor<1, dim> size;
        for (unsigned int a = 0; a < dim; ++a)
          size[a] = (box.upper[a] - box.lower[a]) / box.cells[a];
        reconstruction.emplace(size); // the same for the cells of all levels
      }
    space.set_time(0.);
    space.velocity = 0.;
    if (initial_velocity)
      space.velocity = interpolated_initial_velocity(space);
    space.distribute(space.velocity, false);
    space.pressure = 0.;
    space.pressure.update_ghost_values();
    // Boundary values alone are not divergence-free either.
    if (masses || space.velocity.linfty_norm() > 0)
      project(space, masses);
  }


  template <int dim>
  void
  NavierStokes<dim>::project(Space &space, ImplicitLoad<dim> *const masses)
  {
    prepare(space);
    // The correction of the velocity is all inertia, in a unit of time.
    constexpr double rate  = 1;
    const double impedance = density() * rate * space.smallest_edge();
    space.distribute(space.velocity, false);
    VelocityVector given = space.velocity, du = space.make_velocity();
    given.update_ghost_values();
    PressureVector multiplier = space.make_pressure(), dp = space.make_pressure();
    double scale = 0;
    for (unsigned int pass = 0; pass < 2; ++pass)
      {
        VelocityVector r = space.make_velocity(), load = space.make_velocity();
        PressureVector g = space.make_pressure();
        inertia.add_velocity_form(rate, 0., given, r);
        inertia.subtract_stokes(rate, space.velocity, multiplier, r, g);
        r.compress(dealii::VectorOperation::add);
        g.compress(dealii::VectorOperation::add);
        if (masses)
          masses->evaluate(space.velocity, load);
        r += load;
        space.condense(r);
        const Norms of = norms(space, r, g);
        if (pass == 0)
          scale = std::max(of.momentum, impedance * of.divergence_scale);
        const double flux = std::max(of.divergence_scale, least_flux * scale / impedance);
        if (of.momentum <= tolerance * scale && of.divergence <= tolerance * flux)
          break;
        solver.solve({space, inertia, rate, nullptr, 0., masses},
                     r,
                     g,
                     scale / flux,
                     .5 * tolerance * scale,
                     du,
                     dp);
        space.distribute(du, true);
        space.velocity.zero_out_ghost_values();
        space.velocity += du;
        space.distribute(space.velocity, false);
        multiplier.zero_out_ghost_values();
        multiplier += dp;
        multiplier.update_ghost_values();
      }
  }


  template <int dim>
  void
  NavierStokes<dim>::find_pressure(Space &space, const Step &step)
  {
    prepare(space);
    // How the values on the boundary change.
    constexpr double rate       = 1; // of the acceleration, the unknown
    VelocityVector acceleration = space.velocity;
    space.set_time(step.time + step.dt);
    space.distribute(acceleration, false);
    space.set_time(step.time);
    acceleration.zero_out_ghost_values();
    acceleration.add(-1., space.velocity);
    acceleration *= 1 / step.dt;
    acceleration.update_ghost_values();
    space.velocity.update_ghost_values();

    VelocityVector r = space.make_velocity(), opposed = space.make_velocity();
    PressureVector g = space.make_pressure();
    operators.add_velocity_form(0., 1., space.velocity, opposed);
    if (convects)
      {
        operators.set_convecting_velocity(space.velocity);
        operators.add_convection(1., space.velocity, opposed);
      }
    inertia.add_velocity_form(rate, 0., acceleration, opposed);
    operators.add_divergence(acceleration, g);
    opposed.compress(dealii::VectorOperation::add);
    g.compress(dealii::VectorOperation::add);
    if (step.implicit_load)
      step.implicit_load->apply(opposed, acceleration);
    r += step.load;
    if (body_force)
      {
        if (body_force_varies)
          assemble_body_force(space, step.time);
        r += body_force_load;
      }
    r -= opposed;
    space.condense(r);
    const double impedance = density() * rate * space.smallest_edge();
    const double scale     = std::max(r.l2_norm(), impedance * g.l2_norm());
    space.pressure         = 0.;
    if (scale > 0)
      solver.solve({space, inertia, rate, nullptr, 0., step.implicit_load},
                   r,
                   g,
                   impedance,
                   .1 * tolerance * scale,
                   acceleration,
                   space.pressure);
    if (total_pressure())
      add_dynamic_pressure(space, -1);
    if (space.domain().enclosed())
      remove_mean_pressure(space);
    space.pressure.update_ghost_values();
  }


  template <int dim>
  void
  NavierStokes<dim>::prepare(const Space &space)
  {
    if (revision == space.revision())
      return;
    operators.reinit(space);
    inertia.reinit(space);
    if (body_force && !body_force_varies)
      assemble_body_force(space, 0.);
    if (revision != 0) // else they have been read, for this mesh
      solutions.clear();
    provisional.reset();
    revision = space.revision();
  }


  template <int dim>
  void
  NavierStokes<dim>::assemble_body_force(const Space &space, const double time)
  {
    body_force->set_time(time);
    body_force_load =
      load_of_body_force(space, *body_force, reconstruction ? &*reconstruction : nullptr);
    if (const Issues issues = body_force->not_finite(space.communicator()); !issues.empty())
      throw RunFailure(Error(issues).what());
  }


  template <int dim>
  typename NavierStokes<dim>::Balance
  NavierStokes<dim>::balance(const Space &space)
  {
    prepare(space);
    return operators.balance(space);
  }


  template <int dim>
  void
  NavierStokes<dim>::guess(Space &space, const Step &step) const
  {
    // Far from solutions close to each other a polynomial is no guess.
    constexpr double farthest = 3;
    const auto time           = [&](const unsigned int i) { return solutions[i]->time; };
    unsigned int n_used       = 1;
    while (n_used < solutions.size() &&
           step.time - time(0) < farthest * (time(n_used - 1) - time(n_used)))
      ++n_used;
    if (solutions.empty() || n_used < 2)
      return;
    space.velocity = 0.;
    space.pressure = 0.;
    for (unsigned int i = 0; i < n_used; ++i)
      {
        double weight = 1; // Lagrange's polynomials at the new time
        for (unsigned int j = 0; j < n_used; ++j)
          if (j != i)
            weight *= (step.time - time(j)) / (time(i) - time(j));
        space.velocity.add(weight, solutions[i]->velocity);
        space.pressure.add(weight, solutions[i]->pressure);
      }
  }


  template <int dim>
  void
  NavierStokes<dim>::commit()
  {
    constexpr unsigned int n_kept = 3;
    if (provisional)
      solutions.push_front(std::move(provisional));
    provisional.reset();
    if (solutions.size() > n_kept)
      solutions.pop_back();
  }


  template <int dim>
  void
  NavierStokes<dim>::archive(Archive &archive)
  {
    archive("solutions", solutions);
    if (archive.persistent())
      solver.forget();
    if (archive.reading())
      provisional.reset();
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
        const auto &size = space.cells()[c].size;
        const double det = cell_volume(size);
        double sum       = 0;
        for (unsigned int a = 0; a < dim; ++a)
          {
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
  void
  NavierStokes<dim>::remove_mean_pressure(Space &space) const
  {
    double integral = 0, volume = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const double det = cell_volume(space.cells()[c].size);
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
  void
  NavierStokes<dim>::add_dynamic_pressure(Space &space, const double factor) const
  {
    space.velocity.update_ghost_values();
    space.pressure.zero_out_ghost_values();
    operators.add_dynamic_pressure(factor, space.velocity, space.pressure);
    space.pressure.update_ghost_values();
  }


  template <int dim>
  VelocityVector
  NavierStokes<dim>::fixed_forces(const Space &space, const Step &step)
  {
    VelocityVector fixed = space.make_velocity();
    space.old_velocity.update_ghost_values();
    operators.add_velocity_form(1 / step.dt, 0., space.old_velocity, fixed);
    fixed.compress(dealii::VectorOperation::add);
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
                              const VelocityVector &fixed_forces)
  {
    Residual result;
    result.momentum   = space.make_velocity();
    result.divergence = space.make_pressure();
    operators.subtract_stokes(
      1 / step.dt, space.velocity, space.pressure, result.momentum, result.divergence);
    if (convects)
      {
        operators.set_convecting_velocity(space.velocity);
        operators.add_convection(-1., space.velocity, result.momentum);
      }
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
      throw RunFailure("the fluid's residual is not finite at time " + readable(step.time));
    return result;
  }


  template <int dim>
  std::string
  NavierStokes<dim>::not_converged(const Space &space,
                                   const Step &step,
                                   const unsigned int iterations,
                                   const std::string &history) const
  {
    std::ostringstream text;
    text << std::setprecision(3) << "the fluid step to time " << step.time
         << " did not reach its tolerance in " << iterations
         << " iterations; relative residuals of momentum (and divergence): " << history;
    if (convects)
      text << "; convection had a CFL number of "
           << operators.cfl_rate(space.old_velocity) * step.dt;
    return text.str();
  }


  template <int dim>
  void
  NavierStokes<dim>::account(const Space &space, const Residual &residual, Report &report) const
  {
    report.dissipation = operators.dissipation(space.velocity);
    VelocityVector increment(space.velocity);
    increment -= space.old_velocity;
    increment.update_ghost_values();
    report.increment_energy = .5 * operators.square(increment);
    if (convects)
      {
        VelocityVector force = space.make_velocity();
        operators.add_convection(1., space.velocity, force);
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
    prepare(space);
    if (total_pressure())
      add_dynamic_pressure(space, 1);
    // The last solution of the same step is nearer than any guess.
    if (!provisional)
      guess(space, step);
    space.set_time(step.time);
    space.distribute(space.velocity, false);
    const double rate          = 1 / step.dt;
    const VelocityVector fixed = fixed_forces(space, step);
    VelocityVector condensed   = fixed;
    space.condense(condensed);
    const bool linear = !convects && (!step.implicit_load || step.implicit_load->linear());

    Report report;
    Residual present = residual(space, step, fixed);
    const double scale =
      std::max({condensed.l2_norm(), present.implicit_load, present.norms.momentum});
    // What is left of the divergence moves what structures enclose, and costs little to lower.
    const double tighter = convects ? 4 : 1;
    std::ostringstream history;
    history << std::setprecision(2);
    while (true)
      {
        const Norms &norms = present.norms;
        const bool first   = report.nonlinear_iterations == 0;
        history << (first ? "" : ", ") << norms.momentum / scale;
        const double flux = relevant_flux(space, rate, norms, scale);
        if (flux > 0)
          history << " (" << norms.divergence / flux << ")";
        // The divergence is a linear equation: any correction solves it as far as round-off allows.
        if (first ? scale == 0. && norms.divergence == 0.
                  : norms.momentum <= tolerance * scale &&
                      norms.divergence <= tolerance / tighter * flux)
          break;
        constexpr double hopeless = 1e4; // times the forces
        if (report.nonlinear_iterations >= max_iterations || norms.momentum > hopeless * scale)
          throw RunFailure(not_converged(space, step, report.nonlinear_iterations, history.str()));

        // A linear problem is solved at once; Newton's method converges quadratically while each
        // linear residual is the square of the nonlinear one.
        const double target =
          std::max((linear ? .3 : .1) * tolerance * scale,
                   (linear ? 1e-13 : std::min(1e-4, .02 * norms.momentum / scale)) *
                     norms.momentum);
        VelocityVector du = space.make_velocity();
        PressureVector dp = space.make_pressure();
        report.linear_iterations +=
          solver.solve({space,
                        operators,
                        rate,
                        convects ? &space.velocity : nullptr,
                        convects ? operators.cfl_rate(space.velocity) * step.dt : 0.,
                        step.implicit_load},
                       present.momentum,
                       present.divergence,
                       norms.divergence_scale > 0 ? tighter * scale / flux
                                                  : impedance(space.smallest_edge(), rate),
                       target,
                       du,
                       dp);
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
    account(space, present, report);

    provisional =
      std::make_shared<const Solution>(Solution{step.time, space.velocity, space.pressure});
    if (total_pressure())
      {
        add_dynamic_pressure(space, -1);
        if (space.domain().enclosed())
          remove_mean_pressure(space);
        space.pressure.update_ghost_values();
      }
    return report;
  }
} // namespace feib


FEIB_PLUGIN("navier_stokes", "1.0", registry)
{
  registry.add<feib::FluidSolver, feib::NavierStokes>("navier_stokes", navier_stokes_schema);
}
