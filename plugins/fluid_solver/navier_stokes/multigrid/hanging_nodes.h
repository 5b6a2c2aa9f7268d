// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_hanging_nodes_h
#define feib_plugins_navier_stokes_hanging_nodes_h

#include <unordered_map>
#include <utility>
#include <vector>

namespace feib
{
  /// The hanging nodes of a level and the nodes that give them their values. A node is known by the
  /// number of its first unknown, dim * node.
  template <int dim>
  class HangingNodes
  {
  public:
    using Masters = std::vector<std::pair<unsigned int, double>>; // node, weight

    void
    add(const unsigned int node, const Masters &of_node)
    {
      slaves.push_back(node);
      for (const auto &[master, weight] : of_node)
        {
          masters.push_back(master);
          weights.push_back(weight);
        }
      first_master.push_back(masters.size());
    }

    /// Calls every node by the name rename(node).
    template <class Rename>
    void
    rename(const Rename &rename)
    {
      for (auto *list : {&slaves, &masters})
        for (unsigned int &node : *list)
          node = rename(node);
      line_of_slave.clear();
      for (unsigned int s = 0; s < slaves.size(); ++s)
        line_of_slave[slaves[s]] = s;
    }

    const std::vector<unsigned int> &
    nodes() const
    {
      return slaves;
    }

    /// Where the value of a node comes from: of one that does not hang, from itself.
    void
    find_masters(const unsigned int node, Masters &result) const
    {
      const auto found = line_of_slave.find(node);
      result.clear();
      if (found == line_of_slave.end())
        result.emplace_back(node, 1.);
      else
        for (unsigned int m = first_master[found->second]; m < first_master[found->second + 1]; ++m)
          result.emplace_back(masters[m], weights[m]);
    }

    /// Gives hanging nodes their values.
    template <typename Number>
    void
    expand(Number *values) const
    {
      for (unsigned int s = 0; s < slaves.size(); ++s)
        for (unsigned int a = 0; a < dim; ++a)
          {
            double value = 0;
            for (unsigned int m = first_master[s]; m < first_master[s + 1]; ++m)
              value += weights[m] * values[masters[m] + a];
            values[slaves[s] + a] = value;
          }
    }

    /// The transpose: what hanging nodes have goes to their masters.
    template <typename Number>
    void
    condense(Number *values) const
    {
      for (unsigned int s = 0; s < slaves.size(); ++s)
        for (unsigned int a = 0; a < dim; ++a)
          {
            const Number value = values[slaves[s] + a];
            for (unsigned int m = first_master[s]; m < first_master[s + 1]; ++m)
              values[masters[m] + a] += weights[m] * value;
            values[slaves[s] + a] = 0;
          }
    }

  private:
    std::vector<unsigned int> slaves, first_master = {0}, masters;
    std::vector<double> weights;
    std::unordered_map<unsigned int, unsigned int> line_of_slave;
  };
} // namespace feib

#endif
