// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/domain.h>
#include <feib/error.h>
#include <feib/lattice.h>

namespace feib
{
  template <int dim>
  Lattice<dim>::Lattice(const Domain<dim> &box, const unsigned int halvings)
    : lower(box.lower)
  {
    constexpr std::int64_t most = (std::int64_t(1) << bits) - 1;
    for (unsigned int a = 0; a < dim; ++a)
      {
        extents[a] = std::int64_t(box.cells[a]) << halvings;
        if (extents[a] > most)
          throw RunFailure(std::string("along ") + "xyz"[a] + ", " + std::to_string(box.cells[a]) +
                           " base cells of 2^" + std::to_string(halvings) + " units each are " +
                           std::to_string(extents[a]) +
                           " units, which places of nodes are counted in; at most " +
                           std::to_string(most) + " are possible in " + std::to_string(dim) +
                           "D: use fewer base cells along " + "xyz"[a] + ", or fewer levels");
        unit_size[a]           = (box.upper[a] - box.lower[a]) / extents[a];
        per_length[a]          = extents[a] / (box.upper[a] - box.lower[a]);
        periodic_directions[a] = box.periodic(a);
      }
  }


  template <int dim>
  double
  Lattice<dim>::n_units() const
  {
    double result = 1;
    for (const std::int64_t extent : extents)
      result *= extent;
    return result;
  }


  template class Lattice<2>;
  template class Lattice<3>;
} // namespace feib
