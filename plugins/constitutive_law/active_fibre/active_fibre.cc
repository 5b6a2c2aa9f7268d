// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/expression.h>
#include <feib/failure.h>
#include <feib/fibre_directions.h>
#include <feib/message.h>
#include <feib/modified_law.h>
#include <feib/plugin.h>
#include <feib/registry.h>

#include "active_fibre_schema.h"

#include <cmath>

namespace feib
{
  /// Adds to a law the tension T(t, s) of fibres: W = T sum_a (|F a| - 1), whose stress along a is
  /// T whatever the stretch.
  template <int structure_dim, int dim>
  class ActiveFibre : public ModifiedLaw<structure_dim, dim>
  {
  public:
    using Law           = ConstitutiveLaw<structure_dim, dim>;
    using Matrix        = typename Law::Matrix;
    using MaterialPoint = typename Law::MaterialPoint;
    using Moment        = typename Law::Moment;

    explicit ActiveFibre(const Parameters &parameters)
      : ModifiedLaw<structure_dim, dim>(parameters.child("law").create<Law>())
      , pointer(parameters.pointer() + "/tension")
      , expression(parse_expressions<dim>(parameters, "tension", 1, Variables::reference_time))
      , fibres(parameters)
    {}

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      this->law->set_points(points);
      fibres.set_points(points);
      places.clear();
      for (const MaterialPoint &point : points)
        places.push_back(point.place);
      set_tension();
      for (unsigned int q = 0; q < places.size(); ++q)
        if (!std::isfinite(tension[q]))
          throw Error(pointer,
                      "is " + readable(tension[q]) +
                        " at the start, at a reference place of the structure; it must be finite");
    }

    void
    set_moment(const Moment &moment) override
    {
      ModifiedLaw<structure_dim, dim>::set_moment(moment);
      set_tension();
      for (const double value : tension)
        if (!std::isfinite(value)) // a shorter step would jump over it
          throw Incurable(pointer + ": is " + readable(value) + " at time " +
                          readable(this->moment().time));
    }

    bool
    time_dependent() const override
    {
      return true;
    }

    bool
    linear() const override
    {
      return false;
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      this->law->energy(F, W);
      for_each_fibre(F,
                     [&](const unsigned int q, const auto &, const auto &, const double stretch) {
                       W[q] += tension[q] * (stretch - 1);
                     });
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      this->law->stress(F, P);
      for_each_fibre(
        F, [&](const unsigned int q, const auto &a, const auto &image, const double stretch) {
          for (unsigned int i = 0; i < dim; ++i)
            P[q][i] += tension[q] / stretch * image[i] * a;
        });
    }

    /// d(F a/|F a|) = (dF a - n (n . dF a))/|F a|, n = F a/|F a|.
    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      this->law->stress_derivative(F, dF, dP);
      for_each_fibre(
        F, [&](const unsigned int q, const auto &a, const auto &image, const double stretch) {
          const dealii::Tensor<1, dim> n = image / stretch, change = applied(dF[q], a);
          for (unsigned int i = 0; i < dim; ++i)
            dP[q][i] += tension[q] / stretch * (change[i] - n[i] * (n * change)) * a;
        });
    }

  private:
    using Direction = dealii::Tensor<1, structure_dim>;

    static dealii::Tensor<1, dim>
    applied(const Matrix &F, const Direction &a)
    {
      dealii::Tensor<1, dim> image;
      for (unsigned int i = 0; i < dim; ++i)
        image[i] = F[i] * a;
      return image;
    }

    /// Calls action(point, a, F a, |F a|).
    template <typename Action>
    void
    for_each_fibre(const std::vector<Matrix> &F, const Action &action) const
    {
      for (unsigned int q = 0; q < F.size(); ++q)
        for (unsigned int family = 0; family < fibres.n_families(); ++family)
          {
            const Direction &a                 = fibres(q, family);
            const dealii::Tensor<1, dim> image = applied(F[q], a);
            action(q, a, image, image.norm());
          }
    }

    void
    set_tension()
    {
      expression->set_time(this->moment().time);
      tension.resize(places.size());
      for (unsigned int q = 0; q < places.size(); ++q)
        tension[q] = expression->value(places[q]);
    }

    const std::string pointer;
    std::unique_ptr<dealii::Function<dim>> expression;
    FibreDirections<structure_dim, dim> fibres;
    std::vector<dealii::Point<dim>> places;
    std::vector<double> tension; // at the moment, one value per point
  };
} // namespace feib

FEIB_PLUGIN("active_fibre", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::ActiveFibre>("active_fibre", active_fibre_schema);
}
