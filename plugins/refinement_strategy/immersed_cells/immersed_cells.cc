// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/refinement_strategy.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "immersed_cells_schema.h"

namespace
{
  using namespace dealii;

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
    Lattice(const feib::Domain<dim> &domain, const unsigned int level)
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
    Tensor<1, dim>
    scaled(const Point<dim> &x) const
    {
      Tensor<1, dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d] = (x[d] - lower[d]) * inverse_size[d];
      return result;
    }

    Place<dim>
    place(const Point<dim> &x) const
    {
      const Tensor<1, dim> y = scaled(x);
      Place<dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d] = static_cast<long>(std::floor(y[d]));
      return result;
    }

    /// Adds the cells that the simplex of these (scaled) corners touches, by separating axes: a
    /// cell is left out when there is a direction along which it and the simplex do not overlap.
    void add_touched(const std::vector<Tensor<1, dim>> &corners, Places<dim> &places) const;

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

    Point<dim> lower;
    Tensor<1, dim> inverse_size;
    Place<dim> n;
    std::array<bool, dim> periodic;
  };


  /// The directions that can separate a simplex from a box, apart from the coordinate directions.
  std::vector<Tensor<1, 2>>
  separating_axes(const std::vector<Tensor<1, 2>> &corners)
  {
    std::vector<Tensor<1, 2>> axes;
    for (unsigned int i = 0; i < corners.size(); ++i)
      for (unsigned int j = 0; j < i; ++j)
        axes.push_back(cross_product_2d(corners[i] - corners[j]));
    return axes;
  }

  std::vector<Tensor<1, 3>>
  separating_axes(const std::vector<Tensor<1, 3>> &corners)
  {
    std::vector<Tensor<1, 3>> edges, axes;
    for (unsigned int i = 0; i < corners.size(); ++i)
      for (unsigned int j = 0; j < i; ++j)
        edges.push_back(corners[i] - corners[j]);
    for (unsigned int e = 0; e < edges.size(); ++e)
      {
        for (unsigned int f = 0; f < e; ++f)
          axes.push_back(cross_product_3d(edges[e], edges[f]));
        for (unsigned int d = 0; d < 3; ++d)
          axes.push_back(cross_product_3d(edges[e], Point<3>::unit_vector(d)));
      }
    return axes;
  }


  template <int dim>
  void
  Lattice<dim>::add_touched(const std::vector<Tensor<1, dim>> &corners, Places<dim> &places) const
  {
    // What touches a cell counts, whatever round-off says: a structure on a grid line marks both
    // sides.
    constexpr double tolerance = 1e-9;

    Place<dim> first, last;
    bool one_cell = true;
    for (unsigned int d = 0; d < dim; ++d)
      {
        double min = corners[0][d], max = corners[0][d];
        for (const Tensor<1, dim> &corner : corners)
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
      Tensor<1, dim> axis;
      double min, max, cube_min, cube_max;
    };
    std::vector<Shadow> shadows;
    for (const Tensor<1, dim> &axis : separating_axes(corners))
      {
        Shadow shadow{axis, corners[0] * axis, corners[0] * axis, 0, 0};
        for (const Tensor<1, dim> &corner : corners)
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
        Tensor<1, dim> origin;
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


  template <int dim>
  class ImmersedCells : public feib::RefinementStrategy<dim>
  {
  public:
    explicit ImmersedCells(const feib::Parameters &parameters)
      : level(parameters.integer("level"))
      , minimum_level(parameters.integer("minimum_level"))
      , buffer(parameters.integer("buffer"))
      , steps(parameters.integer("interval"))
    {
      if (minimum_level > level)
        parameters.fail("minimum_level",
                        "is " + std::to_string(minimum_level) + ", must be at most the level, " +
                          std::to_string(level));
    }

    void
    mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
         const feib::EulerianSpace<dim> &space,
         const std::vector<feib::ImmersedStructure<dim>> &structures) const override
    {
      std::vector<Lattice<dim>> lattices;
      for (int l = 0; l <= level; ++l)
        lattices.emplace_back(space.domain(), l);
      const std::vector<Places<dim>> parents = cells_to_split(lattices, structures);
      const auto is_split                    = [&](const int l, const Place<dim> &place) {
        return l < level && (l < minimum_level ||
                             std::binary_search(parents[l].begin(), parents[l].end(), place));
      };

      for (const auto &cell : triangulation.active_cell_iterators())
        if (cell->is_locally_owned())
          {
            const int l = cell->level();
            if (l > level)
              cell->set_coarsen_flag();
            else if (is_split(l, lattices[l].place(cell->center())))
              cell->set_refine_flag();
            else if (l > 0 && !is_split(l - 1, lattices[l - 1].place(cell->center())))
              cell->set_coarsen_flag();
          }
    }

    unsigned int
    interval() const override
    {
      return steps;
    }

  private:
    /// The cells of each level below the finest that have to be split. The neighbours of a cell
    /// that is split must exist, so their parents are split as well: the mesh that is asked for is
    /// balanced by itself, and once it is reached no cell is marked.
    std::vector<Places<dim>>
    cells_to_split(const std::vector<Lattice<dim>> &lattices,
                   const std::vector<feib::ImmersedStructure<dim>> &structures) const
    {
      std::vector<Places<dim>> result(level);
      Places<dim> places = touched_cells(lattices[level], structures);
      lattices[level].dilate(places, buffer);
      for (int l = level - 1; l >= 0; --l)
        {
          for (Place<dim> &place : places)
            for (long &coordinate : place)
              coordinate /= 2;
          make_set(places);
          result[l] = places;
          lattices[l].dilate(places, 1);
        }
      return result;
    }

    /// The cells of the finest level that hold elements.
    Places<dim>
    touched_cells(const Lattice<dim> &lattice,
                  const std::vector<feib::ImmersedStructure<dim>> &structures) const
    {
      Places<dim> places;
      for (const feib::ImmersedStructure<dim> &structure : structures)
        {
          const feib::StructureModel<dim> &model = *structure.model;
          const feib::LagrangianMesh<dim> &mesh  = model.mesh();
          std::vector<Tensor<1, dim>> corners(mesh.structure_dim() + 1);
          for (const auto &element : mesh.elements())
            {
              for (unsigned int k = 0; k < corners.size(); ++k)
                {
                  corners[k] = lattice.scaled(model.positions[element.nodes[k]]);
                  if (!(corners[k].norm() < 1e9))
                    throw feib::RunFailure("structure \"" + model.name() + "\" has left the box");
                }
              lattice.add_touched(corners, places);
            }
          make_set(places);
        }
      return places;
    }

    const int level, minimum_level;
    const long buffer;
    const unsigned int steps;
  };
} // namespace


FEIB_PLUGIN("immersed_cells", "1.0", registry)
{
  registry.add<feib::RefinementStrategy, ImmersedCells>("immersed_cells", immersed_cells_schema);
}
