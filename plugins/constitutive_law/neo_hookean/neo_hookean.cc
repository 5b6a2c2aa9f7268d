// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/constitutive_law.h>
#include <feib/expression.h>
#include <feib/plugin.h>

#include "neo_hookean_schema.h"

#include <deal.II/base/derivative_form.h>

#include <cmath>
#include <sstream>

namespace feib
{
  /// W = mu_e/2 |F|^2 [- mu_e ln J, or + mu_e/2 (1/J^2 - m - 1)]. The derivative of ln J is
  /// G = F C^-1, which is F^-T for square F. The modulus mu_e is a function of the reference place.
  template <int structure_dim, int dim>
  class NeoHookean : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Law           = ConstitutiveLaw<structure_dim, dim>;
    using Matrix        = typename Law::Matrix;
    using MaterialPoint = typename Law::MaterialPoint;

    explicit NeoHookean(const Parameters &parameters)
      : pointer(parameters.pointer() + "/shear_modulus")
      , modulus(parse_expressions<dim>(parameters, "shear_modulus", 1, Variables::reference))
      , stress_free(parameters.boolean("stress_free"))
      , incompressible(parameters.boolean("incompressible"))
    {
      if (incompressible && stress_free)
        parameters.fail("stress_free",
                        "is true, and \"incompressible\" too; a sheet of an incompressible "
                        "material is free of stress at rest by itself");
      if (incompressible && structure_dim == dim)
        parameters.fail("incompressible",
                        "is true, but is for curves and surfaces, whose thickness follows from "
                        "it; a body in the flow keeps its volume anyway");
    }

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      mu.clear();
      mu.reserve(points.size());
      for (const MaterialPoint &point : points)
        {
          const double value = modulus->value(point.place);
          if (!(value > 0) || !std::isfinite(value))
            {
              std::ostringstream message;
              message << "is " << value << " at the reference place (";
              for (unsigned int i = 0; i < dim; ++i)
                message << (i ? ", " : "") << point.place[i];
              message << "); it must be finite and positive there";
              throw Error(pointer, message.str());
            }
          mu.push_back(value);
        }
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      W.assign(F.size(), 0.);
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          for (unsigned int i = 0; i < dim; ++i)
            W[q] += mu[q] / 2 * F[q][i].norm_square();
          if (stress_free)
            W[q] -= mu[q] * std::log(Form(F[q]).determinant());
          if (incompressible)
            W[q] += mu[q] / 2 * (std::pow(Form(F[q]).determinant(), -2) - structure_dim - 1);
        }
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      P.resize(F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          const Form G      = linear() ? Form() : Form(F[q]).covariant_form();
          const double less = incompressible ? std::pow(Form(F[q]).determinant(), -2) : 1.;
          for (unsigned int i = 0; i < dim; ++i)
            P[q][i] = mu[q] * (F[q][i] - less * G[i]);
        }
    }

    /// dG = dF C^-1 - G (dF^T G + F^T dF C^-1), as d(C^-1) = - C^-1 (dF^T F + F^T dF) C^-1; and
    /// d(J^-2) = -2 J^-2 G : dF.
    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      dP.resize(F.size());
      for (unsigned int q = 0; q < F.size(); ++q)
        {
          for (unsigned int i = 0; i < dim; ++i)
            dP[q][i] = mu[q] * dF[q][i];
          if (linear())
            continue;
          Small C, A; // A = dF^T G + F^T dF C^-1
          for (unsigned int i = 0; i < dim; ++i)
            C += outer_product(F[q][i], F[q][i]);
          const Small inverse = invert(C);
          for (unsigned int i = 0; i < dim; ++i)
            A += outer_product(dF[q][i], F[q][i] * inverse) +
                 outer_product(F[q][i], dF[q][i] * inverse);
          double less = 1, d_less = 0;
          if (incompressible)
            {
              less = 1 / determinant(C);
              for (unsigned int i = 0; i < dim; ++i)
                d_less -= 2 * less * (F[q][i] * inverse * dF[q][i]);
            }
          for (unsigned int i = 0; i < dim; ++i)
            dP[q][i] -= mu[q] * (less * (dF[q][i] * inverse - F[q][i] * inverse * A) +
                                 d_less * (F[q][i] * inverse));
        }
    }

    bool
    linear() const override
    {
      return !stress_free && !incompressible;
    }

    bool
    needs_positive_determinant() const override
    {
      return !linear();
    }

  private:
    using Form  = dealii::DerivativeForm<1, structure_dim, dim>;
    using Small = dealii::Tensor<2, structure_dim>;

    std::string pointer;
    std::unique_ptr<dealii::Function<dim>> modulus;
    bool stress_free, incompressible;
    std::vector<double> mu; // one value per material point
  };
} // namespace feib

FEIB_PLUGIN("neo_hookean", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::NeoHookean>("neo_hookean", neo_hookean_schema);
}
