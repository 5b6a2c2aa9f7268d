// SPDX-License-Identifier: LGPL-2.1-or-later
#include "operators/boundary_terms.h"

#include <feib/cross_product.h>
#include <feib/error.h>
#include <feib/failure.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  template <int dim>
  BoundaryTerms<dim>::BoundaryTerms()
  {
    const dealii::QGauss<dim - 1> quadrature(4);
    for (unsigned int q = 0; q < n_q; ++q)
      {
        weights[q] = quadrature.weight(q);
        for (unsigned int f = 0; f < 2 * dim; ++f)
          {
            for (unsigned int a = 0, k = 0; a < dim; ++a)
              points[f][q][a] = a == f / 2 ? f % 2 : quadrature.point(q)[k++];
            EulerianSpace<dim>::shape_values(points[f][q], phi[f][q]);
          }
      }
  }


  template <int dim>
  void
  BoundaryTerms<dim>::reinit(const EulerianSpace<dim> &space)
  {
    check_parts(space);
    find_prescribed(space);
  }


  template <int dim>
  void
  BoundaryTerms<dim>::check_parts(const EulerianSpace<dim> &space)
  {
    // On the first mesh none is absent; where cells change, the centres of their faces do.
    const auto &conditions = space.domain().conditions;
    std::vector<unsigned int> n_faces(conditions.size(), 0);
    for (const Face &face : space.boundary_faces())
      ++n_faces[face.condition];
    dealii::Utilities::MPI::sum(n_faces, space.communicator(), n_faces);
    for (unsigned int i = 0; i < conditions.size(); ++i)
      if (conditions[i].where && n_faces[i] == 0)
        throw RunFailure("the condition \"" + conditions[i].name + "\" (" + conditions[i].pointer +
                         ") holds nowhere any more: on the mesh as it is now the centre of no "
                         "cell's face is in this part; let the part end between cells");
  }


  template <int dim>
  void
  BoundaryTerms<dim>::find_prescribed(const EulerianSpace<dim> &space)
  {
    const Domain<dim> &box     = space.domain();
    const unsigned int n_owned = space.velocity.locally_owned_size();
    std::vector<bool> seen(n_owned, false);
    prescribed.clear();
    for (const Face &face : space.boundary_faces())
      for (unsigned int i = 0; i < n; ++i)
        {
          const auto &cell = space.cells()[face.cell];
          dealii::Point<dim> x;
          bool on_face      = true;
          unsigned int rest = i;
          for (unsigned int a = 0; a < dim; ++a, rest /= 3)
            {
              x[a] = cell.lower[a] + cell.size[a] * (rest % 3) / 2.;
              if (a == face.face / 2)
                on_face = rest % 3 == (face.face % 2 == 0 ? 0 : 2);
            }
          const unsigned int first = space.velocity_dofs(face.cell)[i];
          if (!on_face || first >= n_owned || seen[first])
            continue;
          seen[first] = true;
          // The conditions that meet here, in the order in which they win.
          const auto share = space.lattice().share(space.lattice().nearest(x));
          std::vector<unsigned int> conditions;
          for (unsigned int f = 0; f < 2 * dim; ++f)
            if (!box.periodic(f / 2) && share[f / 2] == f % 2)
              conditions.push_back(box.condition_at_node(f, box.place(share)));
          std::stable_sort(conditions.begin(),
                           conditions.end(),
                           [&](const unsigned int a, const unsigned int b) {
                             return box.conditions[a].kind < box.conditions[b].kind;
                           });
          for (unsigned int a = 0; a < dim; ++a)
            for (const unsigned int c : conditions)
              if (box.conditions[c].prescribes(a))
                {
                  prescribed.push_back({space.velocity_dofs(face.cell)[a * n + i], a, c, x});
                  break;
                }
        }
  }


  template <int dim>
  dealii::Point<dim>
  BoundaryTerms<dim>::place(const EulerianSpace<dim> &space,
                            const Face &face,
                            const unsigned int q) const
  {
    const auto &cell     = space.cells()[face.cell];
    dealii::Point<dim> x = cell.lower;
    for (unsigned int a = 0; a < dim; ++a)
      x[a] += cell.size[a] * points[face.face][q][a];
    return x;
  }


  template <int dim>
  double
  BoundaryTerms<dim>::weight(const EulerianSpace<dim> &space,
                             const Face &face,
                             const unsigned int q) const
  {
    double result = weights[q];
    for (unsigned int a = 0; a < dim; ++a)
      if (a != face.face / 2)
        result *= space.cells()[face.cell].size[a];
    return result;
  }


  template <int dim>
  dealii::Tensor<1, dim>
  BoundaryTerms<dim>::traction(const BoundaryCondition<dim> &condition,
                               const dealii::Point<dim> &x,
                               const double pressure)
  {
    dealii::Tensor<1, dim> result;
    if (condition.traction)
      for (unsigned int a = 0; a < dim; ++a)
        result[a] = condition.traction->value(x, a);
    else if (condition.pressure || condition.regulated())
      result[condition.normal()] =
        -condition.outward() * (condition.pressure ? condition.pressure->value(x) : pressure);
    return result;
  }


  template <int dim>
  bool
  BoundaryTerms<dim>::exists(const Domain<dim> &box)
  {
    for (const auto &condition : box.conditions)
      if (condition.traction || condition.pressure || condition.regulated())
        return true;
    return false;
  }


  template <int dim>
  void
  BoundaryTerms<dim>::set_time(const Domain<dim> &box, const double time)
  {
    for (const auto &condition : box.conditions)
      for (const auto *function : {&condition.traction, &condition.pressure, &condition.flux})
        if (*function)
          (*function)->set_time(time);
  }


  template <int dim>
  Issues
  BoundaryTerms<dim>::not_finite(const EulerianSpace<dim> &space)
  {
    Issues issues;
    for (const auto &condition : space.domain().conditions)
      for (const auto *function : {&condition.traction, &condition.pressure, &condition.flux})
        if (*function)
          for (const Issue &issue : (*function)->not_finite(space.communicator()))
            issues.push_back(issue);
    return issues;
  }


  template <int dim>
  Issues
  BoundaryTerms<dim>::check(const EulerianSpace<dim> &space, const std::vector<double> &times)
  {
    const BoundaryTerms<dim> terms;
    Issues issues;
    for (const double t : times)
      if (issues.empty())
        {
          set_time(space.domain(), t);
          for (const Face &face : space.boundary_faces())
            for (unsigned int q = 0; q < n_q; ++q)
              traction(space.domain().conditions[face.condition], terms.place(space, face, q), 0.);
          for (const auto &condition : space.domain().conditions)
            if (condition.flux)
              condition.flux->value(dealii::Point<dim>());
          issues = not_finite(space);
        }
    return issues;
  }


  template <int dim>
  VelocityVector
  BoundaryTerms<dim>::load(const EulerianSpace<dim> &space,
                           const double time,
                           const std::vector<double> &pressures) const
  {
    VelocityVector result = space.make_velocity();
    set_time(space.domain(), time);
    for (const Face &face : space.boundary_faces())
      if (const auto &condition = space.domain().conditions[face.condition]; condition.open())
        for (unsigned int q = 0; q < n_q; ++q)
          {
            const dealii::Tensor<1, dim> force =
              weight(space, face, q) *
              traction(condition, place(space, face, q), pressures[face.condition]);
            for (unsigned int a = 0; a < dim; ++a)
              for (unsigned int i = 0; i < n; ++i)
                result.local_element(space.velocity_dofs(face.cell)[a * n + i]) +=
                  force[a] * phi[face.face][q][i];
          }
    if (const Issues issues = not_finite(space); !issues.empty())
      throw Incurable(Error(issues).what());
    result.compress(dealii::VectorOperation::add);
    return result;
  }


  template <int dim>
  VelocityVector
  BoundaryTerms<dim>::unit_load(const EulerianSpace<dim> &space, const unsigned int condition) const
  {
    VelocityVector result     = space.make_velocity();
    const unsigned int normal = space.domain().conditions[condition].normal();
    const double outward      = space.domain().conditions[condition].outward();
    for (const Face &face : space.boundary_faces())
      if (face.condition == condition)
        for (unsigned int q = 0; q < n_q; ++q)
          for (unsigned int i = 0; i < n; ++i)
            result.local_element(space.velocity_dofs(face.cell)[normal * n + i]) -=
              outward * weight(space, face, q) * phi[face.face][q][i];
    result.compress(dealii::VectorOperation::add);
    return result;
  }


  template <int dim>
  dealii::Tensor<1, dim>
  BoundaryTerms<dim>::velocity(const EulerianSpace<dim> &space,
                               const VelocityVector &u,
                               const Face &face,
                               const unsigned int q) const
  {
    dealii::Tensor<1, dim> result;
    for (unsigned int a = 0; a < dim; ++a)
      for (unsigned int i = 0; i < n; ++i)
        result[a] +=
          phi[face.face][q][i] * u.local_element(space.velocity_dofs(face.cell)[a * n + i]);
    return result;
  }


  template <int dim>
  std::vector<double>
  BoundaryTerms<dim>::fluxes(const EulerianSpace<dim> &space, const VelocityVector &u) const
  {
    u.update_ghost_values();
    std::vector<double> result(space.domain().conditions.size(), 0.);
    for (const Face &face : space.boundary_faces())
      {
        const auto &condition = space.domain().conditions[face.condition];
        for (unsigned int q = 0; q < n_q && !condition.tight; ++q)
          result[face.condition] += condition.outward() * weight(space, face, q) *
                                    velocity(space, u, face, q)[condition.normal()];
      }
    dealii::Utilities::MPI::sum(result, space.communicator(), result);
    return result;
  }


  template <int dim>
  std::vector<typename BoundaryTerms<dim>::Exchange>
  BoundaryTerms<dim>::exchange(const EulerianSpace<dim> &space,
                               VelocityVector reaction,
                               const double time,
                               const std::vector<double> &pressures) const
  {
    const auto &conditions = space.domain().conditions;
    std::vector<Exchange> result(conditions.size());
    std::vector<double> areas(conditions.size(), 0.), flux = fluxes(space, space.velocity);
    space.condense_continuity(reaction);
    for (const Prescribed &at : prescribed)
      {
        Exchange &exchange = result[at.condition];
        dealii::Tensor<1, dim> force;
        force[at.component] = -reaction.local_element(at.unknown);
        exchange.power += force[at.component] * space.velocity.local_element(at.unknown);
        exchange.force += force;
        exchange.torque += cross_product<dim>(at.place, force);
      }
    set_time(space.domain(), time);
    for (const Face &face : space.boundary_faces())
      {
        const auto &condition = conditions[face.condition];
        Exchange &exchange    = result[face.condition];
        const double *p[dim + 1];
        for (unsigned int k = 0; k <= dim; ++k)
          p[k] = space.pressure.begin() + space.pressure_dofs(face.cell)[k];
        for (unsigned int q = 0; q < n_q; ++q)
          {
            const double w = weight(space, face, q);
            areas[face.condition] += w;
            // The functions of the pressure are orthonormal: 1, sqrt(3) (2 x - 1), ...
            exchange.pressure +=
              w * (*p[0] + std::sqrt(3.) * condition.outward() * *p[1 + condition.normal()]);
            if (!condition.open())
              continue;
            const dealii::Point<dim> x = place(space, face, q);
            const auto force           = w * traction(condition, x, pressures[face.condition]);
            exchange.power += force * velocity(space, space.velocity, face, q);
            exchange.force += force;
            exchange.torque += cross_product<dim>(x, force);
          }
      }
    using dealii::Utilities::MPI::sum;
    const MPI_Comm communicator = space.communicator();
    sum(areas, communicator, areas);
    for (unsigned int i = 0; i < result.size(); ++i)
      {
        result[i].flux     = flux[i];
        result[i].power    = sum(result[i].power, communicator);
        result[i].force    = sum(result[i].force, communicator);
        result[i].torque   = sum(result[i].torque, communicator);
        result[i].pressure = sum(result[i].pressure, communicator) / std::max(areas[i], 1e-300);
      }
    return result;
  }


  template class BoundaryTerms<2>;
  template class BoundaryTerms<3>;
} // namespace feib
