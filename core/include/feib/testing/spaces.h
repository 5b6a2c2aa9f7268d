// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_spaces_h
#define feib_testing_spaces_h

#include <feib/case.h>
#include <feib/eulerian_space.h>
#include <feib/lagrangian_mesh.h>
#include <feib/testing/plugins.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <string>

namespace feib::testing
{
  /// The space of a case's "domain" block, given as JSON.
  template <int dim>
  std::unique_ptr<EulerianSpace<dim>>
  make_space(const std::string &domain, const MPI_Comm communicator = MPI_COMM_WORLD)
  {
    const Case description("{\"dimension\": " + std::to_string(dim) + ", \"domain\": " + domain +
                             ", \"fluid\": {\"navier_stokes\": {\"density\": 1, \"viscosity\": 1}}"
                             ", \"time\": {\"step\": 1, \"end\": 1}}",
                           "test",
                           registry());
    return std::make_unique<EulerianSpace<dim>>(
      Domain<dim>(description.parameters().child("domain")), communicator);
  }

  /// Refines the cells whose centre the predicate picks, once.
  template <int dim, class Predicate>
  void
  refine_where(EulerianSpace<dim> &space, const Predicate &pick)
  {
    space.adapt(
      [&](auto &mesh) {
        for (const auto &cell : mesh.active_cell_iterators())
          if (cell->is_locally_owned() && pick(cell->center()))
            cell->set_refine_flag();
      },
      false);
  }

  /// A box of dimension m cut into simplices: reference coordinates in [0,1]^m, n cells per
  /// direction.
  template <int dim>
  LagrangianMesh<dim>
  make_simplex_mesh(const unsigned int m, const unsigned int n)
  {
    std::vector<dealii::Point<dim>> nodes;
    std::vector<typename LagrangianMesh<dim>::Simplex> simplices;
    const auto number = [&](const std::array<unsigned int, 3> &i) {
      return i[0] + (n + 1) * (i[1] + (n + 1) * i[2]);
    };
    std::array<unsigned int, 3> i{}, top{};
    for (unsigned int a = 0; a < 3; ++a)
      top[a] = a < m ? n : 0;
    for (i[2] = 0; i[2] <= top[2]; ++i[2])
      for (i[1] = 0; i[1] <= top[1]; ++i[1])
        for (i[0] = 0; i[0] <= top[0]; ++i[0])
          {
            dealii::Point<dim> place;
            for (unsigned int a = 0; a < m; ++a)
              place[a] = double(i[a]) / n;
            nodes.push_back(place);
          }
    // Kuhn's division: one simplex for each order in which the axes are walked.
    for (i[2] = 0; i[2] < std::max(1u, top[2]); ++i[2])
      for (i[1] = 0; i[1] < std::max(1u, top[1]); ++i[1])
        for (i[0] = 0; i[0] < top[0]; ++i[0])
          {
            std::vector<unsigned int> order(m);
            std::iota(order.begin(), order.end(), 0u);
            do
              {
                typename LagrangianMesh<dim>::Simplex simplex;
                std::array<unsigned int, 3> corner = i;
                for (unsigned int k = 0; k <= m; ++k)
                  {
                    simplex.nodes[k]   = number(corner);
                    simplex.corners[k] = nodes[number(corner)];
                    if (k < m)
                      ++corner[order[k]];
                  }
                simplices.push_back(simplex);
            } while (std::next_permutation(order.begin(), order.end()));
          }
    return LagrangianMesh<dim>(m, nodes, simplices);
  }
} // namespace feib::testing

#endif
