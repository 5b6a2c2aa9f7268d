// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/coupling_operator_kit.h>

#include <deal.II/fe/fe_values.h>
#include <deal.II/numerics/vector_tools.h>

#include <gtest/gtest.h>

FEIB_TEST_COUPLING_OPERATOR("variational")

namespace
{
  using namespace feib;

  /// A quadratic field is in the space, so J u is its value at every point, on any mesh.
  template <int dim>
  void
  check_exact_for_quadratics()
  {
    const auto space = feib::testing::make_space<dim>(
      dim == 2 ? "{\"cells\": [3, 5], \"lower\": [-1, 0], \"upper\": [2, 1], "
                 "\"boundary\": {\"x_min\": {\"outflow\": {}}, \"x_max\": "
                 "{\"outflow\": {}}, \"y_min\": {\"outflow\": {}}, "
                 "\"y_max\": {\"outflow\": {}}}}"
               : "{\"cells\": [2, 3, 2], \"lower\": [-1, 0, 0], \"upper\": "
                 "[2, 1, 1], \"boundary\": {\"x_min\": {\"outflow\": {}}, "
                 "\"x_max\": {\"outflow\": {}}, \"y_min\": {\"outflow\": "
                 "{}}, \"y_max\": {\"outflow\": {}}, \"z_min\": "
                 "{\"outflow\": {}}, \"z_max\": {\"outflow\": {}}}}");
    for (unsigned int i = 0; i < 2; ++i)
      feib::testing::refine_where(*space, [](const auto &x) { return x[0] > .4; });
    const auto field = [](const dealii::Point<dim> &x) {
      dealii::Tensor<1, dim> u;
      u[0] = 1 + x[0] * x[0] - 2 * x[0] * x[1];
      u[1] = x[1] * x[1] + 3 * x[0] - x[dim - 1];
      if (dim == 3)
        u[dim - 1] = x[0] * x[dim - 1] - .5;
      return u;
    };
    VelocityVector u = space->make_velocity();
    for (unsigned int c = 0; c < space->cells().size(); ++c)
      for (unsigned int i = 0; i < EulerianSpace<dim>::n_nodes; ++i)
        {
          dealii::Point<dim> x = space->cells()[c].lower;
          unsigned int rest    = i;
          for (unsigned int a = 0; a < dim; ++a, rest /= 3)
            x[a] += space->cells()[c].size[a] * (rest % 3) / 2.;
          for (unsigned int a = 0; a < dim; ++a)
            if (const auto dof = space->velocity_dofs(c)[a * EulerianSpace<dim>::n_nodes + i];
                dof < u.locally_owned_size())
              u.local_element(dof) = field(x)[a];
        }
    space->distribute(u, false);

    const LagrangianMesh<dim> mesh = feib::testing::make_simplex_mesh<dim>(dim, 6);
    Positions<dim> X(mesh.n_nodes());
    for (unsigned int i = 0; i < X.size(); ++i)
      for (unsigned int a = 0; a < dim; ++a)
        // Up to the very corners of the box.
        X[i][a] = space->domain().lower[a] +
                  (space->domain().upper[a] - space->domain().lower[a]) * mesh.nodes()[i][a];
    const auto coupling = feib::testing::registry().create<CouplingOperator<dim>>("variational");
    coupling->set_geometry(*space, mesh, X, LagrangianPoints::nodes(X.size()));
    NodalField<dim> U;
    coupling->interpolate(*space, u, U);
    for (unsigned int i = 0; i < X.size(); ++i)
      EXPECT_LT((U[i] - field(X[i])).norm(), 1e-12) << "at " << X[i];
  }
} // namespace

TEST(Variational, QuadraticFieldsAreReproduced)
{
  check_exact_for_quadratics<2>();
  check_exact_for_quadratics<3>();
}
