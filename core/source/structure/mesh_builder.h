// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_mesh_builder_h
#define feib_mesh_builder_h

#include <feib/lagrangian_mesh.h>
#include <feib/message.h>
#include <feib/parameters.h>

#include <cmath>

// What those who build meshes share.
namespace feib
{
  /// Nodes and simplices while a mesh is being built.
  template <int dim>
  struct Builder
  {
    explicit Builder(const MPI_Comm communicator)
      : communicator(communicator)
    {}

    const MPI_Comm communicator;
    std::vector<dealii::Point<dim>> nodes;
    std::vector<typename LagrangianMesh<dim>::Simplex> simplices;

    unsigned int
    node(const dealii::Point<dim> &place)
    {
      nodes.push_back(place);
      return nodes.size() - 1;
    }

    /// A simplex whose corners are where its nodes are.
    void
    simplex(const std::vector<unsigned int> &vertices, const unsigned int material_id = 0)
    {
      simplices.emplace_back();
      simplices.back().material_id = material_id;
      for (unsigned int k = 0; k < vertices.size(); ++k)
        {
          simplices.back().nodes[k]   = vertices[k];
          simplices.back().corners[k] = nodes[vertices[k]];
        }
    }

    LagrangianMesh<dim>
    build(const unsigned int structure_dim, std::vector<std::uint64_t> node_numbers = {})
    {
      return LagrangianMesh<dim>(
        structure_dim, std::move(nodes), simplices, std::move(node_numbers), communicator);
    }
  };

  template <int dim>
  dealii::Point<dim>
  point(const Parameters &block, const std::string &key)
  {
    const std::vector<double> numbers = block.numbers(key);
    dealii::Point<dim> result;
    for (unsigned int i = 0; i < dim; ++i)
      result[i] = numbers[i];
    return result;
  }

  /// Far too many elements are a mistake, not a wish.
  inline void
  check_number(const Parameters &block, const std::string &key, const double n_elements)
  {
    if (n_elements > 1e8)
      block.fail(key,
                 "gives " + std::to_string(std::llround(n_elements / 1e6)) +
                   " million elements, at most 100 million are allowed");
  }

  inline std::vector<int>
  cells(const Parameters &block, const double simplices_per_cell)
  {
    std::vector<int> n = block.integers("cells");
    double total       = simplices_per_cell;
    for (const int n_k : n)
      total *= n_k;
    check_number(block, "cells", total);
    return n;
  }

  template <int dim>
  void
  check_corners(const Parameters &block,
                const dealii::Point<dim> &lower,
                const dealii::Point<dim> &upper)
  {
    for (unsigned int i = 0; i < dim; ++i)
      if (!(lower[i] < upper[i]))
        block.fail("upper",
                   "must be greater than \"lower\" in every direction, found " +
                     readable(upper[i]) + " and " + readable(lower[i]));
  }

  /// A grid of n x k quadrilaterals, cut along the same diagonal; @p place: from indices to
  /// reference coordinates; @p periodic: the n-th column is the first. As a surface its
  /// normal is that of the directions of the two indices.
  template <int dim, typename Place>
  LagrangianMesh<dim>
  grid(const MPI_Comm communicator,
       const unsigned int n,
       const unsigned int k,
       const bool periodic,
       const Place &place)
  {
    Builder<dim> builder(communicator);
    const unsigned int columns = periodic ? n : n + 1;
    for (unsigned int j = 0; j <= k; ++j)
      for (unsigned int i = 0; i < columns; ++i)
        builder.node(place(i, j));
    const auto triangle = [&](const std::array<std::array<unsigned int, 2>, 3> &corners) {
      builder.simplices.emplace_back();
      for (unsigned int c = 0; c < 3; ++c)
        {
          const auto [i, j]                   = corners[c];
          builder.simplices.back().nodes[c]   = j * columns + i % columns;
          builder.simplices.back().corners[c] = place(i, j);
        }
    };
    for (unsigned int j = 0; j < k; ++j)
      for (unsigned int i = 0; i < n; ++i)
        {
          triangle({{{{i, j}}, {{i + 1, j}}, {{i + 1, j + 1}}}});
          triangle({{{{i, j}}, {{i + 1, j + 1}}, {{i, j + 1}}}});
        }
    return builder.build(2);
  }
} // namespace feib

#endif
