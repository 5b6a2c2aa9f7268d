// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_fluid_trial_h
#define feib_testing_fluid_trial_h

#include <feib/fluid_solver.h>
#include <feib/testing/fields.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace feib::testing
{
  /// A drag on the fluid that is linear in its velocity, <F(u), v> = -factor (u, v), the integral
  /// taken at the nodes; or one that is not defined anywhere.
  template <int dim>
  class Drag : public ImplicitLoad<dim>
  {
  public:
    Drag(const EulerianSpace<dim> &space, const double factor, const bool defined = true)
      : weights(load_of(space,
                        [=](const dealii::Point<dim> &) {
                          dealii::Tensor<1, dim> all;
                          for (unsigned int a = 0; a < dim; ++a)
                            all[a] = factor;
                          return all;
                        }))
      , defined(defined)
    {}

    void
    evaluate(const VelocityVector &u, VelocityVector &load) override
    {
      if (!defined)
        throw RunFailure("the drag is not defined");
      for (unsigned int i = 0; i < load.locally_owned_size(); ++i)
        load.local_element(i) -= weights.local_element(i) * u.local_element(i);
    }

    void
    apply(VelocityVector &dst, const VelocityVector &du) const override
    {
      for (unsigned int i = 0; i < dst.locally_owned_size(); ++i)
        dst.local_element(i) += weights.local_element(i) * du.local_element(i);
    }

    bool
    linear() const override
    {
      return defined;
    }

    std::vector<typename ImplicitLoad<dim>::Product>
    matrix() const override
    {
      return {};
    }

  private:
    const VelocityVector weights;
    const bool defined;
  };


  /// A fluid in a partly refined box whose upper wall moves along itself, under a load.
  template <int dim>
  class FluidTrial
  {
  public:
    using Report = typename FluidSolver<dim>::Report;

    /// @p moving: whether the wall moves.
    FluidTrial(const std::string &name,
               const std::string &block,
               const bool moving           = true,
               const MPI_Comm communicator = MPI_COMM_WORLD)
      : space(make_space<dim>(box(moving), communicator))
      , fluid(registry().create<FluidSolver<dim>>(name, block))
    {
      refine_where(*space, [](const auto &x) { return x[0] < .5 && x[1] > .5; });
      fluid->initialize(*space);
      space->old_velocity = space->older_velocity = space->velocity;
    }

    /// A load that stirs the fluid.
    VelocityVector
    stirring(const double strength = 1) const
    {
      return load_of(*space, [&](const dealii::Point<dim> &x) {
        dealii::Tensor<1, dim> f;
        f[0] = strength * std::sin(5 * x[1]);
        f[1] = strength * (x[0] * x[dim - 1] - std::cos(4 * x[0]));
        return f;
      });
    }

    /// The next step of length dt, or as much of it as leaves @p beyond; not accepted yet.
    Report
    advance(const VelocityVector &load,
            ImplicitLoad<dim> *const implicit_load = nullptr,
            const double beyond                    = 0)
    {
      if (accepted)
        {
          space->older_velocity = space->old_velocity;
          space->old_velocity   = space->velocity;
          accepted              = false;
        }
      const double tau = dt - beyond;
      return fluid->advance(*space, {time + tau, tau, load, implicit_load, beyond});
    }

    void
    accept()
    {
      time += dt;
      space->old_dt = dt;
      space->set_time(time);
      fluid->commit();
      accepted = true;
    }

    /// A step under a load, and all that it says and leaves behind.
    std::vector<double>
    step_in_numbers()
    {
      const Report report = advance(stirring());
      accept();
      std::vector<double> result = {double(report.linear_iterations),
                                    double(report.nonlinear_iterations),
                                    report.dissipation,
                                    report.convection_power,
                                    report.boundary_power,
                                    report.body_force_power,
                                    report.increment_energy};
      result.insert(result.end(), space->velocity.begin(), space->velocity.end());
      result.insert(result.end(), space->pressure.begin(), space->pressure.end());
      return result;
    }

    void
    archive(Archive &archive)
    {
      archive("space", *space);
      archive("fluid", *fluid);
      archive("now", time);
      if (archive.reading())
        accepted = true;
    }

    /// The power rho/dt (u - u^n, u) of inertia.
    double
    inertial_power() const
    {
      double sum = 0;
      for_each_cell(*space, [&](const auto &, const auto &values, const auto &) {
        std::vector<dealii::Tensor<1, dim>> u(values.n_quadrature_points), old = u;
        const dealii::FEValuesExtractors::Vector all(0);
        values[all].get_function_values(space->velocity, u);
        values[all].get_function_values(space->old_velocity, old);
        for (unsigned int q = 0; q < u.size(); ++q)
          sum += values.JxW(q) * fluid->density() / dt * ((u[q] - old[q]) * u[q]);
      });
      return dealii::Utilities::MPI::sum(sum, space->communicator());
    }

    /// The fluxes out of cells, and their moments: |(div u, q)| for the pressure's basis, relative
    /// to what goes through their faces.
    double
    relative_divergence() const
    {
      double sum = 0, scale = 0;
      for_each_cell(*space, [&](const auto &cell, const auto &values, const auto &of_pressure) {
        std::vector<double> divergence(values.n_quadrature_points);
        std::vector<dealii::Tensor<1, dim>> u(values.n_quadrature_points);
        const dealii::FEValuesExtractors::Vector all(0);
        values[all].get_function_divergences(space->velocity, divergence);
        values[all].get_function_values(space->velocity, u);
        double flux = 0;
        for (unsigned int q = 0; q < u.size(); ++q)
          flux += values.JxW(q) * u[q].norm() / cell->diameter();
        scale += flux * flux;
        for (unsigned int i = 0; i < EulerianSpace<dim>::n_pressure; ++i)
          {
            double moment = 0;
            for (unsigned int q = 0; q < u.size(); ++q)
              moment += values.JxW(q) * of_pressure.shape_value(i, q) * divergence[q];
            sum += moment * moment;
          }
      });
      sum   = dealii::Utilities::MPI::sum(sum, space->communicator());
      scale = dealii::Utilities::MPI::sum(scale, space->communicator());
      return scale > 0 ? std::sqrt(sum / scale) : sum;
    }

    /// How far the velocity is from what the constraints say at the time of the space: values on
    /// walls, and those of nodes that hang.
    double
    distance_from_constraints() const
    {
      VelocityVector u = space->velocity;
      space->distribute(u, false);
      u.zero_out_ghost_values();
      VelocityVector given = space->velocity;
      given.zero_out_ghost_values();
      u -= given;
      return u.linfty_norm();
    }

    std::unique_ptr<EulerianSpace<dim>> space;
    std::unique_ptr<FluidSolver<dim>> fluid;
    double dt   = .05;
    double time = 0;

  private:
    static std::string
    box(const bool moving)
    {
      const std::string wall =
        dim == 2 ? "[\"sin(3*t) * x * (1-x)\", 0]" : "[\"sin(3*t) * x * (1-x) * z * (1-z)\", 0, 0]";
      return std::string("{\"cells\": ") + (dim == 2 ? "[4, 4]" : "[2, 2, 2]") +
             (moving ? ", \"boundary\": {\"y_max\": {\"velocity\": {\"value\": " + wall + "}}}}"
                     : "}");
    }

    bool accepted = true;
  };
} // namespace feib::testing

#endif
