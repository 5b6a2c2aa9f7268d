// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/flat_constraints.h>

#include <algorithm>

namespace feib
{
  FlatConstraints::FlatConstraints(const dealii::AffineConstraints<double> &constraints,
                                   const dealii::IndexSet &unknowns,
                                   const dealii::Utilities::MPI::Partitioner &partitioner)
  {
    for (const auto i : unknowns)
      if (constraints.is_constrained(i))
        {
          Line line;
          line.unknown = partitioner.global_to_local(i);
          line.begin   = masters.size();
          for (const auto &entry : *constraints.get_constraint_entries(i))
            {
              masters.push_back(partitioner.global_to_local(entry.first));
              weights.push_back(entry.second);
            }
          line.end   = masters.size();
          line.value = constraints.get_inhomogeneity(i);
          lines.push_back(line);
        }
  }


  dealii::IndexSet
  FlatConstraints::with_masters(dealii::IndexSet unknowns,
                                const dealii::AffineConstraints<double> &constraints)
  {
    std::vector<dealii::types::global_dof_index> masters;
    for (const auto i : unknowns)
      if (constraints.is_constrained(i))
        for (const auto &entry : *constraints.get_constraint_entries(i))
          masters.push_back(entry.first);
    std::sort(masters.begin(), masters.end());
    unknowns.add_indices(masters.begin(), masters.end());
    return unknowns;
  }


  double
  FlatConstraints::value(const Vector &v, const Line &line) const
  {
    double value = 0;
    for (unsigned int k = line.begin; k < line.end; ++k)
      value += weights[k] * v.local_element(masters[k]);
    return value;
  }


  void
  FlatConstraints::condense(Vector &v) const
  {
    const unsigned int n_owned = v.locally_owned_size();
    for (const Line &line : lines)
      if (line.unknown < n_owned)
        {
          const double value            = v.local_element(line.unknown);
          v.local_element(line.unknown) = 0;
          for (unsigned int k = line.begin; k < line.end; ++k)
            v.local_element(masters[k]) += weights[k] * value;
        }
    v.compress(dealii::VectorOperation::add);
  }


  void
  FlatConstraints::distribute(Vector &v, const bool homogeneous) const
  {
    v.update_ghost_values();
    for (const Line &line : lines)
      v.local_element(line.unknown) = value(v, line) + (homogeneous ? 0. : line.value);
  }


  void
  FlatConstraints::approach(const Vector &v, const double share)
  {
    v.update_ghost_values();
    for (Line &line : lines)
      line.value =
        (1 - share) * (v.local_element(line.unknown) - value(v, line)) + share * line.value;
  }
} // namespace feib
