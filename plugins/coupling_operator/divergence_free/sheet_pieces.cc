// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sheet_pieces.h"

namespace feib
{
  namespace
  {
    /// Sums up the moments of a piece, a few points at a time, as a matrix product.
    template <int dim>
    class Moments
    {
    public:
      using Piece = typename SheetPieces<dim>::Piece;

      void add(const dealii::Point<dim> &unit,
               const std::array<double, dim> &barycentric,
               double weight);

      /// Adds the sums to a piece and starts anew.
      void move_to(Piece &piece);

    private:
      static constexpr unsigned int n_modes = Reconstruction<dim>::n_modes;
      static constexpr unsigned int batch   = 6;
      static constexpr unsigned int n_rows  = dim * (dim + 1);
      static constexpr unsigned int width   = (n_modes + 7) / 8 * 8; // of whole vectors

      void flush();

      unsigned int n                            = 0; // points that wait
      alignas(64) double modes[batch][width]    = {};
      alignas(64) double factors[batch][n_rows] = {};
      alignas(64) double sums[n_rows][width]    = {};
    };


    template <int dim>
    void
    Moments<dim>::add(const dealii::Point<dim> &unit,
                      const std::array<double, dim> &barycentric,
                      const double weight)
    {
      double L[n_modes];
      dealii::Tensor<1, dim> bubble;
      Reconstruction<dim>::modes(unit, L, bubble);
      std::copy_n(L, n_modes, modes[n]);
      for (unsigned int v = 0; v < dim; ++v)
        {
          factors[n][v] = weight * barycentric[v];
          for (unsigned int i = 0; i < dim; ++i)
            factors[n][dim * (v + 1) + i] = factors[n][v] * bubble[i];
        }
      if (++n == batch)
        flush();
    }


    template <int dim>
    void
    Moments<dim>::flush()
    {
      for (; n < batch; ++n)
        std::fill_n(factors[n], n_rows, 0.);
      for (unsigned int r = 0; r < n_rows; ++r)
        for (unsigned int m = 0; m < width; ++m)
          {
            double sum = sums[r][m];
            for (unsigned int q = 0; q < batch; ++q)
              sum += factors[q][r] * modes[q][m];
            sums[r][m] = sum;
          }
      n = 0;
    }


    template <int dim>
    void
    Moments<dim>::move_to(Piece &piece)
    {
      if (n > 0)
        flush();
      for (unsigned int v = 0; v < dim; ++v)
        {
          for (unsigned int m = 0; m < n_modes; ++m)
            piece.values[v][m] += sums[v][m];
          for (unsigned int i = 0; i < dim; ++i)
            for (unsigned int m = 0; m < n_modes; ++m)
              piece.bubbles[v][i][m] += sums[dim * (v + 1) + i][m];
        }
      std::fill_n(&sums[0][0], n_rows * width, 0.);
    }


    /// The weights of the nodes moved at a place of a sheet.
    template <int dim>
    std::array<double, dim>
    weights(const Sheet<dim> &sheet, std::array<double, dim> lambda)
    {
      if (const double share = sheet.share(); share > 0)
        for (unsigned int v = 0; v < dim; ++v)
          for (unsigned int w = 0; w < dim; ++w)
            if (sheet.at_wall[v] && sheet.moves[w])
              lambda[w] += share * lambda[v];
      return lambda;
    }


    /// Integrates over one sheet after the other.
    template <int dim>
    class Cutter
    {
    public:
      using Piece   = typename SheetPieces<dim>::Piece;
      using Corners = std::array<dealii::Point<dim>, dim>;
      using Polygon = dealii::ArrayView<const typename CartesianForest<dim>::Corner>;

      Cutter(const EulerianSpace<dim> &space,
             const std::vector<Sheet<dim>> &sheets,
             const dealii::Quadrature<dim - 1> &quadrature,
             SheetPieces<dim> &pieces)
        : space(space)
        , sheets(sheets)
        , quadrature(quadrature)
        , pieces(pieces)
        , number(space.cells().size(), CartesianForest<dim>::not_here)
      {}

      /// Exactly: cell by cell.
      void
      cut(const unsigned int sheet, const Corners &corners)
      {
        space.forest().cut(corners, [&](const unsigned int cell, const Polygon &polygon) {
          // A fan of simplices about the first corner.
          for (unsigned int s = 1; s + dim <= polygon.size() + 1; ++s)
            add_simplex(sheets[sheet], polygon, s);
          moments.move_to(piece_of(sheet, cell));
        });
      }

      /// By points, wherever they are.
      void
      sample(const unsigned int sheet, const Corners &corners)
      {
        for (unsigned int q = 0; q < quadrature.size(); ++q)
          {
            std::array<double, dim> lambda{1.};
            for (unsigned int v = 1; v < dim; ++v)
              {
                lambda[v] = quadrature.point(q)[v - 1];
                lambda[0] -= lambda[v];
              }
            dealii::Point<dim> x, unit;
            for (unsigned int v = 0; v < dim; ++v)
              x += lambda[v] * corners[v];
            // Round-off must not carry it over a wall.
            for (unsigned int a = 0; a < dim; ++a)
              if (!space.domain().periodic(a))
                x[a] = std::clamp(x[a], space.domain().lower[a], space.domain().upper[a]);
            const unsigned int cell = space.forest().locate(x, unit);
            if (cell == CartesianForest<dim>::not_here)
              continue;
            moments.add(unit, weights<dim>(sheets[sheet], lambda), quadrature.weight(q));
            moments.move_to(piece_of(sheet, cell));
          }
      }

    private:
      /// Corners 0, s, ... of a polygon.
      void
      add_simplex(const Sheet<dim> &sheet, const Polygon &polygon, const unsigned int s)
      {
        const auto corner = [&](const unsigned int v) -> const auto &
        {
          return polygon[v == 0 ? 0 : s + v - 1];
        };
        dealii::Tensor<2, dim> barycentric;
        for (unsigned int v = 0; v < dim; ++v)
          for (unsigned int w = 0; w < dim; ++w)
            barycentric[v][w] = corner(v).barycentric[w];
        const double part = std::abs(determinant(barycentric)); // of the facet
        for (unsigned int q = 0; q < quadrature.size(); ++q)
          {
            dealii::Point<dim> unit        = corner(0).unit;
            std::array<double, dim> lambda = corner(0).barycentric;
            for (unsigned int v = 1; v < dim; ++v)
              {
                const double t = quadrature.point(q)[v - 1];
                unit += t * (corner(v).unit - corner(0).unit);
                for (unsigned int w = 0; w < dim; ++w)
                  lambda[w] += t * (corner(v).barycentric[w] - corner(0).barycentric[w]);
              }
            moments.add(unit, weights<dim>(sheet, lambda), part * quadrature.weight(q));
          }
      }

      Piece &
      piece_of(const unsigned int sheet, const unsigned int cell)
      {
        if (number[cell] == CartesianForest<dim>::not_here)
          {
            number[cell] = pieces.cells.size();
            pieces.cells.push_back(cell);
          }
        for (unsigned int p = pieces.list.size(); p-- > 0 && pieces.list[p].sheet == sheet;)
          if (pieces.list[p].cell == number[cell])
            return pieces.list[p];
        pieces.list.emplace_back();
        pieces.list.back().sheet = sheet;
        pieces.list.back().cell  = number[cell];
        return pieces.list.back();
      }

      const EulerianSpace<dim> &space;
      const std::vector<Sheet<dim>> &sheets;
      const dealii::Quadrature<dim - 1> &quadrature;
      SheetPieces<dim> &pieces;
      std::vector<unsigned int> number; // of each cell among those that have pieces
      Moments<dim> moments;
    };
  } // namespace


  template <int dim>
  void
  cut_sheets(const EulerianSpace<dim> &space,
             const std::vector<Sheet<dim>> &sheets,
             const Positions<dim> &X,
             const SheetRule<dim> &rule,
             SheetPieces<dim> &pieces)
  {
    pieces.list.clear();
    pieces.cells.clear();
    Cutter<dim> cutter(space, sheets, rule.quadrature, pieces);
    for (unsigned int k = 0; k < sheets.size(); ++k)
      {
        const auto &moves = sheets[k].moves;
        if (std::find(moves.begin(), moves.end(), true) == moves.end())
          continue;
        std::array<dealii::Point<dim>, dim> corners;
        for (unsigned int v = 0; v < dim; ++v)
          corners[v] = X[sheets[k].corners[v]];
        if (rule.cut)
          cutter.cut(k, corners);
        else
          cutter.sample(k, corners);
      }
  }


  template void cut_sheets(const EulerianSpace<2> &,
                           const std::vector<Sheet<2>> &,
                           const Positions<2> &,
                           const SheetRule<2> &,
                           SheetPieces<2> &);
  template void cut_sheets(const EulerianSpace<3> &,
                           const std::vector<Sheet<3>> &,
                           const Positions<3> &,
                           const SheetRule<3> &,
                           SheetPieces<3> &);
} // namespace feib
