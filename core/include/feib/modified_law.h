// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_modified_law_h
#define feib_modified_law_h

#include <feib/constitutive_law.h>

#include <memory>
#include <utility>

namespace feib
{
  /// A law that changes another one: all it does not override is that of the other. Its state
  /// variables, if it has any, come after those of the other law.
  template <int structure_dim, int dim>
  class ModifiedLaw : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Law           = ConstitutiveLaw<structure_dim, dim>;
    using Matrix        = typename Law::Matrix;
    using MaterialPoint = typename Law::MaterialPoint;
    using Moment        = typename Law::Moment;
    using StateVariable = typename Law::StateVariable;
    using State         = std::vector<std::vector<double>>;

    explicit ModifiedLaw(std::unique_ptr<Law> law)
      : law(std::move(law))
    {}

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      law->set_points(points);
    }

    std::vector<StateVariable>
    state_variables() const override
    {
      return law->state_variables();
    }

    void
    set_moment(const Moment &moment) override
    {
      Law::set_moment(moment);
      law->set_moment(moment);
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      law->energy(F, W);
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      law->stress(F, P);
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      law->stress_derivative(F, dF, dP);
    }

    void
    update_state(const std::vector<Matrix> &F, State &state) const override
    {
      law->update_state(F, state);
    }

    bool
    viscous() const override
    {
      return law->viscous();
    }

    void
    viscous_stress(const std::vector<Matrix> &F,
                   const std::vector<Matrix> &rate,
                   std::vector<Matrix> &P) const override
    {
      law->viscous_stress(F, rate, P);
    }

    void
    archive(Archive &archive) override
    {
      law->archive(archive);
    }

    bool
    time_dependent() const override
    {
      return law->time_dependent();
    }

    bool
    linear() const override
    {
      return law->linear();
    }

    double
    tested_strain() const override
    {
      return law->tested_strain();
    }

    bool
    needs_positive_determinant() const override
    {
      return law->needs_positive_determinant();
    }

  protected:
    const std::unique_ptr<Law> law;
  };
} // namespace feib

#endif
