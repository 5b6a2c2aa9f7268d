// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cell_operators.h"

#include "cell_kernels.h"

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
  CellOperators<dim>::CellOperators(const Reconstruction<dim> *reconstruction)
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

    for (unsigned int a = 0; a < dim; ++a)
      {
        first[a] = reconstruction ? 0 : a * n;
        last[a]  = reconstruction ? n_u : (a + 1) * n;
      }
    for (unsigned int q = 0; q < n_q; ++q)
      {
        const dealii::Point<dim> &x = quadrature.point(q);
        weights[q]                  = quadrature.weight(q);
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int a = 0; a < dim; ++a)
            dphi[a][q][i] = velocity.shape_grad(hierarchic[i], x)[a];
        double at_x[dim][n_u];
        velocity_values(reconstruction, x, at_x);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int j = 0; j < n_u; ++j)
            {
              values[a][q][j] = at_x[a][j];
              mean[a][j] += weights[q] * at_x[a][j];
              for (unsigned int b = 0; b < dim; ++b)
                moment[b][a][j] += weights[q] * x[b] * at_x[a][j];
              for (unsigned int i = 0; i < n_u; ++i)
                mass[i][j] += weights[q] * at_x[a][i] * at_x[a][j];
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
    for (unsigned int i = 0; i < n_u; ++i)
      for (unsigned int j = 0; j < n_u; ++j)
        matrix[i * n_u + j] = alpha * det * mass[i][j];
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j < n; ++j)
          {
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
  std::vector<double>
  CellOperators<dim>::convection_matrix(const Size &size,
                                        const double *w,
                                        const double rho,
                                        const ConvectiveForm form,
                                        const unsigned int outflow_faces) const
  {
    const double det = cell_volume(size);
    const bool skew  = form == ConvectiveForm::skew_symmetric;
    std::vector<double> matrix(n_u * n_u, 0.);
    for (unsigned int q = 0; q < n_q; ++q)
      {
        const double factor = rho * det * weights[q] * (skew ? .5 : 1.);
        double wq[dim], advected[n] = {}; // factor w, factor w . grad phi_j
        for (unsigned int a = 0; a < dim; ++a)
          {
            wq[a] = factor * value(a, q, w);
            for (unsigned int j = 0; j < n; ++j)
              advected[j] += wq[a] / size[a] * dphi[a][q][j];
          }
        for (unsigned int c = 0; c < dim; ++c)
          {
            double force[n_u] = {}; // component c for each unknown of u
            for (unsigned int j = 0; j < n; ++j)
              force[c * n + j] = advected[j];
            if (form == ConvectiveForm::rotational) // (curl u x w)_c = w_d (d_d u_c - d_c u_d)
              for (unsigned int d = 0; d < dim; ++d)
                for (unsigned int j = 0; j < n; ++j)
                  force[d * n + j] -= wq[d] / size[c] * dphi[c][q][j];
            for (unsigned int i = first[c]; i < last[c]; ++i)
              for (unsigned int j = 0; j < n_u; ++j)
                matrix[i * n_u + j] += values[c][q][i] * force[j];
            if (skew)
              for (unsigned int i = 0; i < n; ++i)
                for (unsigned int j = first[c]; j < last[c]; ++j)
                  matrix[(c * n + i) * n_u + j] -= advected[i] * values[c][q][j];
          }
      }
    if (skew)
      for (unsigned int f = 0; f < 2 * dim; ++f)
        if (outflow_faces & (1U << f))
          for (unsigned int q = 0; q < n_face_q; ++q)
            {
              const double factor = .5 * rho * face_weights[q] * face_flux(size, f, q, w);
              for (unsigned int c = 0; c < dim; ++c)
                for (unsigned int i = 0; i < n; ++i)
                  for (unsigned int j = 0; j < n; ++j)
                    matrix[(c * n + i) * n_u + c * n + j] +=
                      factor * face_phi[f][q][i] * face_phi[f][q][j];
            }
    return matrix;
  }


  template <int dim>
  template <typename Value>
  Value
  CellOperators<dim>::face_flux(const Size &size,
                                const unsigned int f,
                                const unsigned int q,
                                const Value *w) const
  {
    Value result = {};
    for (unsigned int i = 0; i < n; ++i)
      result += face_phi[f][q][i] * w[f / 2 * n + i];
    return result * (f % 2 == 0 ? -1. : 1.) * cell_volume(size) / size[f / 2];
  }


  template <int dim>
  template <typename Value>
  void
  CellOperators<dim>::add_convection(const Size &size,
                                     const Value *w,
                                     const Value *u,
                                     const double rho,
                                     const ConvectiveForm form,
                                     Value *result,
                                     const unsigned int outflow_faces) const
  {
    const double det      = cell_volume(size);
    const bool skew       = form == ConvectiveForm::skew_symmetric;
    const bool rotational = form == ConvectiveForm::rotational;
    for (unsigned int q = 0; q < n_q; ++q)
      {
        const double factor = rho * det * weights[q] * (skew ? .5 : 1.);
        Value wq[dim], advected[n] = {}; // factor w, factor w . grad phi_i
        for (unsigned int a = 0; a < dim; ++a)
          {
            wq[a] = factor * value(a, q, w);
            for (unsigned int i = 0; i < n; ++i)
              advected[i] += wq[a] / size[a] * dphi[a][q][i];
          }
        Value along[n] = {}; // factor w . u_i
        if (rotational)
          for (unsigned int a = 0; a < dim; ++a)
            for (unsigned int i = 0; i < n; ++i)
              along[i] += wq[a] * u[a * n + i];
        for (unsigned int c = 0; c < dim; ++c)
          {
            Value force = {}; // w_a d_a u_c, rotational: less w_a d_c u_a
            for (unsigned int i = 0; i < n; ++i)
              force += advected[i] * u[c * n + i];
            if (rotational)
              for (unsigned int i = 0; i < n; ++i)
                force -= along[i] / size[c] * dphi[c][q][i];
            for (unsigned int i = first[c]; i < last[c]; ++i)
              result[i] += force * values[c][q][i];
            if (skew)
              {
                const Value uq = value(c, q, u);
                for (unsigned int i = 0; i < n; ++i)
                  result[c * n + i] -= uq * advected[i];
              }
          }
      }
    if (skew)
      for (unsigned int f = 0; f < 2 * dim; ++f)
        if (outflow_faces & (1U << f))
          for (unsigned int q = 0; q < n_face_q; ++q)
            {
              const Value factor = .5 * rho * face_weights[q] * face_flux(size, f, q, w);
              for (unsigned int c = 0; c < dim; ++c)
                {
                  Value value = {};
                  for (unsigned int i = 0; i < n; ++i)
                    value += face_phi[f][q][i] * u[c * n + i];
                  for (unsigned int i = 0; i < n; ++i)
                    result[c * n + i] += factor * value * face_phi[f][q][i];
                }
            }
  }


  template void
  velocity_values<2>(const Reconstruction<2> *, const dealii::Point<2> &, double (&)[2][18]);
  template void
  velocity_values<3>(const Reconstruction<3> *, const dealii::Point<3> &, double (&)[3][81]);
  template class CellOperators<2>;
  template class CellOperators<3>;

#define FEIB_INSTANTIATE(dim, Value)                                                           \
  template void CellOperators<dim>::add_convection(                                            \
    const Size &, const Value *, const Value *, double, ConvectiveForm, Value *, unsigned int) \
    const;
  FEIB_INSTANTIATE(2, double)
  FEIB_INSTANTIATE(3, double)
  FEIB_INSTANTIATE(2, Batch<double>::Values)
  FEIB_INSTANTIATE(3, Batch<double>::Values)
} // namespace feib
