// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_model_volumetric_split_h
#define feib_structure_model_volumetric_split_h

#include <feib/modified_law.h>

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
  class VolumetricSplit : public ModifiedLaw<dim, dim>
  {
  public:
    using Law    = ConstitutiveLaw<dim, dim>;
    using Matrix = typename Law::Matrix;

    VolumetricSplit(std::unique_ptr<Law> law, bool deviatoric, double k);

    void energy(const std::vector<Matrix> &F, std::vector<double> &W) const override;

    void stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override;

    void stress_derivative(const std::vector<Matrix> &F,
                           const std::vector<Matrix> &dF,
                           std::vector<Matrix> &dP) const override;

    void update_state(const std::vector<Matrix> &F,
                      std::vector<std::vector<double>> &state) const override;

    bool linear() const override;

    bool needs_positive_determinant() const override;

  private:
    using ModifiedLaw<dim, dim>::law;

    const double c, k;
  };
} // namespace feib

#endif
