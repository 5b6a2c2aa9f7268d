// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_refinement_strategy_cell_tree_h
#define feib_refinement_strategy_cell_tree_h

#include <feib/eulerian_space.h>
#include <feib/immersed_structure.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace feib
{
  /// Integer coordinates of a cell among all cells of its level.
  template <int dim>
  using Place = std::array<long, dim>;

  /// A sorted set of places.
  template <int dim>
  using Places = std::vector<Place<dim>>;

  template <typename T>
  void
  make_set(std::vector<T> &places)
  {
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
  }


  /// The cells of one level of the forest, as a lattice of unit cubes.
  template <int dim>
  class Lattice
  {
  public:
    Lattice(const Domain<dim> &domain, const unsigned int level)
      : lower(domain.lower)
    {
      for (unsigned int d = 0; d < dim; ++d)
        {
          n[d]            = static_cast<long>(domain.cells[d]) << level;
          inverse_size[d] = n[d] / (domain.upper[d] - domain.lower[d]);
          periodic[d]     = domain.periodic(d);
        }
    }

    /// A point in units of the lattice.
    dealii::Tensor<1, dim>
    scaled(const dealii::Point<dim> &x) const
    {
      dealii::Tensor<1, dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d] = (x[d] - lower[d]) * inverse_size[d];
      return result;
    }

    Place<dim>
    place(const dealii::Point<dim> &x) const
    {
      const dealii::Tensor<1, dim> y = scaled(x);
      Place<dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d] = static_cast<long>(std::floor(y[d]));
      return result;
    }

    /// Number of cells of the level.
    std::uint64_t
    n_cells() const
    {
      std::uint64_t result = 1;
      for (const long count : n)
        result *= count;
      return result;
    }

    /// Adds the cells that the simplex of these (scaled) corners touches, by separating axes: a
    /// cell is left out when there is a direction along which it and the simplex do not overlap.
    void add_touched(const std::vector<dealii::Tensor<1, dim>> &corners, Places<dim> &places) const;

    /// Adds @p layers of neighbours, across corners too.
    void dilate(Places<dim> &places, const long layers) const;

  private:
    /// Adds the cell, when it exists; a periodic direction wraps.
    void
    add(Place<dim> place, Places<dim> &places) const
    {
      for (unsigned int d = 0; d < dim; ++d)
        if (periodic[d])
          place[d] = ((place[d] % n[d]) + n[d]) % n[d];
        else if (place[d] < 0 || place[d] >= n[d])
          return;
      places.push_back(place);
    }

    dealii::Point<dim> lower;
    dealii::Tensor<1, dim> inverse_size;
    Place<dim> n;
    std::array<bool, dim> periodic;
  };


  /// The directions that can separate a simplex from a box, apart from the coordinate directions.
  inline std::vector<dealii::Tensor<1, 2>>
  separating_axes(const std::vector<dealii::Tensor<1, 2>> &corners)
  {
    std::vector<dealii::Tensor<1, 2>> axes;
    for (unsigned int i = 0; i < corners.size(); ++i)
      for (unsigned int j = 0; j < i; ++j)
        axes.push_back(dealii::cross_product_2d(corners[i] - corners[j]));
    return axes;
  }

  inline std::vector<dealii::Tensor<1, 3>>
  separating_axes(const std::vector<dealii::Tensor<1, 3>> &corners)
  {
    std::vector<dealii::Tensor<1, 3>> edges, axes;
    for (unsigned int i = 0; i < corners.size(); ++i)
      for (unsigned int j = 0; j < i; ++j)
        edges.push_back(corners[i] - corners[j]);
    for (unsigned int e = 0; e < edges.size(); ++e)
      {
        for (unsigned int f = 0; f < e; ++f)
          axes.push_back(dealii::cross_product_3d(edges[e], edges[f]));
        for (unsigned int d = 0; d < 3; ++d)
          axes.push_back(dealii::cross_product_3d(edges[e], dealii::Point<3>::unit_vector(d)));
      }
    return axes;
  }


  template <int dim>
  void
  Lattice<dim>::add_touched(const std::vector<dealii::Tensor<1, dim>> &corners,
                            Places<dim> &places) const
  {
    // What touches a cell counts, whatever round-off says: a structure on a grid line marks both
    // sides.
    constexpr double tolerance = 1e-9;

    Place<dim> first, last;
    bool one_cell = true;
    for (unsigned int d = 0; d < dim; ++d)
      {
        double min = corners[0][d], max = corners[0][d];
        for (const dealii::Tensor<1, dim> &corner : corners)
          {
            min = std::min(min, corner[d]);
            max = std::max(max, corner[d]);
          }
        first[d] = static_cast<long>(std::floor(min - tolerance));
        last[d]  = static_cast<long>(std::floor(max + tolerance));
        if (!periodic[d])
          {
            first[d] = std::max(first[d], 0L);
            last[d]  = std::min(last[d], n[d] - 1);
          }
        if (first[d] > last[d])
          return;
        one_cell = one_cell && first[d] == last[d];
      }
    if (one_cell)
      {
        add(first, places);
        return;
      }

    // The simplex and the unit cube at the origin as intervals along each axis.
    struct Shadow
    {
      dealii::Tensor<1, dim> axis;
      double min, max, cube_min, cube_max;
    };
    std::vector<Shadow> shadows;
    for (const dealii::Tensor<1, dim> &axis : separating_axes(corners))
      {
        Shadow shadow{axis, corners[0] * axis, corners[0] * axis, 0, 0};
        for (const dealii::Tensor<1, dim> &corner : corners)
          {
            shadow.min = std::min(shadow.min, corner * axis);
            shadow.max = std::max(shadow.max, corner * axis);
          }
        const double slack = tolerance * axis.norm();
        shadow.min -= slack;
        shadow.max += slack;
        for (unsigned int d = 0; d < dim; ++d)
          (axis[d] < 0 ? shadow.cube_min : shadow.cube_max) += axis[d];
        shadows.push_back(shadow);
      }

    Place<dim> place = first;
    while (true)
      {
        dealii::Tensor<1, dim> origin;
        for (unsigned int d = 0; d < dim; ++d)
          origin[d] = place[d];
        if (std::none_of(shadows.begin(), shadows.end(), [&origin](const Shadow &shadow) {
              const double cube = origin * shadow.axis;
              return cube + shadow.cube_max < shadow.min || cube + shadow.cube_min > shadow.max;
            }))
          add(place, places);

        unsigned int d = 0;
        while (d < dim && ++place[d] > last[d])
          {
            place[d] = first[d];
            ++d;
          }
        if (d == dim)
          return;
      }
  }

  template <int dim>
  void
  Lattice<dim>::dilate(Places<dim> &places, const long layers) const
  {
    for (unsigned int d = 0; d < dim; ++d)
      {
        Places<dim> wider;
        wider.reserve(places.size() * (2 * layers + 1));
        for (Place<dim> place : places)
          {
            place[d] -= layers;
            for (long k = -layers; k <= layers; ++k, ++place[d])
              add(place, wider);
          }
        make_set(wider);
        places.swap(wider);
      }
  }


  /// The cells of one level that elements of the structures touch. Throws RunFailure.
  template <int dim>
  Places<dim> touched_cells(const Lattice<dim> &lattice,
                            const std::vector<ImmersedStructure<dim>> &structures);

  /// A number of cells that elements of the structures touch at least, from their measure.
  template <int dim>
  double least_touched_cells(const Lattice<dim> &lattice,
                             const std::vector<ImmersedStructure<dim>> &structures);


  /// The mesh that a strategy asks for, as the cells that are split: the same on all ranks, and
  /// balanced by itself, so that the mesh that is asked for is the mesh that comes out.
  template <int dim>
  class CellTree
  {
  public:
    /// All cells coarser than @p minimum_level are split, and none of @p level.
    CellTree(const Domain<dim> &domain, int minimum_level, int level);

    const Lattice<dim> &
    lattice(const int l) const
    {
      return lattices[l];
    }

    /// Asks for the cell of level @p l at @p place to exist: its parent is split.
    void ask_for(int l, Place<dim> place);

    /// Splits what else has to be: the neighbours of a cell that is split must exist.
    void balance();

    /// Whether the places of so many cells are too many to hold, so that an estimate of their
    /// number must do.
    static bool too_large(double n_cells);

    /// Number of active cells of the mesh.
    std::uint64_t n_cells() const;

    /// Sets the flags of the locally owned cells that lead towards this mesh, level by level.
    void mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
              const EulerianSpace<dim> &space) const;

  private:
    /// Whether the cell of level @p l around @p x is split.
    bool is_split(int l, const dealii::Point<dim> &x) const;

    int minimum_level, level;
    std::vector<Lattice<dim>> lattices;
    std::vector<Places<dim>> splits;
  };
} // namespace feib

#endif
