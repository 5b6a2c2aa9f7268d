// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_force_selection_h
#define feib_structure_force_selection_h

#include <feib/lagrangian_mesh.h>
#include <feib/parameters.h>

#include <array>
#include <vector>

namespace feib
{
  /// The part of a structure that a force acts on, key `on` of a case: the elements of some
  /// materials, or the boundary faces of these alone; of these the nodes where an expression says
  /// so.
  template <int dim>
  class Selection
  {
  public:
    /// @p parameters: the block of the force. Throws Error where it selects no node.
    Selection(const Parameters &parameters, const LagrangianMesh<dim> &mesh);

    /// The reference measure that each node stands for, its share of the selected elements or
    /// boundary faces; 0 for nodes that are not selected.
    const std::vector<double> &
    measures() const
    {
      return node_measures;
    }

    /// Of selected elements or faces, those with all nodes selected: their nodes, turned as
    /// LagrangianMesh::Facet says for those of curves, surfaces and boundaries of bodies; and their
    /// reference measure.
    struct Part
    {
      std::array<unsigned int, dim + 1> nodes; // the first n_nodes
      unsigned int n_nodes;
      double measure;
    };

    const std::vector<Part> &
    parts() const
    {
      return part_list;
    }

  private:
    void add(const std::vector<bool> &chosen, Part part);

    std::vector<double> node_measures;
    std::vector<Part> part_list;
  };
} // namespace feib

#endif
