// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_lattice_h
#define feib_lattice_h

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace feib
{
  template <int dim>
  struct Domain;


  /// The box in integers: places are counted, along each direction from the lower corner, in units
  /// of which the box has a whole number. Cells, nodes and what lies across a periodic boundary are
  /// compared by their places, which round-off cannot part.
  template <int dim>
  class Lattice
  {
  public:
    using Place = std::array<std::int64_t, dim>;

    Lattice() = default;

    /// A unit is a base cell of the box, halved @p halvings times. Throws RunFailure when the keys
    /// of places have no room for so many units.
    Lattice(const Domain<dim> &box, unsigned int halvings);

    /// The number of units along a direction.
    std::int64_t
    extent(const unsigned int direction) const
    {
      return extents[direction];
    }

    bool
    periodic(const unsigned int direction) const
    {
      return periodic_directions[direction];
    }

    /// The physical edges of a unit.
    const dealii::Tensor<1, dim> &
    unit() const
    {
      return unit_size;
    }

    /// The number of units in the box.
    double n_units() const;

    /// A coordinate in units.
    double
    scaled(const double x, const unsigned int direction) const
    {
      return (x - lower[direction]) * per_length[direction];
    }

    /// A point in units.
    dealii::Tensor<1, dim>
    scaled(const dealii::Point<dim> &x) const
    {
      dealii::Tensor<1, dim> result;
      for (unsigned int a = 0; a < dim; ++a)
        result[a] = scaled(x[a], a);
      return result;
    }

    /// The lower corner of the unit that holds x.
    Place
    unit_around(const dealii::Point<dim> &x) const
    {
      Place result;
      for (unsigned int a = 0; a < dim; ++a)
        result[a] = std::int64_t(std::floor(scaled(x[a], a)));
      return result;
    }

    /// The place that x is, but for round-off.
    Place
    nearest(const dealii::Point<dim> &x) const
    {
      Place result;
      for (unsigned int a = 0; a < dim; ++a)
        result[a] = std::lround(scaled(x[a], a));
      return result;
    }

    /// How far a place is on the way through the box along each direction, from 0 to 1: the same,
    /// to the bit, for equal places of other lattices of the box.
    std::array<double, dim>
    share(const Place &place) const
    {
      std::array<double, dim> result;
      for (unsigned int a = 0; a < dim; ++a)
        result[a] = double(place[a]) / double(extents[a]);
      return result;
    }

    /// Wraps periodic directions. Returns false when the place is not in the box; its upper faces
    /// count as in the box if @p closed.
    bool
    wrap(Place &place, const bool closed = false) const
    {
      for (unsigned int a = 0; a < dim; ++a)
        if (periodic_directions[a])
          {
            if (place[a] < 0 || place[a] >= extents[a])
              place[a] = (place[a] % extents[a] + extents[a]) % extents[a];
          }
        else if (place[a] < 0 || place[a] > extents[a] || (!closed && place[a] == extents[a]))
          return false;
      return true;
    }

    /// Another number for every place in the closed box.
    static std::uint64_t
    key(const Place &place)
    {
      std::uint64_t result = 0;
      for (unsigned int a = 0; a < dim; ++a)
        result |= std::uint64_t(place[a]) << bits * a;
      return result;
    }

  private:
    static constexpr unsigned int bits = 64 / dim; // of a key, for each direction

    dealii::Point<dim> lower;
    Place extents{};
    dealii::Tensor<1, dim> unit_size, per_length;
    std::array<bool, dim> periodic_directions{};
  };
} // namespace feib

#endif
