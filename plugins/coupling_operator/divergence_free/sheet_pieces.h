// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_divergence_free_sheet_pieces_h
#define feib_divergence_free_sheet_pieces_h

#include "sheet.h"

#include <feib/eulerian_space.h>
#include <feib/reconstruction.h>

#include <deal.II/base/quadrature.h>

namespace feib
{
  /// How sheets are integrated over.
  template <int dim>
  struct SheetRule
  {
    bool cut = false;                       // along the faces of cells
    dealii::Quadrature<dim - 1> quadrature; // of a facet, or of a simplex of a piece
  };

  /// The parts of sheets in this rank's cells.
  template <int dim>
  struct SheetPieces
  {
    static constexpr unsigned int n_modes = Reconstruction<dim>::n_modes;

    /// The part of a facet in one cell, in normalised measure: integrals of phi_v L_m and of
    /// phi_v beta(x_i) L_m (see Reconstruction) for each shape function phi_v of the facet.
    struct Piece
    {
      unsigned int sheet, cell; // cell: index in cells
      double values[dim][n_modes];
      double bubbles[dim][dim][n_modes];
    };

    std::vector<Piece> list;
    std::vector<unsigned int> cells; // that have pieces
  };

  /// Makes the pieces of the sheets of nodes at @p X anew.
  template <int dim>
  void cut_sheets(const EulerianSpace<dim> &space,
                  const std::vector<Sheet<dim>> &sheets,
                  const Positions<dim> &X,
                  const SheetRule<dim> &rule,
                  SheetPieces<dim> &pieces);
} // namespace feib

#endif
