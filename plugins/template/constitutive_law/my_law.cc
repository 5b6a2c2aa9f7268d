#include <feib/constitutive_law.h>
#include <feib/plugin.h>

#include "my_law_schema.h"

namespace my_law_plugin
{
  /// W = mu/2 I1 + c/4 I1^2 with I1 = |F|^2: a material that stiffens as it is stretched.
  ///   P  = dW/dF     = (mu + c I1) F
  ///   dP = dP/dF[dF] = (mu + c I1) dF + 2 c (F : dF) F
  ///
  /// m is the dimension of the structure, dim that of the space: curves and bodies in 2D, surfaces
  /// and bodies in 3D.
  template <int m, int dim>
  class MyLaw : public feib::ConstitutiveLaw<m, dim>
  {
  public:
    /// Row i of a matrix is the gradient of the i-th coordinate of a point, of m entries.
    using Matrix = typename feib::ConstitutiveLaw<m, dim>::Matrix;

    explicit MyLaw(const feib::Parameters &parameters)
      : mu(parameters.number("shear_modulus"))
      , c(parameters.number("stiffening"))
    {}

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      W.resize(F.size());
      for (std::size_t q = 0; q < F.size(); ++q)
        {
          const double I1 = product(F[q], F[q]);
          W[q]            = mu / 2 * I1 + c / 4 * I1 * I1;
        }
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      P.resize(F.size());
      for (std::size_t q = 0; q < F.size(); ++q)
        for (int i = 0; i < dim; ++i)
          P[q][i] = (mu + c * product(F[q], F[q])) * F[q][i];
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      dP.resize(F.size());
      for (std::size_t q = 0; q < F.size(); ++q)
        for (int i = 0; i < dim; ++i)
          dP[q][i] =
            (mu + c * product(F[q], F[q])) * dF[q][i] + 2 * c * product(F[q], dF[q]) * F[q][i];
    }

  private:
    static double
    product(const Matrix &A, const Matrix &B)
    {
      double sum = 0;
      for (int i = 0; i < dim; ++i)
        sum += A[i] * B[i];
      return sum;
    }

    const double mu, c;
  };
} // namespace my_law_plugin

FEIB_PLUGIN("my_law", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, my_law_plugin::MyLaw>("my_law", my_law_schema);
}
