// SPDX-License-Identifier: LGPL-2.1-or-later
#include "divergence_free_schema.h"
#include "sheet_pieces.h"

#include <feib/coupling_operator.h>
#include <feib/failure.h>
#include <feib/periodic_images.h>
#include <feib/plugin.h>

#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
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
  /// Nodes that a periodic box identifies, where a structure reaches across it and begins anew, are
  /// one node: the sum is over the facets of all of them.
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

    /// It integrates along segments and facets: energies are some per cent off where these are
    /// longer.
    double
    longest_element() const override
    {
      return 3;
    }

  private:
    static constexpr unsigned int n          = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_velocity = EulerianSpace<dim>::n_velocity;
    static constexpr unsigned int n_modes    = Reconstruction<dim>::n_modes;

    using Coefficients = typename Reconstruction<dim>::Coefficients;

    using Matrix = dealii::Tensor<2, dim>;

    /// A point that moves with the finite element velocity.
    struct Plain
    {
      unsigned int point, cell;
      std::array<bool, dim> held; // components that are zero, as the point is in a wall
      double values[n];
    };

    /// Calls @p visit(i, j, A) for each node i in a wall and node j moved of a facet: U_j is less
    /// by A U_i than what the integrals say.
    template <class Visit>
    void for_each_shared(const Visit &visit) const;

    /// The coefficients of R u (or u) in each of the touched cells.
    std::vector<Coefficients> coefficients(const EulerianSpace<dim> &space,
                                           const VelocityVector &u) const;

    // What the case says.
    bool reconstruct, flux_exact;
    SheetRule<dim> rule;

    // The geometry, with this rank's cells.
    std::unique_ptr<Reconstruction<dim>> reconstruction; // null before a cell is known
    NodalField<dim> zero;                                // of the points
    std::vector<unsigned int> images; // of periodic_images(); of points, themselves
    std::vector<Sheet<dim>> sheets;
    SheetPieces<dim> pieces;
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
  } // namespace


  template <int dim>
  DivergenceFree<dim>::DivergenceFree(const Parameters &parameters)
    : reconstruct(parameters.boolean("reconstruction"))
    , flux_exact(parameters.boolean("flux_exact"))
  {
    const auto [name, block] = parameters.child("quadrature").choice();
    rule.cut                 = name == "cut";
    // Along a facet R u, of mixed degree, has total degree 4 in two dimensions and 6 in three.
    rule.quadrature = name == "vertex" ? vertex_rule<dim - 1>()
                      : rule.cut       ? simplex_rule<dim - 1>(3, true)
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
    images.resize(x.size());
    std::iota(images.begin(), images.end(), 0u);
    if (points.are_nodes(mesh.n_nodes()))
      {
        images = periodic_images(space.domain(), mesh, X);
        sheets = find_sheets(space.domain(), mesh, X, images);
      }
    agree(space.communicator(), [&] {
      for (const Sheet<dim> &sheet : sheets)
        for (unsigned int a = 0; a < dim; ++a)
          for (const unsigned int i : sheet.corners)
            if (std::abs(X[i][a] - X[sheet.corners[0]][a]) >
                space.domain().upper[a] - space.domain().lower[a])
              throw RunFailure("a structure is torn: one of its elements is longer than the box");
    });
    set_flux_maps(sheets, X, flux_exact);
    cut_sheets(space, sheets, X, rule, pieces);
    if (!reconstruct)
      for (auto &piece : pieces.list)
        std::fill_n(&piece.bubbles[0][0][0], dim * dim * n_modes, 0.);

    // What is left: nodes inside a body or in walls, and load points between the nodes.
    std::vector<bool> moved(x.size(), false);
    for (const Sheet<dim> &sheet : sheets)
      for (unsigned int v = 0; v < dim; ++v)
        if (sheet.moves[v])
          moved[sheet.nodes[v]] = true;
    plain.clear();
    dealii::Point<dim> unit;
    for (unsigned int q = 0; q < x.size(); ++q)
      if (!moved[q] && images[q] == q)
        if (const unsigned int cell = space.forest().locate(x[q], unit);
            cell != CartesianForest<dim>::not_here)
          {
            plain.push_back({q, cell, space.domain().held(x[q]), {}});
            EulerianSpace<dim>::shape_values(unit, plain.back().values);
          }
  }


  template <int dim>
  template <class Visit>
  void
  DivergenceFree<dim>::for_each_shared(const Visit &visit) const
  {
    for (const Sheet<dim> &sheet : sheets)
      if (const double share = sheet.share(); share > 0)
        for (unsigned int v = 0; v < dim; ++v)
          for (unsigned int w = 0; w < dim; ++w)
            if (sheet.at_wall[v] && sheet.moves[w])
              visit(sheet.nodes[v], sheet.nodes[w], share / dim * transpose(sheet.maps[w]));
  }


  template <int dim>
  std::vector<typename DivergenceFree<dim>::Coefficients>
  DivergenceFree<dim>::coefficients(const EulerianSpace<dim> &space, const VelocityVector &u) const
  {
    std::vector<Coefficients> result(pieces.cells.size());
    double local[n_velocity];
    for (unsigned int c = 0; c < pieces.cells.size(); ++c)
      {
        const unsigned int *dofs = space.velocity_dofs(pieces.cells[c]);
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
    for (const auto &piece : pieces.list)
      {
        const Coefficients &cell = cells[piece.cell];
        const Sheet<dim> &sheet  = sheets[piece.sheet];
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
    for (unsigned int i = 0; i < images.size(); ++i)
      if (images[i] != i)
        U[i] = U[images[i]];
  }


  template <int dim>
  void
  DivergenceFree<dim>::spread(const EulerianSpace<dim> &space,
                              const NodalField<dim> &f,
                              VelocityVector &rhs) const
  {
    rhs.zero_out_ghost_values();
    NodalField<dim> forces = f;
    for (unsigned int i = 0; i < images.size(); ++i)
      if (images[i] != i)
        forces[images[i]] += f[i];
    // Never both: a node in a wall and one moved.
    for_each_shared([&](const unsigned int i, const unsigned int j, const Matrix &A) {
      forces[i] -= forces[j] * A;
    });
    std::vector<Coefficients> cells(pieces.cells.size()); // functionals of R u, zero
    for (const auto &piece : pieces.list)
      {
        Coefficients &cell      = cells[piece.cell];
        const Sheet<dim> &sheet = sheets[piece.sheet];
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
    for (unsigned int c = 0; c < pieces.cells.size(); ++c)
      {
        const unsigned int *dofs = space.velocity_dofs(pieces.cells[c]);
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
    std::multimap<unsigned int, unsigned int> images_of;
    for (unsigned int i = 0; i < images.size(); ++i)
      images_of.emplace(images[i], i); // itself among them
    const auto add_row = [&](const unsigned int node,
                             const unsigned int a,
                             const unsigned int cell,
                             const double *weights) {
      const auto [begin, end] = images_of.equal_range(node);
      for (unsigned int j = 0; j < n_velocity; ++j)
        if (weights[j] != 0)
          for (auto image = begin; image != end; ++image)
            result.push_back({std::uint64_t(image->second) * dim + a,
                              partitioner.local_to_global(space.velocity_dofs(cell)[j]),
                              weights[j]});
    };

    // The pieces of a node in a cell together make one functional for each component.
    std::map<std::pair<unsigned int, unsigned int>, std::array<Coefficients, dim>> functionals;
    for (const auto &piece : pieces.list)
      for (unsigned int v = 0; v < dim; ++v)
        {
          const Sheet<dim> &sheet = sheets[piece.sheet];
          if (!sheet.moves[v])
            continue;
          auto &functional = functionals[{sheet.nodes[v], pieces.cells[piece.cell]}];
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
          add_row(place.first, a, place.second, weights);
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
            const auto add_multiple =
              [&](const unsigned int node, const unsigned int b, const double factor) {
                std::fill_n(weights, n_velocity, 0.);
                for (unsigned int i = 0; i < n; ++i)
                  weights[a * n + i] = factor * point.values[i];
                add_row(node, b, point.cell, weights);
              };
            add_multiple(point.point, a, 1.);
            for (const auto &[j, A] : others[point.point])
              for (unsigned int b = 0; b < dim; ++b)
                add_multiple(j, b, -A[b][a]);
          }
    return result;
  }
} // namespace feib


FEIB_PLUGIN("divergence_free", "1.0", registry)
{
  registry.add<feib::CouplingOperator, feib::DivergenceFree>("divergence_free",
                                                             divergence_free_schema);
}
