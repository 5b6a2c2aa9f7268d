// SPDX-License-Identifier: LGPL-2.1-or-later
#include "operators/body_force.h"

#include "operators/cell_operators.h"

#include <feib/error.h>
#include <feib/failure.h>

#include <deal.II/base/quadrature_lib.h>

namespace feib
{
  namespace
  {
    /// Gauss rules of 4 points per direction, with a @p reconstruction of 8, so that a smooth
    /// gradient f does no work on R v beside round-off.
    template <int dim>
    VelocityVector
    load_of(const EulerianSpace<dim> &space,
            const dealii::Function<dim> &force,
            const Reconstruction<dim> *reconstruction)
    {
      constexpr unsigned int n_u = EulerianSpace<dim>::n_velocity;
      VelocityVector result      = space.make_velocity();
      const dealii::QGauss<dim> quadrature(reconstruction ? 8 : 4);
      struct Values
      {
        double of[dim][n_u];
      };
      std::vector<Values> tested(quadrature.size());
      for (unsigned int q = 0; q < quadrature.size(); ++q)
        velocity_values<dim>(reconstruction, quadrature.point(q), tested[q].of);
      std::vector<dealii::Point<dim>> points(quadrature.size());
      std::vector<dealii::Vector<double>> forces(quadrature.size(), dealii::Vector<double>(dim));
      for (unsigned int c = 0; c < space.cells().size(); ++c)
        {
          const auto &cell = space.cells()[c];
          const double det = cell_volume(cell.size);
          for (unsigned int q = 0; q < quadrature.size(); ++q)
            for (unsigned int a = 0; a < dim; ++a)
              points[q][a] = cell.lower[a] + cell.size[a] * quadrature.point(q)[a];
          force.vector_value_list(points, forces);
          double local[n_u] = {};
          for (unsigned int q = 0; q < quadrature.size(); ++q)
            for (unsigned int a = 0; a < dim; ++a)
              for (unsigned int i = 0; i < n_u; ++i)
                local[i] += det * quadrature.weight(q) * forces[q][a] * tested[q].of[a][i];
          for (unsigned int i = 0; i < n_u; ++i)
            result.local_element(space.velocity_dofs(c)[i]) += local[i];
        }
      result.compress(dealii::VectorOperation::add);
      return result;
    }
  } // namespace


  template <int dim>
  BodyForce<dim>::BodyForce(const Parameters &parameters)
    : reconstructs(parameters.string("reconstruction") != "none")
  {
    if (parameters.has("body_force"))
      {
        force  = parse_expressions<dim>(parameters, "body_force", dim, Variables::space_time);
        varies = depends_on_time(parameters, "body_force");
      }
  }


  template <int dim>
  Issues
  BodyForce<dim>::check(const EulerianSpace<dim> &space, const std::vector<double> &times)
  {
    Issues issues;
    for (const double t : times)
      if (force && issues.empty() && (t == times[0] || varies))
        {
          force->set_time(t);
          load_of<dim>(space, *force, nullptr);
          issues = force->not_finite(space.communicator());
        }
    return issues;
  }


  template <int dim>
  const VelocityVector &
  BodyForce<dim>::load(const EulerianSpace<dim> &space, const double time)
  {
    if (!varies && revision == space.revision())
      return present;
    force->set_time(time);
    if (reconstructs)
      {
        const Domain<dim> &box = space.domain();
        dealii::Tensor<1, dim> size;
        for (unsigned int a = 0; a < dim; ++a)
          size[a] = (box.upper[a] - box.lower[a]) / box.cells[a];
        const Reconstruction<dim> reconstruction(size); // the same for the cells of all levels
        present = load_of<dim>(space, *force, &reconstruction);
      }
    else
      present = load_of<dim>(space, *force, nullptr);
    if (const Issues issues = force->not_finite(space.communicator()); !issues.empty())
      throw Incurable(Error(issues).what());
    revision = space.revision();
    return present;
  }


  template class BodyForce<2>;
  template class BodyForce<3>;
} // namespace feib
