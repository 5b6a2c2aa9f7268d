// SPDX-License-Identifier: LGPL-2.1-or-later
#include "residual_norms.h"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  template <int dim>
  ResidualNorms
  residual_norms(const EulerianSpace<dim> &space, const VelocityVector &r, const PressureVector &g)
  {
    // The scale of the divergence: the largest flux through a cell, of the state of the space.
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    double scale             = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const auto &size = space.cells()[c].size;
        const double det = cell_volume(size);
        double sum       = 0;
        for (unsigned int a = 0; a < dim; ++a)
          {
            double largest = 0;
            for (unsigned int i = 0; i < n; ++i)
              largest =
                std::max(largest,
                         std::abs(space.velocity.local_element(space.velocity_dofs(c)[a * n + i])));
            sum += largest / size[a];
          }
        scale += det * det * sum * sum;
      }
    ResidualNorms result;
    result.momentum         = r.l2_norm();
    result.divergence       = g.l2_norm();
    result.divergence_scale = std::sqrt(dealii::Utilities::MPI::sum(scale, space.communicator()));
    return result;
  }


  template <int dim>
  double
  relevant_flux(const EulerianSpace<dim> &space,
                const typename FluidOperators<dim>::Terms &terms,
                const double rate,
                const ResidualNorms &norms,
                const double scale)
  {
    const Domain<dim> &box = space.domain();
    double base            = 0;
    for (unsigned int a = 0; a < dim; ++a)
      base = std::max(base, (box.upper[a] - box.lower[a]) / box.cells[a]);
    return std::max(norms.divergence_scale,
                    least_flux * scale /
                      std::max(impedance<dim>(terms, space.smallest_edge(), rate),
                               impedance<dim>(terms, base, rate)));
  }


  template <int dim>
  void
  remove_mean_pressure(EulerianSpace<dim> &space)
  {
    double integral = 0, volume = 0;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const double det = cell_volume(space.cells()[c].size);
        // The other basis functions have no mean.
        integral += det * space.pressure.local_element(space.pressure_dofs(c)[0]);
        volume += det;
      }
    const double mean = dealii::Utilities::MPI::sum(integral, space.communicator()) /
                        dealii::Utilities::MPI::sum(volume, space.communicator());
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      space.pressure.local_element(space.pressure_dofs(c)[0]) -= mean;
  }


#define FEIB_INSTANTIATE(dim)                                                \
  template ResidualNorms residual_norms(const EulerianSpace<dim> &,          \
                                        const VelocityVector &,              \
                                        const PressureVector &);             \
  template double relevant_flux(const EulerianSpace<dim> &,                  \
                                const typename FluidOperators<dim>::Terms &, \
                                double,                                      \
                                const ResidualNorms &,                       \
                                double);                                     \
  template void remove_mean_pressure(EulerianSpace<dim> &);

  FEIB_INSTANTIATE(2)
  FEIB_INSTANTIATE(3)
} // namespace feib
