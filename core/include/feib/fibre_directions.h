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
  /// array of dim expressions of the reference coordinates for each family. A direction is
  /// projected on the frame of the element and normalised. An empty array means one family along
  /// the curve, and is an error for bodies and surfaces.
  template <int structure_dim, int dim>
  class FibreDirections
  {
  public:
    /// Components in the frame of the material point.
    using Direction = dealii::Tensor<1, structure_dim>;

    /// Throws Error for expressions that do not parse, or for no fibres where they are needed.
    explicit FibreDirections(const Parameters &parameters);

    /// Evaluates the expressions. Throws Error where a direction vanishes or is not finite.
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
    std::string pointer;
    std::vector<std::unique_ptr<dealii::Function<dim>>> functions;
    unsigned int families;
    std::vector<Direction> directions;
  };
} // namespace feib

#endif
