// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/error.h>
#include <feib/refinement_strategy/cell_tree.h>

namespace feib
{
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
            lattice.add_touched(corners, places);
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
            dealii::Tensor<1, dim> edges[dim];
            for (unsigned int k = 0; k < m; ++k)
              edges[k] = lattice.scaled(model.positions[element.nodes[k + 1]]) -
                         lattice.scaled(model.positions[element.nodes[0]]);
            dealii::Tensor<2, dim> gram;
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j)
                gram[i][j] = i < m && j < m ? edges[i] * edges[j] : double(i == j);
            measure += std::sqrt(std::max(0., dealii::determinant(gram))) / (m == 3 ? 6 : m);
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
    for (long &coordinate : place)
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
        lattices[l].dilate(places, 1);
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
    std::uint64_t n = lattices[minimum_level].n_cells();
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
            std::binary_search(splits[l].begin(), splits[l].end(), lattices[l].place(x)));
  }


  template Places<2> touched_cells(const Lattice<2> &, const std::vector<ImmersedStructure<2>> &);
  template double least_touched_cells(const Lattice<2> &,
                                      const std::vector<ImmersedStructure<2>> &);
  template class CellTree<2>;
  template Places<3> touched_cells(const Lattice<3> &, const std::vector<ImmersedStructure<3>> &);
  template double least_touched_cells(const Lattice<3> &,
                                      const std::vector<ImmersedStructure<3>> &);
  template class CellTree<3>;
} // namespace feib
