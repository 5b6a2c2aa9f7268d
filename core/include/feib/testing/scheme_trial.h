// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_scheme_trial_h
#define feib_testing_scheme_trial_h

#include <feib/testing/trial.h>

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace feib::testing
{
  /// A membrane and a body with excess mass in a small box of fluid, and a scheme.
  template <int dim>
  class SchemeTrial : public Trial<dim>
  {
  public:
    /// @p settings: changes of the case below.
    SchemeTrial(const std::string &scheme,
                const std::string &block,
                Case::Settings settings     = {},
                const MPI_Comm communicator = MPI_COMM_WORLD)
      : Trial<dim>(description_of(scheme, block, std::move(settings)), communicator)
    {}

  private:
    static Case
    description_of(const std::string &scheme, const std::string &block, Case::Settings settings)
    {
      settings.emplace_back("/time/integrator", "{\"" + scheme + "\": " + block + "}");
      const std::string fluid =
        R"("fluid": {"navier_stokes": {"density": 1.2, "viscosity": 0.05, "tolerance": 1e-12}},
           "coupling": {"variational": {}}, "time": {"step": 0.01, "end": 1},)";
      const std::string in_2d = R"j("dimension": 2, "domain": {"cells": [8, 8]},
        "structures": [
          {"membrane": {"name": "membrane", "excess_density": 0.5,
            "mesh": {"closed_curve": {"length": 1, "elements": 12}},
            "initial_position": ["0.3 + 0.15 * cos(2*pi*s1)", "0.4 + 0.2 * sin(2*pi*s1)"],
            "law": {"anisotropic_linear": {"stiffness": 0.5}}}},
          {"hyperelastic": {"name": "body", "excess_density": 2,
            "mesh": {"rectangle": {"lower": [0.6, 0.5], "upper": [0.8, 0.7], "cells": [2, 2]}},
            "initial_position": ["0.7 + 1.2 * (s1 - 0.7) + 0.2 * (s2 - 0.6)", "s2"],
            "law": {"neo_hookean": {"shear_modulus": 2, "stress_free": true}}}}])j";
      const std::string in_3d = R"j("dimension": 3, "domain": {"cells": [3, 3, 3]},
        "structures": [
          {"membrane": {"name": "membrane",
            "mesh": {"sphere": {"centre": [0.3, 0.5, 0.5], "radius": 0.2, "refinements": 1}},
            "initial_position": ["s1", "0.5 + 1.2 * (s2 - 0.5)", "s3"],
            "law": {"neo_hookean": {"shear_modulus": 0.5}}}},
          {"hyperelastic": {"name": "body", "excess_density": 2,
            "mesh": {"box": {"lower": [0.6, 0.4, 0.4], "upper": [0.8, 0.6, 0.6],
                             "cells": [1, 1, 1]}},
            "initial_position": ["0.7 + 1.2 * (s1 - 0.7) + 0.2 * (s2 - 0.5)", "s2", "s3"],
            "law": {"neo_hookean": {"shear_modulus": 2, "stress_free": true}}}}])j";
      return Case("{" + fluid + (dim == 2 ? in_2d : in_3d) + "}", "kit", registry(), settings);
    }
  };


  /// A setting of the case in two dimensions: the body is viscous, softens and pulls, so that a
  /// scheme must take its state and time along.
  inline Case::Settings
  inelastic_body()
  {
    return {{"/structures/1/hyperelastic/law",
             R"j({"kelvin_voigt": {"viscosity": 0.05, "law":
                  {"active_fibre": {"tension": "0.3 + 5*t", "fibres": [[1, 0]], "law":
                   {"mullins_damage": {"r": 1.5, "m": 0.02, "law":
                    {"neo_hookean": {"shear_modulus": 2, "stress_free": true}}}}}}}})j"}};
  }


  /// The fluid solver of a trial, which gives up in a call of advance() when it is told to.
  template <int dim>
  class FailingFluid : public FluidSolver<dim>
  {
  public:
    using Base = FluidSolver<dim>;

    explicit FailingFluid(std::unique_ptr<Base> fluid)
      : fluid(std::move(fluid))
    {}

    typename Base::Report
    advance(EulerianSpace<dim> &space, const typename Base::Step &step) override
    {
      const auto report = fluid->advance(space, step);
      if (++n_calls == failing_call)
        throw RunFailure("told to fail");
      return report;
    }

    void
    initialize(EulerianSpace<dim> &space, ImplicitLoad<dim> *inertia) override
    {
      fluid->initialize(space, inertia);
    }

    void
    commit() override
    {
      fluid->commit();
    }

    void
    archive(Archive &archive) override
    {
      fluid->archive(archive);
    }

    void
    project(EulerianSpace<dim> &space, ImplicitLoad<dim> *inertia) override
    {
      fluid->project(space, inertia);
    }

    double
    density() const override
    {
      return fluid->density();
    }

    double
    viscosity() const override
    {
      return fluid->viscosity();
    }

    typename Base::Balance
    balance(const EulerianSpace<dim> &space) override
    {
      return fluid->balance(space);
    }

    unsigned int n_calls = 0, failing_call = 0; // the first is 1

  private:
    std::unique_ptr<Base> fluid;
  };


  /// All that a step says and leaves behind, to be compared bit by bit.
  template <int dim>
  std::vector<double>
  step_in_numbers(Trial<dim> &trial)
  {
    const auto report          = trial.step();
    std::vector<double> result = {double(report.linear_iterations),
                                  double(report.nonlinear_iterations),
                                  double(report.geometry_iterations),
                                  report.dissipated,
                                  report.convected,
                                  report.boundary_work,
                                  report.body_work,
                                  report.numerical,
                                  report.unexplained,
                                  report.displacement_error};
    for (const auto &exchange : report.exchanges)
      result.insert(result.end(),
                    {exchange.power, exchange.leak, exchange.inelastic, exchange.force[0]});
    for (const auto &structure : trial.structures)
      for (unsigned int i = 0; i < structure.model->positions.size(); ++i)
        for (unsigned int a = 0; a < dim; ++a)
          result.insert(result.end(),
                        {structure.model->positions[i][a], structure.model->velocities[i][a]});
    result.insert(result.end(), trial.space.velocity.begin(), trial.space.velocity.end());
    result.insert(result.end(), trial.space.pressure.begin(), trial.space.pressure.end());
    return result;
  }
} // namespace feib::testing

#endif
