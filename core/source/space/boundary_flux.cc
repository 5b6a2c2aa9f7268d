// SPDX-License-Identifier: LGPL-2.1-or-later
#include "boundary_flux.h"

#include "cell_order.h"

#include <feib/message.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace feib
{
  namespace
  {
    /// The flux of one face by Gauss rules on equal pieces.
    template <int dim>
    BoundaryFlux
    face_flux(const Domain<dim> &box, const unsigned int f, const unsigned int n_points)
    {
      constexpr unsigned int most_pieces = 64;
      const unsigned int a               = f / 2;
      std::array<unsigned int, dim> n{};
      unsigned int n_pieces = 1;
      double area           = 1; // of a piece
      for (unsigned int b = 0; b < dim; ++b)
        if (b != a)
          {
            n[b] = std::min(box.cells[b], most_pieces);
            n_pieces *= n[b];
            area *= (box.upper[b] - box.lower[b]) / n[b];
          }
      const dealii::QGauss<dim - 1> gauss(n_points);
      const double outward = f % 2 == 0 ? -1. : 1.;
      BoundaryFlux result;
      for (unsigned int piece = 0; piece < n_pieces; ++piece)
        for (unsigned int q = 0; q < gauss.size(); ++q)
          {
            dealii::Point<dim> x;
            unsigned int rest = piece, k = 0;
            for (unsigned int b = 0; b < dim; ++b)
              if (b == a)
                x[b] = f % 2 == 0 ? box.lower[b] : box.upper[b];
              else
                {
                  x[b] = box.lower[b] +
                         (box.upper[b] - box.lower[b]) * (rest % n[b] + gauss.point(q)[k++]) / n[b];
                  rest /= n[b];
                }
            const auto &velocity = box.conditions[box.condition_at(f, x)].velocity;
            const double flux =
              velocity ? outward * area * gauss.weight(q) * velocity->value(x, a) : 0.;
            result.net += flux;
            result.gross += std::abs(flux);
          }
      return result;
    }
  } // namespace


  template <int dim>
  BoundaryFlux
  interpolated_flux(const dealii::DoFHandler<dim> &handler,
                    const Domain<dim> &box,
                    const dealii::AffineConstraints<double> &constraints)
  {
    static constexpr double simpson[] = {1. / 6, 4. / 6, 1. / 6};
    const auto &fe                    = handler.get_fe();
    std::vector<dealii::types::global_dof_index> indices(fe.n_dofs_per_cell());
    double net = 0, gross = 0;
    using Mesh = dealii::parallel::distributed::Triangulation<dim>;
    for (const auto &ordered :
         cells_in_order(dynamic_cast<const Mesh &>(handler.get_triangulation())))
      if (const auto cell = in_handler(ordered, handler); cell->at_boundary())
        for (unsigned int f = 0; f < 2 * dim; ++f)
          if (cell->at_boundary(f) && !box.periodic(f / 2))
            {
              cell->get_dof_indices(indices);
              for (unsigned int i = 0; i < indices.size(); ++i)
                {
                  const auto [component, node] = fe.system_to_component_index(i);
                  if (component != f / 2 || !fe.has_support_on_face(i, f))
                    continue;
                  const dealii::Point<dim> unit = fe.unit_support_point(i);
                  double weight                 = f % 2 == 0 ? -1. : 1.;
                  for (unsigned int b = 0; b < dim; ++b)
                    if (b != f / 2)
                      weight *= cell->extent_in_direction(b) * simpson[std::lround(2 * unit[b])];
                  const double flux = weight * constraints.get_inhomogeneity(indices[i]);
                  net += flux;
                  gross += std::abs(flux);
                }
            }
    const MPI_Comm communicator = handler.get_communicator();
    return {dealii::Utilities::MPI::sum(net, communicator),
            dealii::Utilities::MPI::sum(gross, communicator)};
  }


  template <int dim>
  BoundaryFlux
  prescribed_flux(const Domain<dim> &box)
  {
    // All ranks do the same. Where values jump, the two rules differ.
    BoundaryFlux result;
    for (unsigned int f = 0; f < 2 * dim; ++f)
      if (!box.periodic(f / 2))
        {
          const BoundaryFlux fine = face_flux(box, f, 8), coarse = face_flux(box, f, 5);
          result.net += fine.net;
          result.gross += fine.gross;
          result.error += std::abs(fine.net - coarse.net);
        }
    return result;
  }


  template <int dim>
  Issues
  unbalanced_flux(const Domain<dim> &box,
                  const BoundaryFlux &interpolated,
                  const double t,
                  const MPI_Comm communicator)
  {
    // Numbers in cases are given with four digits or more.
    constexpr double tolerated = 1e-4;
    if (std::abs(interpolated.net) <= tolerated * interpolated.gross)
      return {};
    const BoundaryFlux flux = prescribed_flux(box);
    for (const auto &condition : box.conditions)
      if (condition.velocity)
        condition.velocity->not_finite(communicator); // these were no nodes
    if (std::abs(flux.net) <= tolerated * flux.gross + 3 * flux.error)
      return {};
    std::ostringstream message;
    message << "the prescribed velocities let " << flux.in() << " into the box and " << flux.out()
            << " out of it, per time, at time " << t
            << "; a box without outflow needs the same: change them, or give a face the "
               "condition outflow";
    return {{box.pointer + "/boundary", message.str()}};
  }


  template BoundaryFlux interpolated_flux(const dealii::DoFHandler<2> &,
                                          const Domain<2> &,
                                          const dealii::AffineConstraints<double> &);
  template BoundaryFlux interpolated_flux(const dealii::DoFHandler<3> &,
                                          const Domain<3> &,
                                          const dealii::AffineConstraints<double> &);
  template <int dim>
  std::string
  spread_flux_text(const EulerianSpace<dim> &space)
  {
    std::ostringstream text;
    text << "the prescribed velocities, as interpolated on this mesh, let "
         << percent(2 * std::abs(space.spread_flux())) << " more "
         << (space.spread_flux() > 0 ? "out of the box than in" : "into the box than out")
         << "; the difference is spread over both";
    return text.str();
  }


  template std::string spread_flux_text(const EulerianSpace<2> &);
  template std::string spread_flux_text(const EulerianSpace<3> &);
  template Issues unbalanced_flux(const Domain<2> &, const BoundaryFlux &, double, MPI_Comm);
  template Issues unbalanced_flux(const Domain<3> &, const BoundaryFlux &, double, MPI_Comm);
  template BoundaryFlux prescribed_flux(const Domain<2> &);
  template BoundaryFlux prescribed_flux(const Domain<3> &);
} // namespace feib
