// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cell_operators.h"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_dgp.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_tools.h>

namespace feib
{
  namespace
  {
    template <int dim>
    double
    volume(const dealii::Tensor<1, dim> &size)
    {
      double result = 1;
      for (unsigned int a = 0; a < dim; ++a)
        result *= size[a];
      return result;
    }
  } // namespace


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

    points = quadrature.get_points();
    for (unsigned int q = 0; q < n_q; ++q)
      {
        weights[q] = quadrature.weight(q);
        for (unsigned int i = 0; i < n; ++i)
          {
            phi[q][i] = velocity.shape_value(hierarchic[i], points[q]);
            for (unsigned int a = 0; a < dim; ++a)
              dphi[a][q][i] = velocity.shape_grad(hierarchic[i], points[q])[a];
          }
        for (unsigned int i = 0; i < n; ++i)
          {
            mean[i] += weights[q] * phi[q][i];
            for (unsigned int a = 0; a < dim; ++a)
              moment[a][i] += weights[q] * points[q][a] * phi[q][i];
            for (unsigned int j = 0; j < n; ++j)
              {
                mass[i][j] += weights[q] * phi[q][i] * phi[q][j];
                for (unsigned int a = 0; a < dim; ++a)
                  for (unsigned int b = 0; b < dim; ++b)
                    stiffness[a][b][i][j] += weights[q] * dphi[a][q][i] * dphi[b][q][j];
              }
            for (unsigned int k = 0; k < n_p; ++k)
              for (unsigned int a = 0; a < dim; ++a)
                divergence[a][k][i] +=
                  weights[q] * pressure.shape_value(k, points[q]) * dphi[a][q][i];
          }
      }
  }


  template <int dim>
  std::vector<double>
  CellOperators<dim>::velocity_matrix(const Size &size,
                                      const double alpha,
                                      const double mu,
                                      const bool symmetric) const
  {
    const double det = volume(size);
    std::vector<double> matrix(n_u * n_u, 0.);
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j < n; ++j)
          {
            double value = alpha * det * mass[i][j];
            for (unsigned int a = 0; a < dim; ++a)
              value += mu * det / (size[a] * size[a]) * stiffness[a][a][i][j];
            matrix[(c * n + i) * n_u + c * n + j] += value;
            if (symmetric) // (d_c u_d, d_d v_c)
              for (unsigned int d = 0; d < dim; ++d)
                matrix[(c * n + i) * n_u + d * n + j] +=
                  mu * det / (size[c] * size[d]) * stiffness[d][c][i][j];
          }
    return matrix;
  }


  template <int dim>
  std::vector<double>
  CellOperators<dim>::divergence_matrix(const Size &size) const
  {
    const double det = volume(size);
    std::vector<double> matrix(n_p * n_u);
    for (unsigned int k = 0; k < n_p; ++k)
      for (unsigned int a = 0; a < dim; ++a)
        for (unsigned int j = 0; j < n; ++j)
          matrix[k * n_u + a * n + j] = det / size[a] * divergence[a][k][j];
    return matrix;
  }


  template <int dim>
  std::vector<double>
  CellOperators<dim>::convection_matrix(const Size &size,
                                        const double *w,
                                        const double rho,
                                        const bool skew,
                                        const unsigned int outflow_faces) const
  {
    const double det = volume(size);
    std::vector<double> matrix(n * n, 0.);
    double advected[n];
    for (unsigned int q = 0; q < n_q; ++q)
      {
        for (unsigned int j = 0; j < n; ++j)
          advected[j] = 0;
        for (unsigned int a = 0; a < dim; ++a)
          {
            double wa = 0;
            for (unsigned int i = 0; i < n; ++i)
              wa += phi[q][i] * w[a * n + i];
            for (unsigned int j = 0; j < n; ++j)
              advected[j] += wa / size[a] * dphi[a][q][j];
          }
        const double factor = rho * det * weights[q] * (skew ? .5 : 1.);
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int j = 0; j < n; ++j)
            matrix[i * n + j] +=
              factor * (phi[q][i] * advected[j] - (skew ? advected[i] * phi[q][j] : 0.));
      }
    if (skew)
      for (unsigned int f = 0; f < 2 * dim; ++f)
        if (outflow_faces & (1U << f))
          for (unsigned int q = 0; q < n_face_q; ++q)
            {
              const double factor = .5 * rho * face_weights[q] * face_flux(size, f, q, w);
              for (unsigned int i = 0; i < n; ++i)
                for (unsigned int j = 0; j < n; ++j)
                  matrix[i * n + j] += factor * face_phi[f][q][i] * face_phi[f][q][j];
            }
    return matrix;
  }


  template <int dim>
  double
  CellOperators<dim>::face_flux(const Size &size,
                                const unsigned int f,
                                const unsigned int q,
                                const double *w) const
  {
    double result = 0;
    for (unsigned int i = 0; i < n; ++i)
      result += face_phi[f][q][i] * w[f / 2 * n + i];
    return result * (f % 2 == 0 ? -1. : 1.) * volume(size) / size[f / 2];
  }


  template <int dim>
  void
  CellOperators<dim>::add_convection(const Size &size,
                                     const double *w,
                                     const double *u,
                                     const double rho,
                                     const bool skew,
                                     double *result,
                                     const unsigned int outflow_faces) const
  {
    const double det = volume(size);
    for (unsigned int q = 0; q < n_q; ++q)
      {
        double wq[dim]; // w_a / h_a
        for (unsigned int a = 0; a < dim; ++a)
          {
            double sum = 0;
            for (unsigned int i = 0; i < n; ++i)
              sum += phi[q][i] * w[a * n + i];
            wq[a] = sum / size[a];
          }
        double advected[n]; // w . grad phi_i
        for (unsigned int i = 0; i < n; ++i)
          {
            advected[i] = 0;
            for (unsigned int a = 0; a < dim; ++a)
              advected[i] += wq[a] * dphi[a][q][i];
          }
        const double factor = rho * det * weights[q] * (skew ? .5 : 1.);
        for (unsigned int c = 0; c < dim; ++c)
          {
            double value = 0, derivative = 0;
            for (unsigned int i = 0; i < n; ++i)
              {
                value += phi[q][i] * u[c * n + i];
                derivative += advected[i] * u[c * n + i];
              }
            derivative *= factor;
            value *= skew ? factor : 0.;
            for (unsigned int i = 0; i < n; ++i)
              result[c * n + i] += derivative * phi[q][i] - value * advected[i];
          }
      }
    if (skew)
      for (unsigned int f = 0; f < 2 * dim; ++f)
        if (outflow_faces & (1U << f))
          for (unsigned int q = 0; q < n_face_q; ++q)
            {
              const double factor = .5 * rho * face_weights[q] * face_flux(size, f, q, w);
              for (unsigned int c = 0; c < dim; ++c)
                {
                  double value = 0;
                  for (unsigned int i = 0; i < n; ++i)
                    value += face_phi[f][q][i] * u[c * n + i];
                  for (unsigned int i = 0; i < n; ++i)
                    result[c * n + i] += factor * value * face_phi[f][q][i];
                }
            }
  }


  template class CellOperators<2>;
  template class CellOperators<3>;
} // namespace feib
