// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_structure_model_kit_h
#define feib_testing_structure_model_kit_h

#include <feib/schema.h>
#include <feib/structure_model.h>
#include <feib/testing/derivative.h>
#include <feib/testing/plugins.h>

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

namespace feib::testing
{
  /// One random vector per node, the same on all ranks.
  template <int dim>
  NodalField<dim>
  random_field(const unsigned int n, const double size, const unsigned int seed = 1)
  {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> random(-size, size);
    NodalField<dim> field(n);
    for (auto &vector : field)
      for (unsigned int i = 0; i < dim; ++i)
        vector[i] = random(generator);
    return field;
  }

  template <int dim>
  Positions<dim>
  moved(Positions<dim> X, const NodalField<dim> &dX, const double h = 1)
  {
    for (unsigned int i = 0; i < X.size(); ++i)
      X[i] += h * dX[i];
    return X;
  }

  /// The displacement of the load points when the nodes move by dX.
  template <int dim>
  NodalField<dim>
  at_points(const LagrangianPoints &points, const NodalField<dim> &dX)
  {
    const Positions<dim> x = points.positions(moved(Positions<dim>(dX.size()), dX));
    return NodalField<dim>(x.begin(), x.end());
  }

  template <int dim>
  NodalField<dim>
  load(const StructureModel<dim> &model, const Positions<dim> &X)
  {
    NodalField<dim> load;
    model.load(X, load);
    EXPECT_EQ(load.size(), model.load_points().size());
    return load;
  }

  template <int dim>
  double
  norm(const NodalField<dim> &field)
  {
    return std::sqrt(field * field);
  }

  /// What every structure model must keep, tried for each example of its schema. Include it in one
  /// source of a test program.
  class StructureModelKit : public ::testing::TestWithParam<std::string>
  {
  protected:
    /// Calls @p check with the model, and with its positions disturbed a little.
    template <typename Check>
    void
    for_each_example(const Check &check) const
    {
      bool found = false;
      for (const Registry::Entry &entry : registry().entries())
        if (entry.kind == StructureModel<2>::kind && entry.name == GetParam())
          {
            found = true;
            for (const std::string &example : Schema(entry.schema).examples())
              {
                SCOPED_TRACE(example);
                // An example is of one dimension, and refused in the other.
                refusal.clear();
                const bool in_2d = in_dimension<2>(example, check);
                const bool in_3d = in_dimension<3>(example, check);
                EXPECT_TRUE(in_2d || in_3d) << "no dimension accepts this example: " << refusal;
              }
          }
      EXPECT_TRUE(found) << "there is no structure model " << GetParam();
    }

  private:
    template <int dim, typename Check>
    bool
    in_dimension(const std::string &example, const Check &check) const
    {
      std::unique_ptr<StructureModel<dim>> model;
      try
        {
          model = registry().create<StructureModel<dim>>(GetParam(), example);
        }
      catch (const Error &error)
        {
          refusal += std::string(error.what()) + "; ";
          return false;
        }
      const auto shake =
        random_field<dim>(model->mesh().n_nodes(), .05 * model->mesh().diameter(), 7);
      check(*model, moved(model->positions, shake));
      return true;
    }

    mutable std::string refusal;
  };

  TEST_P(StructureModelKit, StartsAtTheInitialPositions)
  {
    for_each_example([](const auto &model, const auto &) {
      EXPECT_EQ(model.positions.size(), model.mesh().n_nodes());
      EXPECT_GT(model.measure(model.positions), 0);
      EXPECT_FALSE(model.name().empty());
    });
  }

  TEST_P(StructureModelKit, LoadAtNodesIsTheDerivativeOfTheEnergy)
  {
    for_each_example([](const auto &model, const auto &X) {
      if (model.load_points().nodes_per_point > 1)
        return;
      const auto dX =
        random_field<std::decay_t<decltype(X[0])>::dimension>(X.size(),
                                                              .1 * model.mesh().diameter());
      const double expected =
        derivative([&](const double h) { return -model.energy(moved(X, dX, h)); });
      EXPECT_NEAR(load(model, X) * dX, expected, 1e-9 * std::abs(model.energy(X)));
    });
  }

  TEST_P(StructureModelKit, LoadDerivativeIsTheDerivativeOfTheLoad)
  {
    for_each_example([](const auto &model, const auto &X) {
      constexpr int dim = std::decay_t<decltype(X[0])>::dimension;
      const auto dX     = random_field<dim>(X.size(), .1 * model.mesh().diameter());
      const auto test   = random_field<dim>(model.load_points().size(), 1, 2);
      NodalField<dim> dload;
      model.load_derivative(X, dX, dload);
      const double expected =
        derivative([&](const double h) { return load(model, moved(X, dX, h)) * test; });
      EXPECT_NEAR(dload * test, expected, 1e-9 * norm(load(model, X)));
    });
  }

  // The energy does not see translations and rotations, so forces and torques cancel.
  TEST_P(StructureModelKit, TangentHoldsTheEntriesOfTheLoadDerivative)
  {
    for_each_example([](const auto &model, const auto &X) {
      constexpr unsigned int dim = std::decay_t<decltype(X[0])>::dimension;
      const auto dX              = random_field<dim>(X.size(), 1., 3);
      NodalField<dim> expected;
      model.load_derivative(X, dX, expected);
      NodalField<dim> by_entries(model.load_points());
      std::map<std::pair<std::uint64_t, std::uint64_t>, double> entries;
      double largest = 0;
      for (const MatrixEntry &entry : model.tangent(X))
        {
          ASSERT_LT(entry.row, by_entries.size() * dim);
          ASSERT_LT(entry.column, X.size() * dim);
          by_entries[entry.row / dim][entry.row % dim] -=
            entry.value * dX[entry.column / dim][entry.column % dim];
          entries[{entry.row, entry.column}] += entry.value;
          largest = std::max(largest, std::abs(entry.value));
        }
      by_entries.compress(model.mesh().communicator());
      by_entries.update_ghosts();
      const double scale = norm(expected);
      for (unsigned int q = 0; q < expected.size(); ++q)
        for (unsigned int a = 0; a < dim; ++a)
          EXPECT_NEAR(by_entries[q][a], expected[q][a], 1e-12 * scale);
      // A conservative load has a symmetric tangent.
      if (model.conservative() && dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1)
        for (const auto &[place, value] : entries)
          {
            const double transposed = entries[{place.second, place.first}];
            EXPECT_NEAR(value, transposed, 1e-12 * largest);
          }
      // Only a linear load may say so.
      NodalField<dim> elsewhere;
      model.load_derivative(moved(X, random_field<dim>(X.size(), .01 * model.mesh().diameter(), 5)),
                            dX,
                            elsewhere);
      const double difference =
        expected.largest([&](const unsigned int q) { return (expected[q] - elsewhere[q]).norm(); });
      if (model.linear())
        {
          EXPECT_LT(difference, 1e-12 * scale);
        }
    });
  }

  /// What depends on velocities damps, and its entries are those of its derivative.
  TEST_P(StructureModelKit, ViscousLoadDampsAndHasItsEntries)
  {
    for_each_example([](const auto &model, const auto &X) {
      constexpr unsigned int dim = std::decay_t<decltype(X[0])>::dimension;
      const auto U               = random_field<dim>(X.size(), 1., 3);
      NodalField<dim> expected;
      model.viscous_load(X, U, expected);
      ASSERT_EQ(expected.size(), model.load_points().size());
      std::vector<double> by_entries(expected.size() * dim, 0.);
      for (const MatrixEntry &entry : model.viscous_tangent(X))
        {
          ASSERT_LT(entry.row, by_entries.size());
          ASSERT_LT(entry.column, X.size() * dim);
          by_entries[entry.row] -= entry.value * U[entry.column / dim][entry.column % dim];
        }
      dealii::Utilities::MPI::sum(by_entries, MPI_COMM_WORLD, by_entries);
      const double scale = norm(expected);
      EXPECT_EQ(scale > 0, model.viscous());
      for (unsigned int q = 0; q < expected.size(); ++q)
        for (unsigned int a = 0; a < dim; ++a)
          EXPECT_NEAR(by_entries[q * dim + a], expected[q][a], 1e-12 * scale);
      if (model.conservative())
        {
          EXPECT_LE(expected * at_points(model.load_points(), U), 0);
        }
    });
  }

  /// The state of laws, and what follows from it, is undone with the structure.
  TEST_P(StructureModelKit, StateIsUndone)
  {
    for_each_example([](auto &model, const auto &X) {
      constexpr unsigned int dim = std::decay_t<decltype(X[0])>::dimension;
      MemoryArchive before;
      before.start_writing();
      model.archive(before);
      const double energy = model.energy(X);
      const auto state    = model.state();
      model.update_state(moved(X, random_field<dim>(X.size(), .05 * model.mesh().diameter(), 7)));
      model.set_moment(.1, .1);
      for (const auto &[name, values] : model.state())
        EXPECT_EQ(values.size(), model.mesh().n_elements()) << name;
      before.start_reading();
      model.archive(before);
      EXPECT_EQ(model.energy(X), energy);
      EXPECT_EQ(model.state(), state);
    });
  }

  TEST_P(StructureModelKit, ExcessMassIsPositiveAndOneForEachNode)
  {
    for_each_example([](const auto &model, const auto &X) {
      EXPECT_EQ(model.velocities.size(), X.size());
      if (model.excess_mass().empty())
        return;
      EXPECT_EQ(model.excess_mass().size(), X.size());
      for (const double mass : model.excess_mass())
        EXPECT_GT(mass, 0);
    });
  }

  TEST_P(StructureModelKit, TotalForceAndTorqueVanish)
  {
    for_each_example([](const auto &model, const auto &X) {
      constexpr int dim = std::decay_t<decltype(X[0])>::dimension;
      const auto f      = load(model, X);
      const auto x      = model.load_points().positions(X);
      dealii::Tensor<1, dim> force;
      dealii::Tensor<2, dim> torque;
      for (unsigned int q = 0; q < f.size(); ++q)
        {
          force += f[q];
          torque += outer_product(x[q], f[q]) - outer_product(f[q], x[q]);
        }
      const double size = norm(f) * std::sqrt(1. * f.size());
      EXPECT_GT(size, 0);
      EXPECT_LT(force.norm(), 1e-13 * size);
      EXPECT_LT(torque.norm(), 1e-13 * size);
    });
  }

  TEST_P(StructureModelKit, EnergyIsTheSumOfItsDensity)
  {
    for_each_example([](const auto &model, const auto &X) {
      const std::vector<double> W = model.energy_density(X);
      ASSERT_EQ(W.size(), model.mesh().n_elements());
      double sum = 0;
      for (unsigned int e = 0; e < W.size(); ++e)
        sum += W[e] * model.mesh().elements()[e].measure;
      EXPECT_NEAR(sum, model.energy(X), 1e-12 * std::abs(sum));
    });
  }

  // kappa_max bounds the second derivative of the energy density.
  TEST_P(StructureModelKit, StiffnessBoundsTheTangent)
  {
    for_each_example([](const auto &model, const auto &X) {
      if (model.load_points().nodes_per_point > 1)
        return;
      constexpr int dim  = std::decay_t<decltype(X[0])>::dimension;
      const auto largest = model.stiffness(X);
      const double kappa = largest.reference;
      EXPECT_GT(kappa, 0);
      EXPECT_GT(largest.spatial, 0);
      for (unsigned int seed = 0; seed < 5; ++seed)
        {
          const auto dX = random_field<dim>(X.size(), 1, seed);
          NodalField<dim> dload;
          model.load_derivative(X, dX, dload);
          double gradient_squared = 0;
          for (const auto &element : model.mesh().elements())
            for (unsigned int i = 0; i < dim; ++i)
              {
                dealii::Tensor<1, dim> gradient;
                for (unsigned int k = 0; k <= model.mesh().structure_dim(); ++k)
                  gradient += dX[element.nodes[k]][i] * element.shape_gradients[k];
                gradient_squared += element.measure * gradient.norm_square();
              }
          EXPECT_LE(-(dload * dX), kappa * gradient_squared * (1 + 1e-12));
        }
    });
  }
} // namespace feib::testing

/// Runs the conformance kit for the structure model of that name.
#define FEIB_TEST_STRUCTURE_MODEL(name) FEIB_TEST_STRUCTURE_MODEL_(name, __LINE__)
#define FEIB_TEST_STRUCTURE_MODEL_(name, line) FEIB_TEST_STRUCTURE_MODEL__(name, line)
#define FEIB_TEST_STRUCTURE_MODEL__(name, line)                            \
  namespace feib::testing                                                  \
  {                                                                        \
    INSTANTIATE_TEST_SUITE_P(Line##line,                                   \
                             StructureModelKit,                            \
                             ::testing::Values(std::string(name)),         \
                             [](const auto &info) { return info.param; }); \
  }                                                                        \
  static_assert(true, "")

#endif
