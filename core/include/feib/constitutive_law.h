// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_constitutive_law_h
#define feib_constitutive_law_h

#include <feib/archive.h>
#include <feib/parameters.h>

#include <deal.II/base/array_view.h>
#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <array>

namespace feib
{
  /// A hyperelastic law: W(F), P = dW/dF and dP(F)[dF] for arrays of deformation gradients. F and P
  /// are matrices of dim rows and structure_dim columns, F[i][k] = dX_i/ds_k. W is an energy per
  /// reference volume (structure_dim = dim) or per reference length or area (structure_dim =
  /// dim-1).
  template <int structure_dim, int dim>
  class ConstitutiveLaw
  {
  public:
    static constexpr const char *kind = "constitutive_law";

    using Matrix = dealii::Tensor<1, dim, dealii::Tensor<1, structure_dim>>;

    /// Where a deformation gradient is taken: reference coordinates, the orthonormal frame that the
    /// columns of F refer to (column k: derivative along frame[k]) and the material id of the mesh.
    struct MaterialPoint
    {
      dealii::Point<dim> place;
      std::array<dealii::Tensor<1, dim>, structure_dim> frame;
      unsigned int material_id = 0;
    };

    virtual ~ConstitutiveLaw() = default;

    /// Fixes the material points; called once, before the evaluations. All arrays below have one
    /// entry per point, in this order; results come as zeros.
    virtual void
    set_points(const std::vector<MaterialPoint> &points)
    {
      (void)points;
    }

    virtual void energy(const std::vector<Matrix> &F, std::vector<double> &W) const = 0;

    virtual void stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const = 0;

    /// dP = d2W/dF2 [dF]
    virtual void stress_derivative(const std::vector<Matrix> &F,
                                   const std::vector<Matrix> &dF,
                                   std::vector<Matrix> &dP) const = 0;

    /// What the law carries from step to step. Collective.
    virtual void
    archive(Archive &)
    {}

    /// Whether P is linear in F, so that dP does not depend on F.
    virtual bool
    linear() const
    {
      return false;
    }

    /// How far the entries of F may be from those of a rotation so that tests may ask for the law
    /// there; a law that is not defined everywhere, or stiffens by orders of magnitude, says less.
    virtual double
    tested_strain() const
    {
      return .9;
    }

    /// Whether W is defined only where det F > 0 (J = sqrt(det F^T F) > 0 for structure_dim < dim).
    virtual bool
    needs_positive_determinant() const
    {
      return false;
    }
  };
} // namespace feib

#endif
