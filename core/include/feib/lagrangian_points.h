// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_lagrangian_points_h
#define feib_lagrangian_points_h

#include <feib/lagrangian_mesh.h>

namespace feib
{
  /// Points that ride on a structure: point q sits at sum_k weight[q n + k] X[node[q n + k]] with
  /// n = nodes_per_point. The nodes themselves are the case n = 1.
  struct LagrangianPoints
  {
    unsigned int nodes_per_point = 1;
    std::vector<unsigned int> node;
    std::vector<double> weight;

    unsigned int
    size() const
    {
      return node.size() / nodes_per_point;
    }

    static LagrangianPoints
    nodes(const unsigned int n_nodes)
    {
      LagrangianPoints points;
      points.node.resize(n_nodes);
      for (unsigned int i = 0; i < n_nodes; ++i)
        points.node[i] = i;
      points.weight.assign(n_nodes, 1.);
      return points;
    }

    /// Whether these are the nodes of a structure of @p n_nodes nodes, in order.
    bool
    are_nodes(const unsigned int n_nodes) const
    {
      if (nodes_per_point != 1 || size() != n_nodes)
        return false;
      for (unsigned int q = 0; q < n_nodes; ++q)
        if (node[q] != q || weight[q] != 1.)
          return false;
      return true;
    }

    /// Where the points are when the nodes are at @p X.
    template <int dim>
    Positions<dim>
    positions(const Positions<dim> &X) const
    {
      Positions<dim> x(*this);
      for (unsigned int q = 0; q < size(); ++q)
        for (unsigned int k = 0; k < nodes_per_point; ++k)
          x[q] += weight[q * nodes_per_point + k] * X[node[q * nodes_per_point + k]];
      return x;
    }
  };


  template <typename Value>
  NodalValues<Value>::NodalValues(const LagrangianPoints &points)
    : values(points.size())
  {}
} // namespace feib

#endif
