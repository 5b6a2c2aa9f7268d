// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_divergence_free_sheet_h
#define feib_divergence_free_sheet_h

#include <feib/domain.h>
#include <feib/lagrangian_mesh.h>

#include <algorithm>
#include <array>
#include <vector>

namespace feib
{
  /// A facet, and T_iK for each of its nodes; zero for a node that it does not move: one in a
  /// wall, and where an interface ends at the boundary of the body: the boundary alone moves the
  /// node, so that the flux through that stays exact.
  template <int dim>
  struct Sheet
  {
    using Facet  = typename LagrangianMesh<dim>::Facet;
    using Matrix = dealii::Tensor<2, dim>;

    Facet corners; // the nodes whose positions are its corners
    Facet nodes;   // those that move with it: of nodes that are images of one, that one
    std::array<bool, dim> moves;
    std::array<bool, dim> at_wall;
    std::array<Matrix, dim> maps;

    /// Of the part that each node moved takes over from each node in a wall; 0: there are none.
    double
    share() const
    {
      const auto number = std::count(moves.begin(), moves.end(), true);
      return number > 0 && number < dim && std::count(at_wall.begin(), at_wall.end(), true) > 0
               ? 1. / number
               : 0.;
    }
  };

  /// The facets that nodes move with, their maps not set yet; none where a body continues in its
  /// image. @p images: of periodic_images().
  template <int dim>
  std::vector<Sheet<dim>> find_sheets(const Domain<dim> &domain,
                                      const LagrangianMesh<dim> &mesh,
                                      const Positions<dim> &X,
                                      const std::vector<unsigned int> &images);

  /// Sets the maps T_iK; of multiples of the identity, the parts of areas, unless @p flux_exact.
  template <int dim>
  void set_flux_maps(std::vector<Sheet<dim>> &sheets, const Positions<dim> &X, bool flux_exact);
} // namespace feib

#endif
