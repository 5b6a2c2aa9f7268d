// SPDX-License-Identifier: LGPL-2.1-or-later
#include "operators/cell_operators.h"

#include "operators/cell_kernels.h"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_dgp.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_tools.h>

#include <algorithm>

namespace feib
{
  template <int dim>
  void
  velocity_values(const Reconstruction<dim> *reconstruction,
                  const dealii::Point<dim> &unit,
                  double (&values)[dim][EulerianSpace<dim>::n_velocity])
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    if (reconstruction)
      {
        reconstruction->weights(unit, values);
        return;
      }
    for (unsigned int a = 0; a < dim; ++a)
      {
        std::fill_n(values[a], dim * n, 0.);
        EulerianSpace<dim>::shape_values(unit, &values[a][a * n]);
      }
  }


  template <int dim>
  CellOperators<dim>::CellOperators()
    : mean()
    , moment()
    , mass()
    , stiffness()
    , divergence()
  {
    const dealii::QGauss<dim> quadrature(4);
    const dealii::FE_Q<dim> velocity(2);
    const dealii::FE_DGP<dim> pressure(1);
    const std::vector<unsigned int> hierarchic =
      dealii::FETools::lexicographic_to_hierarchic_numbering<dim>(2);

    const dealii::QGauss<dim - 1> face_quadrature(4);
    for (unsigned int q = 0; q < n_face_q; ++q)
      {
        face_weights[q] = face_quadrature.weight(q);
        for (unsigned int f = 0; f < 2 * dim; ++f)
          {
            dealii::Point<dim> x;
            for (unsigned int a = 0, k = 0; a < dim; ++a)
              x[a] = a == f / 2 ? f % 2 : face_quadrature.point(q)[k++];
            for (unsigned int i = 0; i < n; ++i)
              face_phi[f][q][i] = velocity.shape_value(hierarchic[i], x);
          }
      }

    for (unsigned int q = 0; q < n_q; ++q)
      {
        const dealii::Point<dim> &x = quadrature.point(q);
        weights[q]                  = quadrature.weight(q);
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int a = 0; a < dim; ++a)
            dphi[a][q][i] = velocity.shape_grad(hierarchic[i], x)[a];
        double phi[n];
        EulerianSpace<dim>::shape_values(x, phi);
        for (unsigned int i = 0; i < n; ++i)
          {
            mean[i] += weights[q] * phi[i];
            for (unsigned int b = 0; b < dim; ++b)
              moment[b][i] += weights[q] * x[b] * phi[i];
            for (unsigned int j = 0; j < n; ++j)
              mass[i][j] += weights[q] * phi[i] * phi[j];
          }
        for (unsigned int i = 0; i < n; ++i)
          {
            for (unsigned int j = 0; j < n; ++j)
              for (unsigned int a = 0; a < dim; ++a)
                for (unsigned int b = 0; b < dim; ++b)
                  stiffness[a][b][i][j] += weights[q] * dphi[a][q][i] * dphi[b][q][j];
            for (unsigned int k = 0; k < n_p; ++k)
              for (unsigned int a = 0; a < dim; ++a)
                divergence[a][k][i] += weights[q] * pressure.shape_value(k, x) * dphi[a][q][i];
          }
      }
  }


  template <int dim>
  std::vector<double>
  CellOperators<dim>::velocity_matrix(const Size &size,
                                      const double alpha,
                                      const double mu,
                                      const bool symmetric,
                                      const double gamma) const
  {
    const double det = cell_volume(size);
    std::vector<double> matrix(n_u * n_u, 0.);
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j < n; ++j)
          {
            matrix[(c * n + i) * n_u + c * n + j] += alpha * det * mass[i][j];
            for (unsigned int a = 0; a < dim; ++a)
              matrix[(c * n + i) * n_u + c * n + j] +=
                mu * det / (size[a] * size[a]) * stiffness[a][a][i][j];
            for (unsigned int d = 0; d < dim; ++d)
              matrix[(c * n + i) * n_u + d * n + j] +=
                det / (size[c] * size[d]) *
                ((symmetric ? mu : 0.) * stiffness[d][c][i][j] + // (d_c u_d, d_d v_c)
                 gamma * stiffness[c][d][i][j]);                 // (d_d u_d, d_c v_c)
          }
    return matrix;
  }


  template <int dim>
  std::vector<double>
  CellOperators<dim>::divergence_matrix(const Size &size) const
  {
    const double det = cell_volume(size);
    std::vector<double> matrix(n_p * n_u);
    for (unsigned int k = 0; k < n_p; ++k)
      for (unsigned int a = 0; a < dim; ++a)
        for (unsigned int j = 0; j < n; ++j)
          matrix[k * n_u + a * n + j] = det / size[a] * divergence[a][k][j];
    return matrix;
  }


  template <int dim>
  template <typename Value>
  void
  CellOperators<dim>::add_open_boundary(const Size &size,
                                        const unsigned int faces,
                                        const unsigned int static_faces,
                                        const double rho,
                                        const ConvectiveForm form,
                                        const Value *w,
                                        const Value *by,
                                        const Value *u,
                                        Value *result) const
  {
    const bool rotational = form == ConvectiveForm::rotational;
    for (unsigned int f = 0; f < 2 * dim; ++f)
      if (faces & (1U << f))
        {
          const unsigned int normal = f / 2;
          const double sign         = f % 2 == 0 ? -1. : 1.;
          const bool is_static      = static_faces & (1U << f);
          for (unsigned int q = 0; q < n_face_q; ++q)
            {
              const double factor = .5 * rho * face_weights[q] * cell_volume(size) / size[normal];
              Value w_n = {}, w_q[dim] = {}, u_q[dim] = {}, force[dim], along = {};
              for (unsigned int c = 0; c < dim; ++c)
                {
                  for (unsigned int i = 0; i < n; ++i)
                    {
                      w_q[c] += face_phi[f][q][i] * by[c * n + i];
                      u_q[c] += face_phi[f][q][i] * u[c * n + i];
                    }
                  along += w_q[c] * u_q[c];
                }
              for (unsigned int i = 0; i < n; ++i)
                w_n += sign * face_phi[f][q][i] * w[normal * n + i];
              const Value zero = {}, flux = sign * w_q[normal];
              const Value out = is_static ? flux : w_n > zero ? flux : zero;
              for (unsigned int c = 0; c < dim; ++c)
                force[c] = out * u_q[c] - (rotational ? sign * u_q[normal] * w_q[c] : zero);
              if (rotational)
                force[normal] += sign * along;
              for (unsigned int c = 0; c < dim; ++c)
                for (unsigned int i = 0; i < n; ++i)
                  result[c * n + i] += factor * face_phi[f][q][i] * force[c];
            }
        }
  }


  template void
  velocity_values<2>(const Reconstruction<2> *, const dealii::Point<2> &, double (&)[2][18]);
  template void
  velocity_values<3>(const Reconstruction<3> *, const dealii::Point<3> &, double (&)[3][81]);
  template class CellOperators<2>;
  template class CellOperators<3>;

#define FEIB_INSTANTIATE(dim, Value)                                  \
  template void CellOperators<dim>::add_open_boundary(const Size &,   \
                                                      unsigned int,   \
                                                      unsigned int,   \
                                                      double,         \
                                                      ConvectiveForm, \
                                                      const Value *,  \
                                                      const Value *,  \
                                                      const Value *,  \
                                                      Value *) const;
  FEIB_INSTANTIATE(2, double)
  FEIB_INSTANTIATE(3, double)
  FEIB_INSTANTIATE(2, Batch<double>::Values)
  FEIB_INSTANTIATE(3, Batch<double>::Values)
} // namespace feib
