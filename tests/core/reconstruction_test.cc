// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/reconstruction.h>
#include <feib/testing/spaces.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/lac/full_matrix.h>

#include <gtest/gtest.h>

#include <random>

namespace
{
  using namespace feib;

  template <int dim>
  dealii::Tensor<1, dim>
  cell_size()
  {
    dealii::Tensor<1, dim> size; // no cube
    for (unsigned int a = 0; a < dim; ++a)
      size[a] = 1. / (a + 2);
    return size;
  }

  /// R v at a place of the unit cell.
  template <int dim>
  dealii::Tensor<1, dim>
  evaluate(const Reconstruction<dim> &R, const dealii::Point<dim> &unit, const double *v)
  {
    double weights[dim][EulerianSpace<dim>::n_velocity];
    R.weights(unit, weights);
    dealii::Tensor<1, dim> result;
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int j = 0; j < EulerianSpace<dim>::n_velocity; ++j)
        result[a] += weights[a][j] * v[j];
    return result;
  }

  template <int dim>
  dealii::Tensor<1, dim>
  evaluate_plain(const dealii::Point<dim> &unit, const double *v)
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    double values[n];
    EulerianSpace<dim>::shape_values(unit, values);
    dealii::Tensor<1, dim> result;
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int i = 0; i < n; ++i)
        result[a] += values[i] * v[a * n + i];
    return result;
  }

  /// The divergence of a field that is cubic in each direction, exactly: from four values along
  /// each.
  template <int dim, class Field>
  double
  divergence(const Field &field, const dealii::Point<dim> &unit, const dealii::Tensor<1, dim> &size)
  {
    constexpr double places[4] = {0, 1 / 3., 2 / 3., 1};
    double sum                 = 0;
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int k = 0; k < 4; ++k)
        {
          double derivative = 0; // of Lagrange's polynomial k
          for (unsigned int l = 0; l < 4; ++l)
            if (l != k)
              {
                double product = 1 / (places[k] - places[l]);
                for (unsigned int m = 0; m < 4; ++m)
                  if (m != k && m != l)
                    product *= (unit[a] - places[m]) / (places[k] - places[m]);
                derivative += product;
              }
          dealii::Point<dim> x = unit;
          x[a]                 = places[k];
          sum += derivative / size[a] * field(x)[a];
        }
    return sum;
  }

  template <int dim>
  void
  check_identities()
  {
    SCOPED_TRACE("dim " + std::to_string(dim));
    const dealii::Tensor<1, dim> size = cell_size<dim>();
    const Reconstruction<dim> R(size);
    std::mt19937 random(dim);
    std::uniform_real_distribution<double> uniform(-1, 1), inside(0, 1);
    double v[EulerianSpace<dim>::n_velocity];
    for (double &value : v)
      value = uniform(random);

    const auto point = [&] {
      dealii::Point<dim> x;
      for (unsigned int a = 0; a < dim; ++a)
        x[a] = inside(random);
      return x;
    };

    // The normal trace is that of v; the tangential one is not.
    double tangential = 0;
    for (unsigned int face = 0; face < 2 * dim; ++face)
      for (unsigned int i = 0; i < 5; ++i)
        {
          dealii::Point<dim> x  = point();
          x[face / 2]           = face % 2;
          const auto difference = evaluate(R, x, v) - evaluate_plain<dim>(x, v);
          EXPECT_LT(std::abs(difference[face / 2]), 1e-13);
          tangential = std::max(tangential, difference.norm());
        }
    EXPECT_GT(tangential, 1e-2);

    // The divergence is the projection of div v on P1, whose orthogonal basis is 1, 2 x_a - 1.
    const dealii::QGauss<dim> gauss(4);
    double coefficients[dim + 1] = {};
    for (unsigned int q = 0; q < gauss.size(); ++q)
      {
        const double value =
          divergence<dim>([&](const auto &x) { return evaluate_plain<dim>(x, v); },
                          gauss.point(q),
                          size);
        coefficients[0] += gauss.weight(q) * value;
        for (unsigned int a = 0; a < dim; ++a)
          coefficients[a + 1] += 3 * gauss.weight(q) * (2 * gauss.point(q)[a] - 1) * value;
      }
    double scale = 0, worst = 0;
    for (const double coefficient : coefficients)
      scale += std::abs(coefficient);
    for (unsigned int i = 0; i < 20; ++i)
      {
        const dealii::Point<dim> x = point();
        double expected            = coefficients[0];
        for (unsigned int a = 0; a < dim; ++a)
          expected += coefficients[a + 1] * (2 * x[a] - 1);
        const double found =
          divergence<dim>([&](const auto &y) { return evaluate(R, y, v); }, x, size);
        worst = std::max(worst, std::abs(found - expected) / scale);
      }
    std::cout << "dim " << dim << ": relative error of the divergence " << worst << std::endl;
    EXPECT_GT(scale, 1);
    EXPECT_LT(worst, 1e-13);

    // Quadratic fields stay as they are.
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int b = 0; b < dim; ++b)
        {
          const auto quadratic = [&](const dealii::Point<dim> &x) {
            dealii::Tensor<1, dim> result;
            result[0] = x[a] * x[b];
            result[dim - 1] += 2 * x[a] - x[b] * x[b];
            return result;
          };
          constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
          for (unsigned int i = 0; i < n; ++i)
            {
              dealii::Point<dim> node;
              unsigned int rest = i;
              for (unsigned int c = 0; c < dim; ++c, rest /= 3)
                node[c] = rest % 3 / 2.;
              for (unsigned int c = 0; c < dim; ++c)
                v[c * n + i] = quadratic(node)[c];
            }
          const dealii::Point<dim> x = point();
          EXPECT_LT((evaluate(R, x, v) - quadratic(x)).norm(), 1e-13);
        }
  }

  /// R v - v is the smallest correction: orthogonal to all fields of RT_[2] without divergence and
  /// normal trace, which are the curls of bubbles.
  void
  check_smallest_correction()
  {
    const dealii::Tensor<1, 2> size = cell_size<2>();
    const Reconstruction<2> R(size);
    const dealii::QGauss<2> gauss(6);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform(-1, 1);
    double v[EulerianSpace<2>::n_velocity];
    for (double &value : v)
      value = uniform(random);
    // Stream functions b(x) b(y) x^i y^j, b = x (1-x), i, j <= 1.
    for (unsigned int i = 0; i < 2; ++i)
      for (unsigned int j = 0; j < 2; ++j)
        {
          double product = 0, square = 0;
          for (unsigned int q = 0; q < gauss.size(); ++q)
            {
              const double x = gauss.point(q)[0], y = gauss.point(q)[1];
              const double f = std::pow(x, 1 + i) * (1 - x), g = std::pow(y, 1 + j) * (1 - y);
              const double df = (1 + i) * std::pow(x, i) * (1 - x) - std::pow(x, 1 + i);
              const double dg = (1 + j) * std::pow(y, j) * (1 - y) - std::pow(y, 1 + j);
              const auto correction =
                evaluate(R, gauss.point(q), v) - evaluate_plain<2>(gauss.point(q), v);
              product += gauss.weight(q) *
                         (correction[0] * f * dg / size[1] - correction[1] * df / size[0] * g);
              square += gauss.weight(q) * correction.norm_square();
            }
          EXPECT_GT(square, 1e-2);
          EXPECT_NEAR(product, 0, 1e-14);
        }
  }

  /// On a refined mesh the normal component of R u is continuous, across hanging faces too.
  template <int dim>
  void
  check_normal_continuity()
  {
    SCOPED_TRACE("dim " + std::to_string(dim));
    const auto space =
      feib::testing::make_space<dim>(dim == 2 ? "{\"cells\": [4, 3]}" : "{\"cells\": [2, 3, 2]}");
    for (unsigned int i = 0; i < 2; ++i)
      feib::testing::refine_where(*space, [](const auto &x) { return x[0] + x[1] < .8; });
    VelocityVector u = space->make_velocity();
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (unsigned int i = 0; i < u.locally_owned_size(); ++i)
      u.local_element(i) = uniform(random);
    space->distribute(u, true);

    const Reconstruction<dim> R(space->cells()[0].size);
    const auto value = [&](const unsigned int cell, const dealii::Point<dim> &unit) {
      double v[EulerianSpace<dim>::n_velocity];
      for (unsigned int j = 0; j < EulerianSpace<dim>::n_velocity; ++j)
        v[j] = u.local_element(space->velocity_dofs(cell)[j]);
      return evaluate(R, unit, v);
    };
    unsigned int hanging = 0;
    for (unsigned int c = 0; c < space->cells().size(); ++c)
      for (unsigned int face = 0; face < 2 * dim; ++face)
        {
          const auto &cell     = space->cells()[c];
          const unsigned int a = face / 2;
          dealii::Point<dim> unit, other;
          for (unsigned int b = 0; b < dim; ++b)
            unit[b] = b == a ? face % 2 : std::abs(uniform(random));
          dealii::Point<dim> beyond = cell.lower;
          for (unsigned int b = 0; b < dim; ++b)
            beyond[b] += unit[b] * cell.size[b];
          beyond[a] += (face % 2 ? 1e-6 : -1e-6) * cell.size[a];
          const unsigned int neighbour = space->forest().locate(beyond, other);
          if (neighbour == CartesianForest<dim>::not_here)
            continue;
          hanging += space->cells()[neighbour].level != cell.level;
          other[a] = 1 - face % 2;
          EXPECT_NEAR(value(c, unit)[a], value(neighbour, other)[a], 1e-12);
        }
    EXPECT_GT(dealii::Utilities::MPI::sum(hanging, MPI_COMM_WORLD), 10u);
  }
} // namespace

TEST(Reconstruction, KeepsNormalTraceAndProjectsDivergence)
{
  check_identities<2>();
  check_identities<3>();
}

TEST(Reconstruction, CorrectionIsTheSmallest)
{
  check_smallest_correction();
}

TEST(Reconstruction, NormalComponentIsContinuousAcrossHangingFaces)
{
  check_normal_continuity<2>();
  check_normal_continuity<3>();
}
