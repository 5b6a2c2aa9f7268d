// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/error.h>
#include <feib/refinement_strategy/cell_tree.h>

#include <cmath>

namespace feib
{
  namespace
  {
    /// Adds the place when it is in the box; a periodic direction wraps.
    template <int dim>
    void
    add_wrapped(const Lattice<dim> &lattice, Place<dim> place, Places<dim> &places)
    {
      if (lattice.wrap(place))
        places.push_back(place);
    }


    /// The directions that can separate a simplex from a box, apart from the coordinate directions.
    std::vector<dealii::Tensor<1, 2>>
    separating_axes(const std::vector<dealii::Tensor<1, 2>> &corners)
    {
      std::vector<dealii::Tensor<1, 2>> axes;
      for (unsigned int i = 0; i < corners.size(); ++i)
        for (unsigned int j = 0; j < i; ++j)
          axes.push_back(dealii::cross_product_2d(corners[i] - corners[j]));
      return axes;
    }

    std::vector<dealii::Tensor<1, 3>>
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
  } // namespace


  template <int dim>
  void
  add_touched(const Lattice<dim> &lattice,
              const std::vector<dealii::Tensor<1, dim>> &corners,
              Places<dim> &places)
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
        first[d] = std::int64_t(std::floor(min - tolerance));
        last[d]  = std::int64_t(std::floor(max + tolerance));
        if (!lattice.periodic(d))
          {
            first[d] = std::max<std::int64_t>(first[d], 0);
            last[d]  = std::min(last[d], lattice.extent(d) - 1);
          }
        if (first[d] > last[d])
          return;
        one_cell = one_cell && first[d] == last[d];
      }
    if (one_cell)
      {
        add_wrapped(lattice, first, places);
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
          add_wrapped(lattice, place, places);

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
  dilate(const Lattice<dim> &lattice, Places<dim> &places, const long layers)
  {
    for (unsigned int d = 0; d < dim; ++d)
      {
        Places<dim> wider;
        wider.reserve(places.size() * (2 * layers + 1));
        for (Place<dim> place : places)
          {
            place[d] -= layers;
            for (long k = -layers; k <= layers; ++k, ++place[d])
              add_wrapped(lattice, place, wider);
          }
        make_set(wider);
        places.swap(wider);
      }
  }


  template <int dim>
  Places<dim>
  touched_cells(const Lattice<dim> &lattice, const std::vector<ImmersedStructure<dim>> &structures)
  {
    Places<dim> places;
    for (const ImmersedStructure<dim> &structure : structures)
      {
        const StructureModel<dim> &model = *structure.model;
        const LagrangianMesh<dim> &mesh  = model.mesh();
        std::vector<dealii::Tensor<1, dim>> corners(mesh.structure_dim() + 1);
        for (const auto &element : mesh.elements())
          {
            for (unsigned int k = 0; k < corners.size(); ++k)
              {
                corners[k] = lattice.scaled(model.positions[element.nodes[k]]);
                if (!(corners[k].norm() < 1e9))
                  throw RunFailure("structure \"" + model.name() + "\" has left the box");
              }
            add_touched(lattice, corners, places);
          }
        make_set(places);
      }
    return places;
  }


  template <int dim>
  double
  least_touched_cells(const Lattice<dim> &lattice,
                      const std::vector<ImmersedStructure<dim>> &structures)
  {
    // What a plane has in a unit cube at most.
    constexpr double largest_section = dim == 2 ? 1.415 : 1.3;
    double result                    = 0;
    for (const ImmersedStructure<dim> &structure : structures)
      {
        const StructureModel<dim> &model = *structure.model;
        const unsigned int m             = model.mesh().structure_dim();
        double measure                   = 0;
        for (const auto &element : model.mesh().elements())
          {
            std::array<dealii::Tensor<1, dim>, dim> edges;
            for (unsigned int k = 0; k < m; ++k)
              edges[k] = lattice.scaled(model.positions[element.nodes[k + 1]]) -
                         lattice.scaled(model.positions[element.nodes[0]]);
            measure += simplex_measure<dim>(m, edges);
          }
        result += m == dim ? measure : measure / largest_section;
      }
    return result;
  }


  template <int dim>
  CellTree<dim>::CellTree(const Domain<dim> &domain, const int minimum_level, const int level)
    : minimum_level(minimum_level)
    , level(level)
    , splits(level)
  {
    for (int l = 0; l <= level; ++l)
      lattices.emplace_back(domain, l);
  }


  template <int dim>
  void
  CellTree<dim>::ask_for(const int l, Place<dim> place)
  {
    if (l <= minimum_level)
      return;
    for (std::int64_t &coordinate : place)
      coordinate /= 2;
    splits[l - 1].push_back(place);
  }


  template <int dim>
  void
  CellTree<dim>::balance()
  {
    for (int l = level - 1; l >= minimum_level; --l)
      {
        make_set(splits[l]);
        Places<dim> places = splits[l];
        dilate(lattices[l], places, 1);
        for (const Place<dim> &place : places)
          ask_for(l, place);
      }
  }


  template <int dim>
  bool
  CellTree<dim>::too_large(const double n_cells)
  {
    return n_cells > 3e6;
  }


  template <int dim>
  std::uint64_t
  CellTree<dim>::n_cells() const
  {
    std::uint64_t n = lattices[minimum_level].n_units();
    for (int l = minimum_level; l < level; ++l)
      n += ((1u << dim) - 1) * std::uint64_t(splits[l].size());
    return n;
  }


  template <int dim>
  void
  CellTree<dim>::mark(dealii::parallel::distributed::Triangulation<dim> &triangulation,
                      const EulerianSpace<dim> &space) const
  {
    for (const auto &cell : triangulation.active_cell_iterators())
      if (cell->is_locally_owned())
        {
          const int l = space.level(*cell);
          if (l > level)
            cell->set_coarsen_flag();
          else if (is_split(l, cell->center()))
            cell->set_refine_flag();
          else if (l > 0 && !is_split(l - 1, cell->center()))
            cell->set_coarsen_flag();
        }
  }


  template <int dim>
  bool
  CellTree<dim>::is_split(const int l, const dealii::Point<dim> &x) const
  {
    return l < level &&
           (l < minimum_level ||
            std::binary_search(splits[l].begin(), splits[l].end(), lattices[l].unit_around(x)));
  }


  template void
  add_touched(const Lattice<2> &, const std::vector<dealii::Tensor<1, 2>> &, Places<2> &);
  template void dilate(const Lattice<2> &, Places<2> &, long);
  template Places<2> touched_cells(const Lattice<2> &, const std::vector<ImmersedStructure<2>> &);
  template double least_touched_cells(const Lattice<2> &,
                                      const std::vector<ImmersedStructure<2>> &);
  template class CellTree<2>;
  template void
  add_touched(const Lattice<3> &, const std::vector<dealii::Tensor<1, 3>> &, Places<3> &);
  template void dilate(const Lattice<3> &, Places<3> &, long);
  template Places<3> touched_cells(const Lattice<3> &, const std::vector<ImmersedStructure<3>> &);
  template double least_touched_cells(const Lattice<3> &,
                                      const std::vector<ImmersedStructure<3>> &);
  template class CellTree<3>;
} // namespace feib
