// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_domain_h
#define feib_domain_h

#include <feib/boundary_condition.h>
#include <feib/parameters.h>

#include <deal.II/base/point.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace feib
{
  /// Within this distance of a face of the box, which goes from @p lower to @p upper across the
  /// face, a point counts as on it: coordinates come from sums, expressions and files.
  inline double
  round_off(const double lower, const double upper)
  {
    return 1e-10 * (upper - lower) +
           16 * std::numeric_limits<double>::epsilon() * std::max(std::abs(lower), std::abs(upper));
  }

  /// The box, its base cells and what holds on its faces, from the block "domain" of a case.
  template <int dim>
  struct Domain
  {
    /// Throws Error (lower >= upper, a face of a periodic direction with a condition, more cells
    /// along a direction than a Lattice has room for, ...).
    explicit Domain(const Parameters &parameters);

    /// A box with no slip on all faces.
    Domain(const dealii::Point<dim> &lower,
           const dealii::Point<dim> &upper,
           const std::array<unsigned int, dim> &cells);

    /// The number, in conditions, of the one that holds on a face at a place there.
    unsigned int
    condition_at(const unsigned int face, const dealii::Point<dim> &x) const
    {
      unsigned int i = first_of_face[face];
      while (conditions[i].where && !(conditions[i].where->value(x) > 0))
        ++i;
      return i;
    }

    /// The number of the condition that a node on a face at @p x keeps, the velocity in all
    /// directions by itself: where parts of the face meet (within round_off()), also at a periodic
    /// seam, of the first kind of those there, and of one that is tight.
    unsigned int
    condition_at_node(const unsigned int face, const dealii::Point<dim> &x) const
    {
      unsigned int best = condition_at(face, x);
      if (!conditions[first_of_face[face]].where)
        return best;
      for (unsigned int side = 0; side < (1 << dim); ++side)
        {
          dealii::Point<dim> beside = x;
          for (unsigned int a = 0; a < dim; ++a)
            if (a != face / 2)
              {
                const double r = round_off(lower[a], upper[a]);
                beside[a] += side >> a & 1 ? r : -r;
                if (beside[a] > upper[a])
                  beside[a] = periodic(a) ? lower[a] + r : upper[a];
                if (beside[a] < lower[a])
                  beside[a] = periodic(a) ? upper[a] - r : lower[a];
              }
          const unsigned int there = condition_at(face, beside);
          const auto rank          = [this](const unsigned int c) {
            return std::make_pair(conditions[c].kind, !conditions[c].tight);
          };
          if (rank(there) < rank(best))
            best = there;
        }
      return best;
    }

    /// A place that is @p share of the way from lower to upper along each direction. Equal
    /// fractions give equal places, to the bit.
    dealii::Point<dim>
    place(const std::array<double, dim> &share) const
    {
      dealii::Point<dim> x;
      for (unsigned int a = 0; a < dim; ++a)
        x[a] = lower[a] + (upper[a] - lower[a]) * share[a];
      return x;
    }

    /// [length^dim]
    double
    volume() const
    {
      double result = 1;
      for (unsigned int a = 0; a < dim; ++a)
        result *= upper[a] - lower[a];
      return result;
    }

    /// Whether no fluid can cross the boundary freely, so that the pressure is known up to a
    /// constant.
    bool enclosed() const;

    /// Whether a velocity on a face changes with time.
    bool time_dependent() const;

    bool
    periodic(const unsigned int direction) const
    {
      return conditions[first_of_face[2 * direction]].periodic();
    }

    /// The directions that a point cannot leave its place in, as it lies in a tight face across
    /// them (within round_off()).
    std::array<bool, dim> held(const dealii::Point<dim> &x) const;

    /// The most cells a mesh may have, refined ones included.
    static constexpr double most_cells = 1e8;

    std::string pointer; // of the block in the case
    dealii::Point<dim> lower, upper;
    std::array<unsigned int, dim> cells;
    std::vector<BoundaryCondition<dim>> conditions; // of x_min, x_max, y_min, ...

  private:
    void read_boundary(const Parameters &boundary, const std::array<bool, dim> &is_periodic);

    /// What is said of a face.
    void read_face(const Parameters &parameters, unsigned int face);

    /// Refuses fluxes prescribed where no pressure is known.
    void check_regulated() const;

    std::array<unsigned int, 2 * dim> first_of_face{}; // in conditions
  };
} // namespace feib

#endif
