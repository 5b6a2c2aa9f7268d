// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_volumetric_split_h
#define feib_volumetric_split_h

#include <feib/constitutive_law.h>

#include <cmath>
#include <memory>
#include <utility>

namespace feib
{
  /// A law W of a body as a sum of a part that sees changes of shape and one that sees changes of
  /// volume (Flory's split; Holzapfel, Nonlinear Solid Mechanics, 2000, section 6.4):
  ///   W(F_bar) + k/2 (ln J)^2,  F_bar = J^-c F,  J = det F > 0,
  /// where c is 1/dim, so that det F_bar = 1, when deviatoric, and else 0. With G = F^-T, the
  /// derivative of ln J, and P_bar the stress of W at F_bar:
  ///   P = J^-c (P_bar - c (P_bar : F) G) + k ln J G.
  /// The modulus k is a force per area, in 2D per length.
  template <int dim>
  class VolumetricSplit : public ConstitutiveLaw<dim, dim>
  {
  public:
    using Law           = ConstitutiveLaw<dim, dim>;
    using Matrix        = typename Law::Matrix;
    using MaterialPoint = typename Law::MaterialPoint;

    VolumetricSplit(std::unique_ptr<Law> law, const bool deviatoric, const double k)
      : law(std::move(law))
      , c(deviatoric ? 1. / dim : 0.)
      , k(k)
    {}

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      law->set_points(points);
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      law->energy(scaled(F), W);
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const double ln_J = std::log(determinant(tensor(F[q])));
          W[q] += k / 2 * ln_J * ln_J;
        }
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      law->stress(scaled(F), P);
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const Tensor A = tensor(F[q]), P_bar = tensor(P[q]), G = transpose(invert(A));
          const double J = determinant(A);
          P[q]           = matrix(std::pow(J, -c) * (P_bar - c * scalar_product(P_bar, A) * G) +
                        k * std::log(J) * G);
        }
    }

    /// With g = G : dF, the derivative of ln J: dF_bar = J^-c (dF - c g F), dG = - G dF^T G.
    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      const std::vector<Matrix> F_bar = scaled(F);
      std::vector<Matrix> dF_bar(F.size()), P;
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const Tensor A = tensor(F[q]), dA = tensor(dF[q]);
          const double g = scalar_product(transpose(invert(A)), dA);
          dF_bar[q]      = matrix(std::pow(determinant(A), -c) * (dA - c * g * A));
        }
      law->stress(F_bar, P);
      law->stress_derivative(F_bar, dF_bar, dP);
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const Tensor A = tensor(F[q]), dA = tensor(dF[q]);
          const Tensor P_bar = tensor(P[q]), dP_bar = tensor(dP[q]);
          const Tensor G = transpose(invert(A)), dG = -1. * G * transpose(dA) * G;
          const double J = determinant(A), g = scalar_product(G, dA);
          const double work   = scalar_product(P_bar, A);
          const double d_work = scalar_product(dP_bar, A) + scalar_product(P_bar, dA);
          dP[q]               = matrix(std::pow(J, -c) * (dP_bar - c * (d_work * G + work * dG) -
                                            c * g * (P_bar - c * work * G)) +
                         k * (g * G + std::log(J) * dG));
        }
    }

    bool
    needs_positive_determinant() const override
    {
      return true;
    }

  private:
    using Tensor = dealii::Tensor<2, dim>;

    static Tensor
    tensor(const Matrix &rows)
    {
      Tensor result;
      for (unsigned int i = 0; i < dim; ++i)
        result[i] = rows[i];
      return result;
    }

    static Matrix
    matrix(const Tensor &rows)
    {
      Matrix result;
      for (unsigned int i = 0; i < dim; ++i)
        result[i] = rows[i];
      return result;
    }

    /// From F to F_bar.
    std::vector<Matrix>
    scaled(std::vector<Matrix> F) const
    {
      for (Matrix &F_q : F)
        F_q *= std::pow(determinant(tensor(F_q)), -c);
      return F;
    }

    std::unique_ptr<Law> law;
    double c, k;
  };
} // namespace feib

#endif
