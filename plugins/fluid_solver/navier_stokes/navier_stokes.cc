// SPDX-License-Identifier: LGPL-2.1-or-later
#include "navier_stokes_schema.h"
#include "newton_iteration.h"
#include "operators/body_force.h"
#include "past_solutions.h"
#include "starting_state.h"

#include <feib/error.h>
#include <feib/expression.h>
#include <feib/fluid_solver.h>
#include <feib/plugin.h>

#include <algorithm>
#include <memory>

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

    template <int dim>
    typename FluidOperators<dim>::Terms
    terms_of(const Parameters &parameters)
    {
      return {parameters.number("density"),
              parameters.number("viscosity"),
              parameters.number("grad_div"),
              parameters.string("viscous_form") == "symmetric",
              parameters.string("convective_form") == "rotational"
                ? ConvectiveForm::rotational
                : ConvectiveForm::skew_symmetric};
    }
  } // namespace


  /// Backward Euler steps of the incompressible Navier-Stokes equations, see the README.
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

    void
    commit() override
    {
      past.commit();
      outlets.commit();
    }

    void archive(Archive &archive) override;

  private:
    /// For a new mesh.
    void prepare(const Space &space);

    /// The initial velocity at the nodes, without constraints.
    VelocityVector interpolated_initial_velocity(const Space &space);

    /// Whether the pressure of the equations is p + rho/2 |u|^2.
    bool
    total_pressure() const
    {
      return settings.convects && operators.terms().convective_form == ConvectiveForm::rotational;
    }

    /// space.pressure += factor rho/2 |u|^2
    void add_dynamic_pressure(Space &space, double factor) const;

    /// From the pressure of the equations to p.
    void report_pressure(Space &space) const;

    /// Load, body force, tractions and inertia of u^n: all that does not depend on the unknowns.
    VelocityVector fixed_forces(const Space &space, const Step &step);

    /// Puts the powers of the step that led to the state of the space into the report.
    void account(const Space &space, Report &report) const;

    /// Of prescribed velocities and of tractions.
    double
    boundary_power(const Space &space, const VelocityVector &reaction, const Report &report) const;

    const typename NewtonIteration<dim>::Settings settings;
    BodyForce<dim> body_force;
    std::unique_ptr<Expressions<dim>> initial_velocity;
    FluidOperators<dim> operators;
    BoundaryTerms<dim> boundary;
    RegulatedPressures<dim> outlets;
    StokesSolver<dim> solver;
    StartingState<dim> starting_state;
    PastSolutions<dim> past;
    unsigned int revision = 0;
  };


  template <int dim>
  NavierStokes<dim>::NavierStokes(const Parameters &parameters)
    : settings{parameters.number("tolerance"),
               static_cast<unsigned int>(parameters.integer("max_iterations")),
               parameters.string("convection") != "none"}
    , body_force(parameters)
    , operators(terms_of<dim>(parameters))
    , outlets(boundary)
    , solver(method_of<dim>(parameters.string("linear_solver")))
    , starting_state(operators, solver, outlets, settings.tolerance, settings.convects)
  {
    if (parameters.has("initial_velocity"))
      initial_velocity =
        parse_expressions<dim>(parameters, "initial_velocity", dim, Variables::space_time);
  }


  template <int dim>
  VelocityVector
  NavierStokes<dim>::interpolated_initial_velocity(const Space &space)
  {
    constexpr unsigned int n   = Space::n_nodes;
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
    Issues issues;
    if (initial_velocity)
      {
        interpolated_initial_velocity(context.space);
        issues = initial_velocity->not_finite(context.space.communicator());
      }
    const Issues of_force = body_force.check(context.space, context.times);
    issues.insert(issues.end(), of_force.begin(), of_force.end());
    const Issues of_boundary = BoundaryTerms<dim>::check(context.space, context.times);
    issues.insert(issues.end(), of_boundary.begin(), of_boundary.end());
    if (!issues.empty())
      throw Error(issues);
  }


  template <int dim>
  void
  NavierStokes<dim>::prepare(const Space &space)
  {
    if (revision == space.revision())
      return;
    operators.reinit(space);
    boundary.reinit(space);
    outlets.reinit(space);
    starting_state.reinit(space);
    if (revision != 0) // else they have been read, for this mesh
      past.forget();
    revision = space.revision();
  }


  template <int dim>
  void
  NavierStokes<dim>::initialize(Space &space, ImplicitLoad<dim> *const masses)
  {
    space.set_time(0.);
    space.velocity = 0.;
    if (initial_velocity)
      space.velocity = interpolated_initial_velocity(space);
    space.distribute(space.velocity, false);
    space.pressure = 0.;
    space.pressure.update_ghost_values();
    // Boundary values alone are not divergence-free either.
    prepare(space);
    if (masses || space.velocity.linfty_norm() > 0 || !outlets.empty())
      project(space, masses);
  }


  template <int dim>
  void
  NavierStokes<dim>::project(Space &space, ImplicitLoad<dim> *const masses)
  {
    prepare(space);
    starting_state.project(space, masses);
  }


  template <int dim>
  void
  NavierStokes<dim>::find_pressure(Space &space, const Step &step)
  {
    prepare(space);
    VelocityVector forces = space.make_velocity();
    forces += step.load;
    if (body_force.exists())
      forces += body_force.load(space, step.time);
    if (boundary.exists(space.domain()))
      forces += boundary.load(space, step.time, outlets.pressures(space));
    starting_state.find_pressure(space, step, forces);
    report_pressure(space);
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
  NavierStokes<dim>::archive(Archive &archive)
  {
    past.archive(archive);
    archive("outlets", outlets);
    if (archive.persistent())
      solver.forget();
  }


  template <int dim>
  void
  NavierStokes<dim>::add_dynamic_pressure(Space &space, const double factor) const
  {
    space.velocity.update_ghost_values();
    space.pressure.zero_out_ghost_values();
    operators.convection().add_dynamic_pressure(factor, space.velocity, space.pressure);
    space.pressure.update_ghost_values();
  }


  template <int dim>
  void
  NavierStokes<dim>::report_pressure(Space &space) const
  {
    if (total_pressure())
      add_dynamic_pressure(space, -1);
    if (space.domain().enclosed())
      remove_mean_pressure(space);
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
    if (body_force.exists())
      fixed += body_force.load(space, step.time);
    if (boundary.exists(space.domain()))
      fixed +=
        boundary.load(space, step.time, std::vector<double>(space.domain().conditions.size(), 0.));
    return fixed;
  }


  template <int dim>
  void
  NavierStokes<dim>::account(const Space &space, Report &report) const
  {
    report.dissipation = operators.dissipation(space.velocity);
    VelocityVector increment(space.velocity);
    increment -= space.old_velocity;
    increment.update_ghost_values();
    report.increment_energy = .5 * operators.square(increment);
    if (settings.convects)
      {
        VelocityVector force = space.make_velocity();
        operators.convection().add(1., space.velocity, force);
        force.compress(dealii::VectorOperation::add);
        report.convection_power = force * space.velocity;
      }
    if (body_force.exists())
      report.body_force_power = body_force.last_load() * space.velocity;
  }


  template <int dim>
  double
  NavierStokes<dim>::boundary_power(const Space &space,
                                    const VelocityVector &reaction,
                                    const Report &report) const
  {
    double result   = 0;
    bool any_motion = false;
    for (unsigned int i = 0; i < report.boundary.size(); ++i)
      {
        const auto &condition = space.domain().conditions[i];
        if (condition.open())
          result += report.boundary[i].power;
        any_motion = any_motion || condition.velocity;
      }
    // What the solver left over elsewhere works, too: with that the balance closes to round-off.
    return any_motion ? result - reaction * space.velocity : result;
  }


  template <int dim>
  typename NavierStokes<dim>::Report
  NavierStokes<dim>::advance(Space &space, const Step &step)
  {
    prepare(space);
    if (total_pressure())
      add_dynamic_pressure(space, 1);
    past.guess(space, step.time);
    space.set_time(step.time, step.dt / (step.dt + step.beyond), step.time + step.beyond);
    space.distribute(space.velocity, false);
    const VelocityVector fixed = fixed_forces(space, step);

    Report report;
    outlets.begin(space, step, !settings.convects && !step.implicit_load);
    NewtonIteration<dim> iteration(settings, operators, solver, outlets, space, step, fixed);
    iteration.run(report);
    outlets.finish(outlets.fluxes(space));
    account(space, report);
    past.keep(space, step.time);
    if (total_pressure())
      report_pressure(space);
    report.boundary =
      boundary.exchange(space, iteration.reaction(), step.time, outlets.pressures(space));
    report.boundary_power = boundary_power(space, iteration.reaction(), report);
    return report;
  }
} // namespace feib


FEIB_PLUGIN("navier_stokes", "1.0", registry)
{
  registry.add<feib::FluidSolver, feib::NavierStokes>("navier_stokes", navier_stokes_schema);
}
