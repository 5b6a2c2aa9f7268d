// SPDX-License-Identifier: LGPL-2.1-or-later
// Components around right ones ("of"), each with the fault that its parameter names.
#include <feib/modified_law.h>
#include <feib/output_writer.h>
#include <feib/plugin.h>
#include <feib/refinement_strategy.h>
#include <feib/time_integrator.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <limits>

namespace
{
  using namespace feib;

  template <int dim>
  class WrongScheme : public TimeIntegrator<dim>
  {
  public:
    using Base   = TimeIntegrator<dim>;
    using System = typename Base::System;

    explicit WrongScheme(const Parameters &parameters)
      : right(parameters.child("of").create<Base>())
      , fault(parameters.string("fault"))
    {}

    typename Base::Report
    step(System &system, const double time, const double dt) override
    {
      ++n_steps;
      typename Base::Report report;
      try
        {
          report = right->step(system, time, dt);
        }
      catch (const RunFailure &)
        {
          if (fault != "swallows failures")
            throw;
        }
      Positions<dim> &X = system.structures[0].model->positions;
      if (fault == "dissipates more")
        report.dissipated *= 1.001;
      else if (fault == "more power")
        report.exchanges[0].power *= 1.001;
      else if (fault == "no force")
        report.exchanges[1].force = {};
      else if (fault == "forgets what is inelastic")
        report.exchanges[1].inelastic = 0;
      else if (fault == "another time")
        system.structures[1].model->set_moment(time, 0.);
      else if (fault == "drifts")
        for (dealii::Point<dim> &x : X)
          x[0] += dt * dt * (x[1] - .5);
      else if (fault == "counts steps that failed")
        X[0][0] += 1e-9 * n_steps;
      else if (fault == "moves by rank")
        X[0][0] += 1e-5 * dealii::Utilities::MPI::this_mpi_process(system.space.communicator());
      else if (fault == "moves what is old")
        system.space.old_velocity *= 1.01;
      return report;
    }

    void
    archive(Archive &archive) override
    {
      if (fault != "forgets its past")
        right->archive(archive);
    }

    typename Base::StabilityLimit
    stability_limit(const System &system) const override
    {
      auto limit = right->stability_limit(system);
      if (fault == "no limit")
        return {};
      if (fault == "negative limit")
        limit.dt = -1;
      if (fault == "limit of another")
        limit.alternative = "fe_be";
      return limit;
    }

    std::vector<std::pair<std::string, double>>
    diagnostics(const System &system, const double dt) const override
    {
      auto columns = right->diagnostics(system, dt);
      if (fault == "other columns")
        columns.emplace_back("column " + std::to_string(n_steps), 0.);
      return columns;
    }

  private:
    const std::unique_ptr<Base> right;
    const std::string fault;
    unsigned int n_steps = 0;
  };


  template <int dim>
  class WrongFluid : public FluidSolver<dim>
  {
  public:
    using Base  = FluidSolver<dim>;
    using Space = EulerianSpace<dim>;
    using Load  = ImplicitLoad<dim>;

    explicit WrongFluid(const Parameters &parameters)
      : right(parameters.child("of").create<Base>())
      , fault(parameters.string("fault"))
    {}

    void
    initialize(Space &space, Load *inertia) override
    {
      right->initialize(space, inertia);
    }

    typename Base::Report
    advance(Space &space, const typename Base::Step &step) override
    {
      typename Base::Step taken = step;
      if (fault == "ignores implicit loads")
        taken.implicit_load = nullptr;
      if (fault == "knows no beyond")
        taken.beyond = 0;
      auto report = right->advance(space, taken);
      if (fault == "dissipates more")
        report.dissipation *= 1.01;
      else if (fault == "larger increment")
        report.increment_energy *= 1.01;
      else if (fault == "expands")
        change(space, 1.01);
      else if (fault == "slips")
        change(space, 1., 1e-9);
      else if (fault == "leaks")
        for (unsigned int i = 0; i < space.velocity.locally_owned_size(); i += 3)
          space.velocity.local_element(i) *= 1.01;
      else if (fault == "moves what is old")
        space.old_velocity *= 1 + 1e-9;
      else if (fault == "moves by rank" &&
               dealii::Utilities::MPI::n_mpi_processes(space.communicator()) > 1)
        change(space, 1.001);
      else if (fault == "counts steps")
        change(space, 1 + 1e-9 * ++n_steps);
      else if (fault == "counts commits")
        change(space, 1 + 1e-9 * n_commits);
      else if (fault == "gives way" && space.velocity.linfty_norm() < 1e-3)
        change(space, 1., 1e-3);
      return report;
    }

    void
    commit() override
    {
      right->commit();
      ++n_commits;
    }

    void
    archive(Archive &archive) override
    {
      if (fault != "forgets its past")
        right->archive(archive);
      if (fault == "counts commits")
        archive("commits", n_commits);
    }

    void
    project(Space &space, Load *inertia) override
    {
      right->project(space, inertia);
      if (fault == "projects too far")
        change(space, .99);
    }

    void
    find_pressure(Space &space, const typename Base::Step &step) override
    {
      right->find_pressure(space, step);
      if (fault == "other pressure")
        space.pressure *= 1.01;
    }

    double
    density() const override
    {
      return right->density();
    }

    double
    viscosity() const override
    {
      return right->viscosity();
    }

    typename Base::Balance
    balance(const Space &space) override
    {
      auto result = right->balance(space);
      if (fault == "heavier")
        result.kinetic_energy *= 1.01;
      else if (fault == "turned")
        result.angular_momentum *= -1.;
      return result;
    }

  private:
    /// Multiplies what this rank has of the velocity and adds to it.
    static void
    change(Space &space, const double factor, const double shift = 0)
    {
      space.velocity.zero_out_ghost_values();
      for (double &value : space.velocity)
        value = factor * value + shift;
      space.velocity.update_ghost_values();
    }

    const std::unique_ptr<Base> right;
    const std::string fault;
    unsigned int n_steps = 0, n_commits = 0;
  };


  template <int dim>
  class WrongRefinement : public RefinementStrategy<dim>
  {
  public:
    using Base       = RefinementStrategy<dim>;
    using Structures = std::vector<ImmersedStructure<dim>>;

    explicit WrongRefinement(const Parameters &parameters)
      : right(parameters.child("of").create<Base>())
      , fault(parameters.string("fault"))
    {}

    void
    plan(const EulerianSpace<dim> &space, const Structures &structures) override
    {
      right->plan(space, structures);
      ++n_plans;
    }

    void
    mark(dealii::parallel::distributed::Triangulation<dim> &mesh,
         const EulerianSpace<dim> &space,
         const Structures &structures) const override
    {
      if (fault == "stays" && n_plans > 2)
        return;
      right->mark(mesh, space, structures);
      // The level of the cell in the corner that is wanted beside.
      const bool one_rank = dealii::Utilities::MPI::n_mpi_processes(space.communicator()) == 1;
      const int wanted    = fault == "flickers"  ? (n_plans % 2 == 1 ? 5 : -1)
                            : fault == "by rank" ? (one_rank ? 4 : 5)
                            : fault == "forgets" ? (n_plans > 2 ? 5 : 4)
                                                 : -1;
      for (const auto &cell : mesh.active_cell_iterators())
        if (cell->is_locally_owned() && wanted > 0)
          {
            cell->clear_coarsen_flag();
            if (cell->center().norm() < .51 * cell->diameter() && space.level(*cell) < wanted)
              cell->set_refine_flag();
          }
    }

    unsigned int
    interval() const override
    {
      return right->interval();
    }

    double
    forecast_cells(const EulerianSpace<dim> &space, const Structures &structures) const override
    {
      return right->forecast_cells(space, structures) + (fault == "forecasts more" ? 1 : 0);
    }

  private:
    const std::unique_ptr<Base> right;
    const std::string fault;
    unsigned int n_plans = 0;
  };


  template <int dim>
  class WrongWriter : public OutputWriter<dim>
  {
  public:
    using Base = OutputWriter<dim>;

    explicit WrongWriter(const Parameters &parameters)
      : right(parameters.child("of").create<Base>())
      , fault(parameters.string("fault"))
    {}

    void
    archive(Archive &archive) override
    {
      if (fault != "forgets its files")
        right->archive(archive);
    }

    unsigned int
    interval() const override
    {
      return fault == "never" ? 0 : right->interval();
    }

    void
    reopen(const std::string &directory, const MPI_Comm communicator) override
    {
      reopened = true;
      if (fault == "does not miss files")
        return;
      right->reopen(directory, communicator);
    }

    void
    write(const typename Base::Snapshot &snapshot) override
    {
      if (fault == "loses a row" && reopened && snapshot.step == 3)
        return;
      try
        {
          right->write(snapshot);
          if (fault == "doubles a row" && reopened && snapshot.step == 3)
            right->write(snapshot);
        }
      catch (const RunFailure &)
        {
          if (fault == "nameless failures")
            throw RunFailure("cannot write");
          if (fault != "swallows failures")
            throw;
        }
    }

  private:
    const std::unique_ptr<Base> right;
    const std::string fault;
    bool reopened = false;
  };


  template <int dim>
  class WrongCoupling : public CouplingOperator<dim>
  {
  public:
    using Base  = CouplingOperator<dim>;
    using Space = EulerianSpace<dim>;

    explicit WrongCoupling(const Parameters &parameters)
      : right(parameters.child("of").create<Base>())
      , fault(parameters.string("fault"))
    {}

    void
    set_geometry(const Space &space,
                 const LagrangianMesh<dim> &mesh,
                 const Positions<dim> &X,
                 const LagrangianPoints &points) override
    {
      within = points.nodes_per_point > 1;
      right->set_geometry(space, mesh, X, points);
    }

    void
    interpolate(const Space &space, const VelocityVector &u, NodalField<dim> &U) const override
    {
      right->interpolate(space, u, U);
      if (fault == "faster" || (fault == "faster within elements" && within))
        for (auto &velocity : U)
          velocity *= 1.001;
    }

    void
    spread(const Space &space, const NodalField<dim> &f, VelocityVector &rhs) const override
    {
      right->spread(space, f, rhs);
    }

    MatrixEntries
    entries(const Space &space) const override
    {
      MatrixEntries result = right->entries(space);
      if (fault == "lacks entries" && !result.empty())
        result.pop_back();
      return result;
    }

  private:
    const std::unique_ptr<Base> right;
    const std::string fault;
    bool within = false;
  };


  template <int structure_dim, int dim>
  class WrongLaw : public ModifiedLaw<structure_dim, dim>
  {
  public:
    using Base   = ConstitutiveLaw<structure_dim, dim>;
    using Matrix = typename Base::Matrix;
    using State  = std::vector<std::vector<double>>;

    explicit WrongLaw(const Parameters &parameters)
      : ModifiedLaw<structure_dim, dim>(parameters.child("of").create<Base>())
      , fault(parameters.string("fault"))
    {}

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      law->energy(F, W);
      for (unsigned int q = 0; q < F.size(); ++q)
        if (fault == "both negative")
          W[q] *= -1;
        else if (fault == "half the energy")
          W[q] *= .5;
        else if (fault == "depends on the observer")
          W[q] += .1 * F[q][0][0];
        else if (fault == "another when asked again")
          W[q] += 1e-6 * ++n_calls;
        else if (fault == "changes with time")
          W[q] += .01 * this->moment().time;
        else if (fault == "not a number at rest" && at_rest(F[q]))
          W[q] = std::nan("");
        else if (fault == "depends on others")
          W[q] += 1e-6 * W[0] * (F.size() - 1.);
        else if (fault == "infinite where stretched" && F[q][0].norm() > 1.2)
          W[q] = std::numeric_limits<double>::infinity();
      if (fault == "one value too few")
        W.pop_back();
      if (fault == "throws")
        throw RunFailure("the law has no value");
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      law->stress(F, P);
      for (unsigned int q = 0; q < F.size(); ++q)
        if (fault == "sign" || fault == "both negative")
          P[q] *= -1.;
        else if (fault == "factor two")
          P[q] *= 2.;
        else if (fault == "transposed")
          P[q] = transposed(P[q]);
        else if (fault == "depends on the observer")
          P[q][0][0] += .1;
        else if (fault == "stress of an observer")
          P[q][0][0] += .1;
        else if (fault == "a term missing")
          P[q][0] -= .1 * F[q][0];
        else if (fault == "no energy for it" || fault == "no energy, derivative right")
          P[q][0] += .1 * F[q][1];
        else if (fault == "not a number at rest, stress" && at_rest(F[q]))
          P[q][0][0] = std::nan("");
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      law->stress_derivative(F, dF, dP);
      for (unsigned int q = 0; q < F.size(); ++q)
        if (fault == "derivative too stiff")
          dP[q] *= 1.01;
        else if (fault == "derivative without a row")
          dP[q][0] = {};
        else if (fault == "no energy, derivative right")
          dP[q][0] += .1 * dF[q][1];
    }

    void
    update_state(const std::vector<Matrix> &F, State &state) const override
    {
      law->update_state(F, state);
      for (unsigned int q = 0; q < F.size(); ++q)
        if (fault == "counts the state twice")
          state.back()[q] += .1;
        else if (fault == "state gives energy")
          state.back()[q] *= .5;
        else if (fault == "state another when asked again")
          state.back()[q] += 1e-6 * ++n_calls;
    }

    bool
    viscous() const override
    {
      return fault != "viscous unsaid" && law->viscous();
    }

    void
    viscous_stress(const std::vector<Matrix> &F,
                   const std::vector<Matrix> &rate,
                   std::vector<Matrix> &P) const override
    {
      law->viscous_stress(F, rate, P);
      for (unsigned int q = 0; q < F.size(); ++q)
        if (fault == "drives")
          P[q] *= -1.;
        else if (fault == "square of the rate")
          P[q] *= rate[q][0].norm();
        else if (fault == "no potential")
          P[q][0] += .1 * rate[q][1];
        else if (fault == "resists rotation")
          P[q] += .1 * rate[q];
        else if (fault == "damping of an observer")
          P[q][0] += .1 * rate[q][0];
    }

    bool
    linear() const override
    {
      return fault == "says it is linear" || law->linear();
    }

    bool
    needs_positive_determinant() const override
    {
      return fault != "says it is defined everywhere" && law->needs_positive_determinant();
    }

  private:
    static bool
    at_rest(const Matrix &F)
    {
      double distance = 0;
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int k = 0; k < structure_dim; ++k)
          distance += std::abs(F[i][k] - (i == k));
      return distance == 0;
    }

    static Matrix
    transposed(const Matrix &A)
    {
      Matrix result = A;
      for (unsigned int i = 0; i < structure_dim; ++i)
        for (unsigned int k = 0; k < structure_dim; ++k)
          result[i][k] = A[k][i];
      return result;
    }

    using ModifiedLaw<structure_dim, dim>::law;
    const std::string fault;
    mutable unsigned int n_calls = 0;
  };


  /// A force around a right one.
  template <int dim>
  class WrongForce : public StructureForce<dim>
  {
  public:
    using Body      = typename StructureForce<dim>::Body;
    using Stiffness = typename StructureForce<dim>::Stiffness;

    explicit WrongForce(const Parameters &parameters)
      : right(parameters.child("of").create<StructureForce<dim>>())
      , fault(parameters.string("fault"))
    {}

    void
    attach(const Body &body) override
    {
      right->attach(body);
      n_nodes = body.mesh.n_nodes();
    }

    void
    set_moment(const double time, const double elapsed) override
    {
      right->set_moment(time, elapsed);
    }

    void
    update_state(const Positions<dim> &X) override
    {
      right->update_state(X);
      remembered += .1;
    }

    double
    energy(const Positions<dim> &X) const override
    {
      return right->energy(X);
    }

    void
    load(const Positions<dim> &X, NodalField<dim> &load) const override
    {
      right->load(X, load);
      if (fault == "sign" || fault == "factor")
        for (auto &f : load)
          f *= fault == "sign" ? -1. : 1.01;
      if (fault == "throws")
        throw RunFailure("no load today");
      if (fault == "forgets")
        load[0][0] += remembered;
    }

    void
    load_derivative(const Positions<dim> &X,
                    const NodalField<dim> &dX,
                    NodalField<dim> &dload) const override
    {
      right->load_derivative(X, dX, dload);
      if (fault == "derivative")
        for (auto &f : dload)
          f *= 1.001;
    }

    void
    tangent(const Positions<dim> &X, MatrixEntries &entries) const override
    {
      right->tangent(X, entries);
      if (fault == "entries")
        entries.push_back({0, 0, 1.});
      if (fault == "beyond")
        entries.push_back({dim * n_nodes, 0, 1.});
    }

    bool
    linear() const override
    {
      return right->linear() || fault == "linear";
    }

    bool
    viscous() const override
    {
      return fault != "not viscous" && right->viscous();
    }

    void
    viscous_load(const Positions<dim> &X,
                 const NodalField<dim> &U,
                 NodalField<dim> &load) const override
    {
      right->viscous_load(X, U, load);
      for (auto &f : load)
        f *= fault == "drives" ? -1. : fault == "quadratic" ? U[0].norm() : 1.;
    }

    void
    viscous_tangent(const Positions<dim> &X, MatrixEntries &entries) const override
    {
      right->viscous_tangent(X, entries);
    }

    void
    external_load(const Positions<dim> &, NodalField<dim> &load) const override
    {
      if (fault == "not external")
        load[0][0] += 1;
    }

    Stiffness
    stiffness(const Positions<dim> &X) const override
    {
      Stiffness result = right->stiffness(X);
      if (fault == "soft")
        result.nodal /= 1e3;
      return result;
    }

  private:
    const std::unique_ptr<StructureForce<dim>> right;
    const std::string fault;
    unsigned int n_nodes = 0;
    double remembered    = 0;
  };


  std::string
  schema(const std::string &kind, const std::string &example)
  {
    return R"({
      "type": "object", "additionalProperties": false, "description": "A component with a fault.",
      "required": ["of"],
      "properties": {
        "of": { "slot": ")" +
           kind + R"(", "description": "What would be right." },
        "fault": { "type": "string", "default": "none", "description": "What is wrong." }
      },
      "examples": [ { "of": )" +
           example + " } ] }";
  }
} // namespace

FEIB_PLUGIN("wrong_components", "1.0", registry)
{
  registry.add<TimeIntegrator, WrongScheme>("wrong_scheme",
                                            schema("time_integrator", R"({"midpoint": {}})"));
  registry.add<FluidSolver, WrongFluid>(
    "wrong_fluid",
    schema("fluid_solver", R"({"navier_stokes": {"density": 1.3, "viscosity": 0.05}})"));
  registry.add<RefinementStrategy, WrongRefinement>("wrong_refinement",
                                                    schema("refinement_strategy",
                                                           R"({"immersed_cells": {"level": 3}})"));
  registry.add<OutputWriter, WrongWriter>(
    "wrong_writer",
    schema("output_writer",
           R"({"probe": {"name": "a", "at": {"points": {"places": [[0.5, 0.5]]}}}})"));
  registry.add<ConstitutiveLaw, WrongLaw>(
    "wrong_law",
    schema("constitutive_law", R"({"neo_hookean": {"shear_modulus": 1.5, "stress_free": true}})"));
  registry.add<StructureForce, WrongForce>(
    "wrong_force",
    schema("structure_force", R"({"spring_network": {"stiffness": 2, "damping": 1}})"));
  registry.add<CouplingOperator, WrongCoupling>("wrong_coupling",
                                                schema("coupling_operator",
                                                       R"({"variational": {}})"));
}
