// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_fibre_directions_h
#define feib_fibre_directions_h

#include <feib/constitutive_law.h>

#include <deal.II/base/function.h>

#include <memory>
#include <string>
#include <vector>

namespace feib
{
  /// The unit directions of families of fibres, from the key "fibres" of a law: an array with one
  /// array of dim expressions of the reference coordinates for each family, or the name of data of
  /// the mesh file. A direction is projected on the frame of the element and normalised. An empty
  /// array means one family along the curve, and is an error for bodies and surfaces.
  template <int structure_dim, int dim>
  class FibreDirections
  {
  public:
    /// Components in the frame of the material point.
    using Direction = dealii::Tensor<1, structure_dim>;

    /// Throws Error for expressions that do not parse, or for no fibres where they are needed.
    explicit FibreDirections(const Parameters &parameters);

    /// Evaluates the expressions. Throws Error where a direction vanishes or is not finite, and
    /// where the mesh has no data of the name.
    void set_points(
      const std::vector<typename ConstitutiveLaw<structure_dim, dim>::MaterialPoint> &points);

    unsigned int
    n_families() const
    {
      return families;
    }

    const Direction &
    operator()(const unsigned int point, const unsigned int family) const
    {
      return directions[point * families + family];
    }

  private:
    using MaterialPoint = typename ConstitutiveLaw<structure_dim, dim>::MaterialPoint;

    struct Family
    {
      std::unique_ptr<dealii::Function<dim>> expressions; // or null:
      std::string data;                                   // of the mesh file
    };

    /// The direction of a family as it is given, in reference coordinates.
    dealii::Tensor<1, dim> given(unsigned int family, const MaterialPoint &point) const;

    std::string pointer;
    std::vector<Family> given_families; // none: along the curve
    unsigned int families;
    std::vector<Direction> directions;
  };
} // namespace feib

#endif
