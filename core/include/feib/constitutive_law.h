// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_constitutive_law_h
#define feib_constitutive_law_h

#include <feib/archive.h>
#include <feib/parameters.h>

#include <deal.II/base/array_view.h>
#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <array>
#include <map>
#include <string>
#include <vector>

namespace feib
{
  /// A constitutive law: an energy W(F), P = dW/dF and dP(F)[dF] for arrays of deformation
  /// gradients, and what it says beside. F and P are matrices of dim rows and structure_dim
  /// columns, F[i][k] = dX_i/ds_k. W is an energy per reference volume (structure_dim = dim) or per
  /// reference length or area (structure_dim = dim-1).
  ///
  /// Beside F these functions may depend on the moment(): on time, and on state variables, numbers
  /// at each point that the structure keeps. The state is held during a step: within it W is an
  /// energy and P its derivative, for all schemes alike. At the end of the step update_state()
  /// moves the state on, and what W loses by that is dissipated. A law whose state changes on the
  /// way of a step is therefore given by its incremental potential, W(F) = what is stored with the
  /// state of F plus what is dissipated on the way there from the state held; then P is as exact as
  /// the scheme (Ortiz, Stainier, Comput. Methods Appl. Mech. Engrg. 171 (1999) 419).
  ///
  /// A part of the stress may depend on dF/dt, viscous_stress(). Every scheme takes it at the
  /// velocity it computes, so that it dissipates and limits no step.
  template <int structure_dim, int dim>
  class ConstitutiveLaw
  {
  public:
    static constexpr const char *kind = "constitutive_law";

    using Matrix = dealii::Tensor<1, dim, dealii::Tensor<1, structure_dim>>;

    /// Where a deformation gradient is taken: reference coordinates, the orthonormal frame that the
    /// columns of F refer to (column k: derivative along frame[k]), the material id of the mesh,
    /// its name where the mesh's file has one, and the data its file has for the element, by name,
    /// up to three numbers each.
    struct MaterialPoint
    {
      dealii::Point<dim> place;
      std::array<dealii::Tensor<1, dim>, structure_dim> frame;
      unsigned int material_id = 0;
      std::string material;
      std::map<std::string, dealii::Tensor<1, 3>> data;
    };

    /// What a law may ask for beside F.
    struct Moment
    {
      double time    = 0;
      double elapsed = 0;                     // since the state was the present one [time]
      std::vector<std::vector<double>> state; // state[v][q]: variable v at point q
    };

    struct StateVariable
    {
      std::string name; // a word, for the output
      double initial = 0;
    };

    virtual ~ConstitutiveLaw() = default;

    /// The state variables, none for most laws; asked once, after set_points().
    virtual std::vector<StateVariable>
    state_variables() const
    {
      return {};
    }

    /// What moment() is from now on; @p moment must outlive the evaluations.
    virtual void
    set_moment(const Moment &moment)
    {
      present = &moment;
    }

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

    /// From F at the end of a step and the state that was held, moment().state, to the state from
    /// then on; @p state comes as the one held. The same whenever it is asked.
    virtual void
    update_state(const std::vector<Matrix> &F, std::vector<std::vector<double>> &state) const
    {
      (void)F;
      (void)state;
    }

    /// Whether there is a viscous_stress().
    virtual bool
    viscous() const
    {
      return false;
    }

    /// The part of the stress that depends on @p rate, dF/dt: linear in it, P(rate) : other =
    /// P(other) : rate (it has a dissipation potential), P : rate >= 0, and zero where the
    /// structure turns as a whole.
    virtual void
    viscous_stress(const std::vector<Matrix> &F,
                   const std::vector<Matrix> &rate,
                   std::vector<Matrix> &P) const
    {
      (void)rate;
      P.assign(F.size(), Matrix());
    }

    /// What the law itself carries from step to step, beside its state variables. Collective.
    virtual void
    archive(Archive &)
    {}

    /// Whether W depends on moment().time or moment().elapsed.
    virtual bool
    time_dependent() const
    {
      return false;
    }

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

  protected:
    const Moment &
    moment() const
    {
      return *present;
    }

  private:
    static inline const Moment start;
    const Moment *present = &start;
  };
} // namespace feib

#endif
