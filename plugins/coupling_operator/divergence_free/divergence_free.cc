// SPDX-License-Identifier: LGPL-2.1-or-later
#include "divergence_free_schema.h"

#include <feib/coupling_operator.h>
#include <feib/failure.h>
#include <feib/plugin.h>
#include <feib/reconstruction.h>

#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>

namespace feib
{
  /// The coupling that loses no volume. With R the reconstruction and K the segments or facets of a
  /// curve, a surface, the boundary of a body or the interfaces of its materials, in normalised
  /// measure, a node i of them moves with
  ///   U_i = sum_K T_iK^T int_K phi_i R u,
  /// and a node inside a material with u(X_i).
  ///
  /// With n_K the vector area of K and N_i = sum_K n_K / dim, t = n_K - a N_i, a = n_K . N_i /
  /// |N_i|^2,
  ///   T_iK = a I + (t N_i^T - N_i t^T) / |N_i|^2,
  /// which turns and stretches N_i into n_K, while sum_K T_iK / dim = I. So nodal forces p N_i of a
  /// uniform pressure become the pressure p n_K on all facets, which moves no divergence-free
  /// fluid, and the volume gained, sum_i N_i . U_i, is the flux of R u: zero for a closed surface.
  ///
  /// A node in a wall that nothing can cross stays in it: it moves with u(X_i) along the wall. What
  /// its average would have been beyond that goes to the other nodes of its facets,
  ///   phi_j -> phi_j + 1/n sum_i phi_i  and  - 1/n sum_i U_i/dim,
  /// i the nodes of K in walls and n the number of others, so that the flux stays that of R u.
  template <int dim>
  class DivergenceFree : public CouplingOperator<dim>
  {
  public:
    explicit DivergenceFree(const Parameters &parameters);

    void set_geometry(const EulerianSpace<dim> &space,
                      const LagrangianMesh<dim> &mesh,
                      const Positions<dim> &X,
                      const LagrangianPoints &points) override;

    void interpolate(const EulerianSpace<dim> &space,
                     const VelocityVector &u,
                     NodalField<dim> &U) const override;

    void spread(const EulerianSpace<dim> &space,
                const NodalField<dim> &f,
                VelocityVector &rhs) const override;

    MatrixEntries entries(const EulerianSpace<dim> &space) const override;

  private:
    static constexpr unsigned int n          = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_velocity = EulerianSpace<dim>::n_velocity;
    static constexpr unsigned int n_modes    = Reconstruction<dim>::n_modes;

    using Coefficients = typename Reconstruction<dim>::Coefficients;

    using Matrix = dealii::Tensor<2, dim>;
    using Facet  = typename LagrangianMesh<dim>::Facet;

    /// A point that moves with the finite element velocity.
    struct Plain
    {
      unsigned int point, cell;
      std::array<bool, dim> held; // components that are zero, as the point is in a wall
      double values[n];
    };

    /// A facet, and T_iK for each of its nodes; zero for a node that it does not move: one in a
    /// wall, and where an interface ends at the boundary of the body: the boundary alone moves the
    /// node, so that the flux through that stays exact.
    struct Sheet
    {
      Facet nodes;
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

    /// The part of a facet in one cell, in normalised measure: integrals of phi_v L_m and of
    /// phi_v beta(x_i) L_m (see Reconstruction) for each shape function phi_v of the facet.
    struct Piece
    {
      unsigned int sheet, cell; // cell: index in touched_cells
      double values[dim][n_modes];
      double bubbles[dim][dim][n_modes];
    };

    /// Sums up the moments of a piece, a few points at a time, as a matrix product.
    class Moments
    {
    public:
      void add(const dealii::Point<dim> &unit,
               const std::array<double, dim> &barycentric,
               double weight);

      /// Adds the sums to a piece and starts anew.
      void move_to(Piece &piece);

    private:
      static constexpr unsigned int batch  = 6;
      static constexpr unsigned int n_rows = dim * (dim + 1);
      static constexpr unsigned int width  = (n_modes + 7) / 8 * 8; // of whole vectors

      void flush();

      unsigned int n                            = 0; // points that wait
      alignas(64) double modes[batch][width]    = {};
      alignas(64) double factors[batch][n_rows] = {};
      alignas(64) double sums[n_rows][width]    = {};
    };

    static std::vector<Sheet> find_sheets(const Domain<dim> &domain,
                                          const LagrangianMesh<dim> &mesh,
                                          const Positions<dim> &X);

    void set_flux_maps(const Positions<dim> &X);

    void cut_sheets(const EulerianSpace<dim> &space, const Positions<dim> &X);

    /// Calls @p visit(i, j, A) for each node i in a wall and node j moved of a facet: U_j is less
    /// by A U_i than what the integrals say.
    template <class Visit>
    void for_each_shared(const Visit &visit) const;

    /// The coefficients of R u (or u) in each of the touched cells.
    std::vector<Coefficients> coefficients(const EulerianSpace<dim> &space,
                                           const VelocityVector &u) const;

    // What the case says.
    bool cut, reconstruct, flux_exact;
    dealii::Quadrature<dim - 1> quadrature; // of a facet, or of a simplex of a piece

    // The geometry, with this rank's cells.
    std::unique_ptr<Reconstruction<dim>> reconstruction; // null before a cell is known
    NodalField<dim> zero;                                // of the points
    std::vector<Sheet> sheets;
    std::vector<unsigned int> touched_cells;
    std::vector<Piece> pieces;
    std::vector<Plain> plain;
  };


  namespace
  {
    /// A rule of degree 2 n - 1 (or, for a triangle, 2 n when @p even) on the unit segment or
    /// triangle, the weights of sum 1.
    template <int m>
    dealii::Quadrature<m>
    simplex_rule(const unsigned int n, const bool even = false)
    {
      if constexpr (m == 1)
        return dealii::QGauss<1>(n);
      else
        {
          const dealii::QWitherdenVincentSimplex<2> rule(n, !even);
          std::vector<double> weights = rule.get_weights();
          for (double &weight : weights)
            weight *= 2;
          return {rule.get_points(), weights};
        }
    }

    /// The corners of the unit segment or triangle, the weights of sum 1.
    template <int m>
    dealii::Quadrature<m>
    vertex_rule()
    {
      std::vector<dealii::Point<m>> corners(m + 1);
      for (unsigned int k = 0; k < m; ++k)
        corners[k + 1][k] = 1;
      return {corners, std::vector<double>(m + 1, 1. / (m + 1))};
    }

    /// The vector area of a segment or triangle.
    template <int dim>
    dealii::Tensor<1, dim>
    vector_area(const std::array<unsigned int, dim> &facet, const Positions<dim> &X)
    {
      const dealii::Tensor<1, dim> edge = X[facet[1]] - X[facet[0]];
      if constexpr (dim == 2)
        return cross_product_2d(edge);
      else
        return .5 * cross_product_3d(edge, X[facet[2]] - X[facet[0]]);
    }
  } // namespace


  template <int dim>
  DivergenceFree<dim>::DivergenceFree(const Parameters &parameters)
    : reconstruct(parameters.boolean("reconstruction"))
    , flux_exact(parameters.boolean("flux_exact"))
  {
    const auto [rule, block] = parameters.child("quadrature").choice();
    cut                      = rule == "cut";
    // Along a facet R u, of mixed degree, has total degree 4 in two dimensions and 6 in three.
    quadrature = rule == "vertex" ? vertex_rule<dim - 1>()
                 : cut            ? simplex_rule<dim - 1>(3, true)
                                  : simplex_rule<dim - 1>(block.integer("points"));
  }


  template <int dim>
  void
  DivergenceFree<dim>::set_geometry(const EulerianSpace<dim> &space,
                                    const LagrangianMesh<dim> &mesh,
                                    const Positions<dim> &X,
                                    const LagrangianPoints &points)
  {
    if (!reconstruction && !space.cells().empty())
      reconstruction = std::make_unique<Reconstruction<dim>>(space.cells()[0].size);
    const Positions<dim> x = points.positions(X);
    zero                   = NodalField<dim>(points);
    agree(space.communicator(), [&] {
      for (unsigned int q = 0; q < x.size(); ++q)
        if (!space.forest().inside(x[q]))
          {
            std::ostringstream message;
            message << "point " << q << " of a structure is at (" << x[q] << "), outside the box";
            throw RunFailure(message.str());
          }
    });

    sheets.clear();
    if (points.are_nodes(mesh.n_nodes()))
      sheets = find_sheets(space.domain(), mesh, X);
    agree(space.communicator(), [&] {
      for (const Sheet &sheet : sheets)
        for (unsigned int a = 0; a < dim; ++a)
          for (const unsigned int i : sheet.nodes)
            if (std::abs(X[i][a] - X[sheet.nodes[0]][a]) >
                space.domain().upper[a] - space.domain().lower[a])
              throw RunFailure("a structure is torn: one of its elements is longer than the box");
    });
    set_flux_maps(X);
    cut_sheets(space, X);

    // What is left: nodes inside a body or in walls, and load points between the nodes.
    std::vector<bool> moved(x.size(), false);
    for (const Sheet &sheet : sheets)
      for (unsigned int v = 0; v < dim; ++v)
        if (sheet.moves[v])
          moved[sheet.nodes[v]] = true;
    plain.clear();
    dealii::Point<dim> unit;
    for (unsigned int q = 0; q < x.size(); ++q)
      if (!moved[q])
        if (const unsigned int cell = space.forest().locate(x[q], unit);
            cell != CartesianForest<dim>::not_here)
          {
            plain.push_back({q, cell, space.domain().held(x[q]), {}});
            EulerianSpace<dim>::shape_values(unit, plain.back().values);
          }
  }


  template <int dim>
  std::vector<typename DivergenceFree<dim>::Sheet>
  DivergenceFree<dim>::find_sheets(const Domain<dim> &domain,
                                   const LagrangianMesh<dim> &mesh,
                                   const Positions<dim> &X)
  {
    std::vector<Sheet> result;
    std::vector<bool> outer(mesh.n_nodes(), false);
    for (const Facet &facet : mesh.surface())
      {
        result.push_back({facet, {}, {}, {}});
        for (unsigned int v = 0; v < dim; ++v)
          {
            const std::array<bool, dim> held = domain.held(X[facet[v]]);
            result.back().at_wall[v] = std::find(held.begin(), held.end(), true) != held.end();
            result.back().moves[v]   = !result.back().at_wall[v];
            outer[facet[v]]          = true;
          }
      }
    for (const Facet &facet : mesh.interfaces())
      {
        result.push_back({facet, {}, {}, {}});
        for (unsigned int v = 0; v < dim; ++v)
          result.back().moves[v] = !outer[facet[v]];
      }
    return result;
  }


  template <int dim>
  template <class Visit>
  void
  DivergenceFree<dim>::for_each_shared(const Visit &visit) const
  {
    for (const Sheet &sheet : sheets)
      if (const double share = sheet.share(); share > 0)
        for (unsigned int v = 0; v < dim; ++v)
          for (unsigned int w = 0; w < dim; ++w)
            if (sheet.at_wall[v] && sheet.moves[w])
              visit(sheet.nodes[v], sheet.nodes[w], share / dim * transpose(sheet.maps[w]));
  }


  template <int dim>
  void
  DivergenceFree<dim>::set_flux_maps(const Positions<dim> &X)
  {
    // Sums over all facets around a node: every rank has them all.
    std::vector<dealii::Tensor<1, dim>> normals(sheets.size()), sums(X.size());
    std::vector<double> areas(X.size(), 0.);
    std::vector<unsigned int> n_facets(X.size(), 0);
    for (unsigned int k = 0; k < sheets.size(); ++k)
      {
        normals[k] = vector_area<dim>(sheets[k].nodes, X);
        for (unsigned int v = 0; v < dim; ++v)
          if (sheets[k].moves[v])
            {
              sums[sheets[k].nodes[v]] += normals[k] / dim;
              areas[sheets[k].nodes[v]] += normals[k].norm() / dim;
              ++n_facets[sheets[k].nodes[v]];
            }
      }

    // Where facets nearly fold back on each other N_i says nothing: the map would be large.
    constexpr double fold = 0.1;
    for (unsigned int k = 0; k < sheets.size(); ++k)
      for (unsigned int v = 0; v < dim; ++v)
        if (sheets[k].moves[v])
          {
            const unsigned int i             = sheets[k].nodes[v];
            const dealii::Tensor<1, dim> &N  = sums[i];
            const dealii::Tensor<1, dim> &nk = normals[k];
            Matrix &T                        = sheets[k].maps[v];
            if (flux_exact && N.norm() > fold * areas[i])
              {
                const double square            = N.norm_square();
                const double a                 = nk * N / square;
                const dealii::Tensor<1, dim> t = nk - a * N;
                T = (outer_product(t, N) - outer_product(N, t)) / square;
                for (unsigned int c = 0; c < dim; ++c)
                  T[c][c] += a;
              }
            else
              for (unsigned int c = 0; c < dim; ++c)
                T[c][c] = areas[i] > 0 ? nk.norm() / areas[i] : double(dim) / n_facets[i];
          }
  }


  template <int dim>
  void
  DivergenceFree<dim>::Moments::add(const dealii::Point<dim> &unit,
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
  DivergenceFree<dim>::Moments::flush()
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
  DivergenceFree<dim>::Moments::move_to(Piece &piece)
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


  template <int dim>
  void
  DivergenceFree<dim>::cut_sheets(const EulerianSpace<dim> &space, const Positions<dim> &X)
  {
    pieces.clear();
    touched_cells.clear();
    std::vector<unsigned int> number(space.cells().size(), CartesianForest<dim>::not_here);
    const auto piece_of = [&](const unsigned int sheet, const unsigned int cell) -> Piece & {
      if (number[cell] == CartesianForest<dim>::not_here)
        {
          number[cell] = touched_cells.size();
          touched_cells.push_back(cell);
        }
      for (unsigned int p = pieces.size(); p-- > 0 && pieces[p].sheet == sheet;)
        if (pieces[p].cell == number[cell])
          return pieces[p];
      pieces.emplace_back();
      pieces.back().sheet = sheet;
      pieces.back().cell  = number[cell];
      return pieces.back();
    };

    // The weights of the nodes moved at a place of a sheet.
    const auto weights = [](const Sheet &sheet, std::array<double, dim> lambda) {
      if (const double share = sheet.share(); share > 0)
        for (unsigned int v = 0; v < dim; ++v)
          for (unsigned int w = 0; w < dim; ++w)
            if (sheet.at_wall[v] && sheet.moves[w])
              lambda[w] += share * lambda[v];
      return lambda;
    };

    Moments moments;
    std::array<dealii::Point<dim>, dim> corners;
    for (unsigned int k = 0; k < sheets.size(); ++k)
      {
        const auto &moves = sheets[k].moves;
        if (std::find(moves.begin(), moves.end(), true) == moves.end())
          continue;
        for (unsigned int v = 0; v < dim; ++v)
          corners[v] = X[sheets[k].nodes[v]];
        if (cut)
          space.forest().cut(corners, [&](const unsigned int cell, const auto &polygon) {
            // A fan of simplices about the first corner.
            for (unsigned int s = 1; s + dim <= polygon.size() + 1; ++s)
              {
                const auto corner = [&](const unsigned int v) -> const auto &
                {
                  return polygon[v == 0 ? 0 : s + v - 1];
                };
                Matrix barycentric;
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
                    moments.add(unit, weights(sheets[k], lambda), part * quadrature.weight(q));
                  }
              }
            moments.move_to(piece_of(k, cell));
          });
        else
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
              moments.add(unit, weights(sheets[k], lambda), quadrature.weight(q));
              moments.move_to(piece_of(k, cell));
            }
      }
    if (!reconstruct)
      for (Piece &piece : pieces)
        std::fill_n(&piece.bubbles[0][0][0], dim * dim * n_modes, 0.);
  }


  template <int dim>
  std::vector<typename DivergenceFree<dim>::Coefficients>
  DivergenceFree<dim>::coefficients(const EulerianSpace<dim> &space, const VelocityVector &u) const
  {
    std::vector<Coefficients> result(touched_cells.size());
    double local[n_velocity];
    for (unsigned int c = 0; c < touched_cells.size(); ++c)
      {
        const unsigned int *dofs = space.velocity_dofs(touched_cells[c]);
        for (unsigned int j = 0; j < n_velocity; ++j)
          local[j] = u.local_element(dofs[j]);
        reconstruction->coefficients(local, result[c]);
      }
    return result;
  }


  template <int dim>
  void
  DivergenceFree<dim>::interpolate(const EulerianSpace<dim> &space,
                                   const VelocityVector &u,
                                   NodalField<dim> &U) const
  {
    U                                     = zero;
    const std::vector<Coefficients> cells = coefficients(space, u);
    for (const Piece &piece : pieces)
      {
        const Coefficients &cell = cells[piece.cell];
        const Sheet &sheet       = sheets[piece.sheet];
        for (unsigned int v = 0; v < dim; ++v)
          {
            dealii::Tensor<1, dim> integral; // of phi_v R u
            for (unsigned int i = 0; i < dim; ++i)
              {
                double sum = 0;
                for (unsigned int m = 0; m < n_modes; ++m)
                  sum += piece.values[v][m] * cell.values[i][m] +
                         piece.bubbles[v][i][m] * cell.bubbles[i][m];
                integral[i] = sum;
              }
            U[sheet.nodes[v]] += integral * sheet.maps[v];
          }
      }
    for (const Plain &point : plain)
      {
        const unsigned int *dofs = space.velocity_dofs(point.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < n && !point.held[a]; ++i)
            U[point.point][a] += point.values[i] * u.local_element(dofs[a * n + i]);
      }
    U.compress(space.communicator());
    U.update_ghosts();
    for_each_shared(
      [&](const unsigned int i, const unsigned int j, const Matrix &A) { U[j] -= A * U[i]; });
  }


  template <int dim>
  void
  DivergenceFree<dim>::spread(const EulerianSpace<dim> &space,
                              const NodalField<dim> &f,
                              VelocityVector &rhs) const
  {
    rhs.zero_out_ghost_values();
    NodalField<dim> forces = f;
    for_each_shared(
      [&](const unsigned int i, const unsigned int j, const Matrix &A) { forces[i] -= f[j] * A; });
    std::vector<Coefficients> cells(touched_cells.size()); // functionals of R u, zero
    for (const Piece &piece : pieces)
      {
        Coefficients &cell = cells[piece.cell];
        const Sheet &sheet = sheets[piece.sheet];
        for (unsigned int v = 0; v < dim; ++v)
          {
            const dealii::Tensor<1, dim> force = sheet.maps[v] * forces[sheet.nodes[v]];
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int m = 0; m < n_modes; ++m)
                {
                  cell.values[i][m] += force[i] * piece.values[v][m];
                  cell.bubbles[i][m] += force[i] * piece.bubbles[v][i][m];
                }
          }
      }
    double local[n_velocity];
    for (unsigned int c = 0; c < touched_cells.size(); ++c)
      {
        const unsigned int *dofs = space.velocity_dofs(touched_cells[c]);
        reconstruction->weights(cells[c], local);
        for (unsigned int j = 0; j < n_velocity; ++j)
          rhs.local_element(dofs[j]) += local[j];
      }
    for (const Plain &point : plain)
      {
        const unsigned int *dofs = space.velocity_dofs(point.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < n && !point.held[a]; ++i)
            rhs.local_element(dofs[a * n + i]) += point.values[i] * forces[point.point][a];
      }
    rhs.compress(dealii::VectorOperation::add);
  }


  template <int dim>
  MatrixEntries
  DivergenceFree<dim>::entries(const EulerianSpace<dim> &space) const
  {
    const auto &partitioner = *space.velocity.get_partitioner();
    MatrixEntries result;
    const auto add_row =
      [&](const std::uint64_t row, const unsigned int cell, const double *weights) {
        for (unsigned int j = 0; j < n_velocity; ++j)
          if (weights[j] != 0)
            result.push_back(
              {row, partitioner.local_to_global(space.velocity_dofs(cell)[j]), weights[j]});
      };

    // The pieces of a node in a cell together make one functional for each component.
    std::map<std::pair<unsigned int, unsigned int>, std::array<Coefficients, dim>> functionals;
    for (const Piece &piece : pieces)
      for (unsigned int v = 0; v < dim; ++v)
        {
          const Sheet &sheet = sheets[piece.sheet];
          if (!sheet.moves[v])
            continue;
          auto &functional = functionals[{sheet.nodes[v], touched_cells[piece.cell]}];
          for (unsigned int a = 0; a < dim; ++a)
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int m = 0; m < n_modes; ++m)
                {
                  functional[a].values[i][m] += sheet.maps[v][i][a] * piece.values[v][m];
                  functional[a].bubbles[i][m] += sheet.maps[v][i][a] * piece.bubbles[v][i][m];
                }
        }
    double weights[n_velocity];
    for (const auto &[place, functional] : functionals)
      for (unsigned int a = 0; a < dim; ++a)
        {
          reconstruction->weights(functional[a], weights);
          add_row(std::uint64_t(place.first) * dim + a, place.second, weights);
        }
    // Where the velocity of a node in a wall enters beside its own row.
    std::vector<std::vector<std::pair<unsigned int, Matrix>>> others(zero.size());
    for_each_shared([&](const unsigned int i, const unsigned int j, const Matrix &A) {
      others[i].emplace_back(j, A);
    });
    for (const Plain &point : plain)
      for (unsigned int a = 0; a < dim; ++a)
        if (!point.held[a])
          {
            const auto add_multiple = [&](const std::uint64_t row, const double factor) {
              std::fill_n(weights, n_velocity, 0.);
              for (unsigned int i = 0; i < n; ++i)
                weights[a * n + i] = factor * point.values[i];
              add_row(row, point.cell, weights);
            };
            add_multiple(std::uint64_t(point.point) * dim + a, 1.);
            for (const auto &[j, A] : others[point.point])
              for (unsigned int b = 0; b < dim; ++b)
                add_multiple(std::uint64_t(j) * dim + b, -A[b][a]);
          }
    return result;
  }
} // namespace feib


FEIB_PLUGIN("divergence_free", "1.0", registry)
{
  registry.add<feib::CouplingOperator, feib::DivergenceFree>("divergence_free",
                                                             divergence_free_schema);
}
