// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_stretched_h
#define feib_testing_stretched_h

#include <feib/constitutive_law.h>
#include <feib/testing/plugins.h>

#include <array>
#include <string>
#include <utility>

namespace feib::testing
{
  /// W and P of a law with these parameters (JSON) at one point with the deformation gradient F,
  /// its frame along the axes: to compare with closed forms.
  template <int structure_dim, int dim>
  std::pair<double, typename ConstitutiveLaw<structure_dim, dim>::Matrix>
  energy_and_stress(const std::string &law_name,
                    const std::string &parameters,
                    const typename ConstitutiveLaw<structure_dim, dim>::Matrix &F)
  {
    using Law      = ConstitutiveLaw<structure_dim, dim>;
    const auto law = registry().create<Law>(law_name, parameters);
    std::vector<typename Law::MaterialPoint> points(1);
    for (unsigned int k = 0; k < structure_dim; ++k)
      points[0].frame[k][k] = 1;
    law->set_points(points);
    typename Law::Moment moment;
    for (const auto &variable : law->state_variables())
      moment.state.emplace_back(1, variable.initial);
    law->set_moment(moment);
    std::vector<double> W;
    std::vector<typename Law::Matrix> P;
    law->energy({F}, W);
    law->stress({F}, P);
    return {W[0], P[0]};
  }

  /// Of the diagonal F with these stretches.
  template <int structure_dim, int dim>
  std::pair<double, typename ConstitutiveLaw<structure_dim, dim>::Matrix>
  stretched(const std::string &law_name,
            const std::string &parameters,
            const std::array<double, structure_dim> &stretches)
  {
    typename ConstitutiveLaw<structure_dim, dim>::Matrix F;
    for (unsigned int k = 0; k < structure_dim; ++k)
      F[k][k] = stretches[k];
    return energy_and_stress<structure_dim, dim>(law_name, parameters, F);
  }

  /// Of F = I + amount e1 (x) e2, a body.
  template <int dim>
  std::pair<double, typename ConstitutiveLaw<dim, dim>::Matrix>
  sheared(const std::string &law_name, const std::string &parameters, const double amount)
  {
    typename ConstitutiveLaw<dim, dim>::Matrix F;
    for (unsigned int k = 0; k < dim; ++k)
      F[k][k] = 1;
    F[0][1] = amount;
    return energy_and_stress<dim, dim>(law_name, parameters, F);
  }
} // namespace feib::testing

#endif
