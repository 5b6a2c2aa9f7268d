// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/spaces.h>
#include <feib/testing/time_integrator_kit.h>

#include <gtest/gtest.h>

#include <cmath>
#include <map>

FEIB_TEST_TIME_INTEGRATOR("fe_be", 1);

namespace
{
  using namespace feib;

  /// A fluid that moves as it is told, whatever the load.
  class PrescribedFlow : public FluidSolver<2>
  {
  public:
    using Field = std::function<dealii::Tensor<1, 2>(const dealii::Point<2> &)>;

    explicit PrescribedFlow(const Field &field)
      : field(field)
    {}

    void
    initialize(EulerianSpace<2> &, ImplicitLoad<2> *) override
    {}

    Report
    advance(EulerianSpace<2> &space, const Step &step) override
    {
      load = step.load;
      for (unsigned int c = 0; c < space.cells().size(); ++c)
        for (unsigned int i = 0; i < 9; ++i)
          {
            const auto &cell = space.cells()[c];
            const dealii::Point<2> x(cell.lower[0] + cell.size[0] * (i % 3) / 2.,
                                     cell.lower[1] + cell.size[1] * (i / 3) / 2.);
            for (unsigned int a = 0; a < 2; ++a)
              space.velocity.local_element(space.velocity_dofs(c)[9 * a + i]) = field(x)[a];
          }
      return {};
    }

    void
    project(EulerianSpace<2> &, ImplicitLoad<2> *) override
    {}

    double
    density() const override
    {
      return 1;
    }

    double
    viscosity() const override
    {
      return .1;
    }

    Balance
    balance(const EulerianSpace<2> &) override
    {
      return {};
    }

    Field field;
    VelocityVector load;
  };

  const char *const open_box = "{\"cells\": [8, 8], \"boundary\": {\"x_min\": {\"outflow\": {}}, "
                               "\"x_max\": {\"outflow\": {}}, "
                               "\"y_min\": {\"outflow\": {}}, \"y_max\": {\"outflow\": {}}}}";

  ImmersedStructure<2>
  make_membrane()
  {
    ImmersedStructure<2> structure;
    structure.model = feib::testing::registry().create<StructureModel<2>>(
      "membrane",
      "{\"name\": \"circle\", \"mesh\": {\"closed_curve\": {\"length\": 1.2566370614359172, "
      "\"elements\": 40}}, \"initial_position\": [\"0.5+0.2*cos(s1/0.2)\", "
      "\"0.45+0.15*sin(s1/0.2)\"], "
      "\"law\": {\"anisotropic_linear\": {\"stiffness\": 3}}}");
    structure.motion = feib::testing::registry().create<CouplingOperator<2>>("variational");
    structure.nodes  = LagrangianPoints::nodes(structure.model->mesh().n_nodes());
    return structure;
  }

  struct Fixture
  {
    explicit Fixture(const PrescribedFlow::Field &field)
      : space(feib::testing::make_space<2>(open_box))
      , fluid(field)
      , system{*space, fluid, structures, timers}
      , scheme(feib::testing::registry().create<TimeIntegrator<2>>("fe_be"))
    {
      structures.push_back(make_membrane());
    }

    std::unique_ptr<EulerianSpace<2>> space;
    PrescribedFlow fluid;
    std::vector<ImmersedStructure<2>> structures;
    Timers timers;
    TimeIntegrator<2>::System system;
    std::unique_ptr<TimeIntegrator<2>> scheme;
  };
} // namespace


TEST(ForwardEulerBackwardEuler, RotationGrowsTheAreaByItsOwnFactor)
{
  // u = omega (-(y - 1/2), x - 1/2) is in the space; forward Euler motion is an exact similarity of
  // area factor 1 + omega^2 dt^2 (science of forward Euler, not of the mesh).
  const double omega = 3, dt = .02;
  Fixture f([&](const dealii::Point<2> &x) {
    return dealii::Tensor<1, 2>({-omega * (x[1] - .5), omega * (x[0] - .5)});
  });
  const StructureModel<2> &model = *f.structures[0].model;
  const double initial           = model.measure(model.positions);
  for (unsigned int n = 1; n <= 20; ++n)
    {
      f.scheme->step(f.system, (n - 1) * dt, dt);
      f.system.fluid.commit();
      EXPECT_NEAR(model.measure(model.positions) / initial,
                  std::pow(1 + omega * omega * dt * dt, n),
                  1e-12);
    }
}

TEST(ForwardEulerBackwardEuler, AreaBookkeeping)
{
  // A^{n+1} - A^n = dt/2 sum (X_i x U_{i+1} + U_i x X_{i+1}) + dt^2/2 sum U_i x U_{i+1}
  const double dt = .05;
  Fixture f([&](const dealii::Point<2> &x) {
    return dealii::Tensor<1, 2>({std::sin(3 * x[1]) + x[0] * x[0], x[0] * x[1] - .3});
  });
  const StructureModel<2> &model = *f.structures[0].model;
  const Positions<2> X           = model.positions;
  const double before            = model.measure(X);
  const auto report              = f.scheme->step(f.system, 0, dt);
  const auto cross = [](const auto &a, const auto &b) { return a[0] * b[1] - a[1] * b[0]; };
  double leak = 0, time_error = 0;
  for (unsigned int i = 0; i < X.size(); ++i)
    {
      const unsigned int j           = (i + 1) % X.size();
      const dealii::Tensor<1, 2> U_i = (model.positions[i] - X[i]) / dt,
                                 U_j = (model.positions[j] - X[j]) / dt;
      leak += dt / 2 * (cross(X[i], U_j) + cross(U_i, X[j]));
      time_error += dt * dt / 2 * cross(U_i, U_j);
    }
  EXPECT_GT(std::abs(leak), 1e-4);
  EXPECT_GT(std::abs(time_error), 1e-6);
  EXPECT_NEAR(model.measure(model.positions) - before, leak + time_error, 1e-15);
  EXPECT_NEAR(report.exchanges[0].leak, leak, 1e-15);
}

TEST(ForwardEulerBackwardEuler, ForceFromTheOldPositionsAndPowerIsExchangedExactly)
{
  Fixture f([](const dealii::Point<2> &x) {
    return dealii::Tensor<1, 2>({x[0] * x[0], .3 * x[1] - x[0]});
  });
  StructureModel<2> &model = *f.structures[0].model;
  const Positions<2> X     = model.positions;
  NodalField<2> force;
  model.load(X, force);
  const double dt   = .01;
  const auto report = f.scheme->step(f.system, 0, dt);
  double power = 0, scale = 0;
  for (unsigned int i = 0; i < X.size(); ++i)
    {
      const dealii::Tensor<1, 2> U = (model.positions[i] - X[i]) / dt;
      power += force[i] * U;
      scale += force[i].norm() * U.norm();
    }
  EXPECT_GT(std::abs(power), 1e-6 * scale);
  EXPECT_NEAR(f.fluid.load * f.space->velocity, power, 1e-12 * scale);
  EXPECT_NEAR(report.exchanges[0].power, power, 1e-12 * scale);
}

TEST(ForwardEulerBackwardEuler, EtaIsTheEstimateOfTheEnergyLaw)
{
  Fixture f([](const dealii::Point<2> &) { return dealii::Tensor<1, 2>(); });
  const StructureModel<2> &model = *f.structures[0].model;
  double L                       = 0;
  for (unsigned int i = 0; i < 40; ++i)
    L = std::max(L, model.positions[i].distance(model.positions[(i + 1) % 40]));
  const auto columns = f.scheme->diagnostics(f.system, .01);
  const std::map<std::string, double> values(columns.begin(), columns.end());
  const double h_s = 1.2566370614359172 / 40;
  EXPECT_DOUBLE_EQ(values.at("h_x"), .125);
  EXPECT_NEAR(values.at("h_s_circle"), h_s, 1e-12);
  EXPECT_NEAR(values.at("longest_edge_circle"), L, 1e-15);
  EXPECT_NEAR(values.at("kappa_circle"), 3, 1e-10);
  // m = 1, d = 2: kappa dt L / (h_s h_x)
  EXPECT_NEAR(values.at("eta_circle"), 3 * .01 * L / (h_s * .125), 1e-10);
  EXPECT_EQ(values.at("dt_limit_circle"), f.scheme->stability_limit(f.system).dt);
}
