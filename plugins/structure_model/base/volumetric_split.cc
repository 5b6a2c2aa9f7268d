// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/structure_model/volumetric_split.h>

#include <cmath>
#include <utility>

namespace feib
{
  namespace
  {
    template <int dim>
    using Matrix = typename ConstitutiveLaw<dim, dim>::Matrix;

    template <int dim>
    using Tensor = dealii::Tensor<2, dim>;

    template <int dim>
    Tensor<dim>
    tensor(const dealii::Tensor<1, dim, dealii::Tensor<1, dim>> &rows)
    {
      Tensor<dim> result;
      for (unsigned int i = 0; i < dim; ++i)
        result[i] = rows[i];
      return result;
    }

    template <int dim>
    Matrix<dim>
    matrix(const Tensor<dim> &rows)
    {
      Matrix<dim> result;
      for (unsigned int i = 0; i < dim; ++i)
        result[i] = rows[i];
      return result;
    }

    /// From F to F_bar = J^-c F.
    template <int dim>
    std::vector<Matrix<dim>>
    scaled(std::vector<Matrix<dim>> F, const double c)
    {
      for (Matrix<dim> &F_q : F)
        F_q *= std::pow(determinant(tensor<dim>(F_q)), -c);
      return F;
    }
  } // namespace


  template <int dim>
  VolumetricSplit<dim>::VolumetricSplit(std::unique_ptr<Law> law,
                                        const bool deviatoric,
                                        const double k)
    : ModifiedLaw<dim, dim>(std::move(law))
    , c(deviatoric ? 1. / dim : 0.)
    , k(k)
  {}


  template <int dim>
  void
  VolumetricSplit<dim>::energy(const std::vector<Matrix> &F, std::vector<double> &W) const
  {
    law->energy(scaled<dim>(F, c), W);
    for (unsigned int q = 0; q < F.size(); ++q)
      {
        const double ln_J = std::log(determinant(tensor<dim>(F[q])));
        W[q] += k / 2 * ln_J * ln_J;
      }
  }


  template <int dim>
  void
  VolumetricSplit<dim>::stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const
  {
    law->stress(scaled<dim>(F, c), P);
    for (unsigned int q = 0; q < F.size(); ++q)
      {
        const Tensor<dim> A = tensor<dim>(F[q]), P_bar = tensor<dim>(P[q]),
                          G = transpose(invert(A));
        const double J      = determinant(A);
        P[q] = matrix<dim>(std::pow(J, -c) * (P_bar - c * scalar_product(P_bar, A) * G) +
                           k * std::log(J) * G);
      }
  }


  // With g = G : dF, the derivative of ln J: dF_bar = J^-c (dF - c g F), dG = - G dF^T G.
  template <int dim>
  void
  VolumetricSplit<dim>::stress_derivative(const std::vector<Matrix> &F,
                                          const std::vector<Matrix> &dF,
                                          std::vector<Matrix> &dP) const
  {
    const std::vector<Matrix> F_bar = scaled<dim>(F, c);
    std::vector<Matrix> dF_bar(F.size()), P;
    for (unsigned int q = 0; q < F.size(); ++q)
      {
        const Tensor<dim> A = tensor<dim>(F[q]), dA = tensor<dim>(dF[q]);
        const double g = scalar_product(transpose(invert(A)), dA);
        dF_bar[q]      = matrix<dim>(std::pow(determinant(A), -c) * (dA - c * g * A));
      }
    law->stress(F_bar, P);
    law->stress_derivative(F_bar, dF_bar, dP);
    for (unsigned int q = 0; q < F.size(); ++q)
      {
        const Tensor<dim> A = tensor<dim>(F[q]), dA = tensor<dim>(dF[q]);
        const Tensor<dim> P_bar = tensor<dim>(P[q]), dP_bar = tensor<dim>(dP[q]);
        const Tensor<dim> G = transpose(invert(A)), dG = -1. * G * transpose(dA) * G;
        const double J = determinant(A), g = scalar_product(G, dA);
        const double work   = scalar_product(P_bar, A);
        const double d_work = scalar_product(dP_bar, A) + scalar_product(P_bar, dA);
        dP[q]               = matrix<dim>(std::pow(J, -c) * (dP_bar - c * (d_work * G + work * dG) -
                                               c * g * (P_bar - c * work * G)) +
                            k * (g * G + std::log(J) * dG));
      }
  }


  template <int dim>
  void
  VolumetricSplit<dim>::update_state(const std::vector<Matrix> &F,
                                     std::vector<std::vector<double>> &state) const
  {
    law->update_state(scaled<dim>(F, c), state);
  }


  template <int dim>
  bool
  VolumetricSplit<dim>::linear() const
  {
    return false;
  }


  template <int dim>
  bool
  VolumetricSplit<dim>::needs_positive_determinant() const
  {
    return true;
  }


  template class VolumetricSplit<2>;
  template class VolumetricSplit<3>;
} // namespace feib
