// SPDX-License-Identifier: LGPL-2.1-or-later
#include "divergence_free_schema.h"

#include <feib/coupling_operator.h>
#include <feib/error.h>
#include <feib/plugin.h>
#include <feib/reconstruction.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>

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

    using Matrix = dealii::Tensor<2, dim>;
    using Facet  = typename LagrangianMesh<dim>::Facet;

    enum class Rule
    {
      cut,
      gauss,
      vertex
    };

    /// What a cell's velocity does to a point.
    struct Block
    {
      unsigned int point, cell;
      double weights[dim][n_velocity];
    };

    /// A point that moves with the finite element velocity.
    struct Plain
    {
      unsigned int point, cell;
      double values[n];
    };

    /// Moments of the shape functions and corrections of a cell over a piece of a facet, weighted
    /// with each shape function of the facet.
    struct Moments
    {
      double shapes[dim][n];
      double corrections[dim][dim][n_modes]; // [facet node][component][mode]

      void clear();
      void add(const dealii::Point<dim> &unit,
               const std::array<double, dim> &barycentric,
               double weight,
               const Reconstruction<dim> *reconstruction);
    };

    /// A facet, and which of its nodes it moves: where an interface ends at the boundary of the
    /// body the boundary alone does, so that the flux through that stays exact.
    struct Sheet
    {
      Facet nodes;
      std::array<bool, dim> moves;
    };

    static std::vector<Sheet> find_sheets(const LagrangianMesh<dim> &mesh);

    void add_sheets(const EulerianSpace<dim> &space,
                    const std::vector<Sheet> &sheets,
                    const Positions<dim> &X);

    /// T_iK for each facet and each of its nodes; zero for a node that it does not move.
    std::vector<std::array<Matrix, dim>> flux_maps(const std::vector<Sheet> &sheets,
                                                   const Positions<dim> &X) const;

    // What the case says.
    Rule rule;
    bool reconstruct, flux_exact;
    dealii::Quadrature<dim - 1> quadrature; // of a facet, or of a simplex of a piece

    std::unique_ptr<Reconstruction<dim>> reconstruction; // null when not wanted
    unsigned int n_points = 0;

    // With this rank's cells.
    std::vector<Block> blocks;
    std::vector<Plain> plain;
  };


  namespace
  {
    /// A rule of degree 2 n - 1 on the unit segment or triangle, the weights of sum 1.
    template <int m>
    dealii::Quadrature<m>
    simplex_rule(const unsigned int n)
    {
      if constexpr (m == 1)
        return dealii::QGauss<1>(n);
      else
        {
          const dealii::QWitherdenVincentSimplex<2> rule(n);
          std::vector<double> weights = rule.get_weights();
          for (double &weight : weights)
            weight *= 2;
          return {rule.get_points(), weights};
        }
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
    const auto [name, block] = parameters.child("quadrature").choice();
    rule = name == "cut" ? Rule::cut : name == "gauss" ? Rule::gauss : Rule::vertex;
    // Across a facet R u, of mixed degree, has total degree 4 in two dimensions and 6 in three.
    quadrature = simplex_rule<dim - 1>(rule == Rule::gauss ? block.integer("points") : dim + 1);
  }


  template <int dim>
  void
  DivergenceFree<dim>::set_geometry(const EulerianSpace<dim> &space,
                                    const LagrangianMesh<dim> &mesh,
                                    const Positions<dim> &X,
                                    const LagrangianPoints &points)
  {
    if (reconstruct && !reconstruction && !space.cells().empty())
      reconstruction = std::make_unique<Reconstruction<dim>>(space.cells()[0].size);
    const Positions<dim> x = points.positions(X);
    n_points               = x.size();
    for (unsigned int q = 0; q < n_points; ++q)
      // Positions are the same on all ranks, so all of them throw.
      if (!space.forest().inside(x[q]))
        {
          std::ostringstream message;
          message << "point " << q << " of a structure is at (" << x[q] << "), outside the box";
          throw RunFailure(message.str());
        }

    blocks.clear();
    plain.clear();
    const std::vector<Sheet> sheets =
      points.nodes_per_point == 1 ? find_sheets(mesh) : std::vector<Sheet>();
    std::vector<bool> inside(n_points, !sheets.empty()); // a body
    for (const Sheet &sheet : sheets)
      for (const unsigned int i : sheet.nodes)
        inside[i] = false;
    if (rule != Rule::vertex)
      add_sheets(space, sheets, X);
    dealii::Point<dim> unit;
    for (unsigned int q = 0; q < n_points; ++q)
      if (inside[q] || rule == Rule::vertex || sheets.empty())
        if (const unsigned int cell = space.forest().locate(x[q], unit);
            cell != CartesianForest<dim>::not_here)
          {
            if (inside[q] || !reconstruct)
              {
                plain.push_back({q, cell, {}});
                EulerianSpace<dim>::shape_values(unit, plain.back().values);
              }
            else
              {
                blocks.push_back({q, cell, {}});
                reconstruction->weights(unit, blocks.back().weights);
              }
          }
  }


  template <int dim>
  std::vector<typename DivergenceFree<dim>::Sheet>
  DivergenceFree<dim>::find_sheets(const LagrangianMesh<dim> &mesh)
  {
    std::vector<Sheet> sheets;
    std::vector<bool> outer(mesh.n_nodes(), false);
    for (const Facet &facet : mesh.surface())
      {
        sheets.push_back({facet, {}});
        sheets.back().moves.fill(true);
        for (const unsigned int i : facet)
          outer[i] = true;
      }
    for (const Facet &facet : mesh.interfaces())
      {
        sheets.push_back({facet, {}});
        for (unsigned int v = 0; v < dim; ++v)
          sheets.back().moves[v] = !outer[facet[v]];
      }
    return sheets;
  }


  template <int dim>
  std::vector<std::array<typename DivergenceFree<dim>::Matrix, dim>>
  DivergenceFree<dim>::flux_maps(const std::vector<Sheet> &sheets, const Positions<dim> &X) const
  {
    std::vector<dealii::Tensor<1, dim>> normals(sheets.size()), sums(X.size());
    std::vector<double> areas(X.size(), 0.);
    for (unsigned int k = 0; k < sheets.size(); ++k)
      {
        normals[k] = vector_area<dim>(sheets[k].nodes, X);
        for (unsigned int v = 0; v < dim; ++v)
          if (sheets[k].moves[v])
            {
              sums[sheets[k].nodes[v]] += normals[k] / dim;
              areas[sheets[k].nodes[v]] += normals[k].norm() / dim;
            }
      }

    // Where facets nearly fold back on each other N_i says nothing: the map would be large.
    constexpr double fold = 0.1;
    std::vector<std::array<Matrix, dim>> maps(sheets.size());
    for (unsigned int k = 0; k < sheets.size(); ++k)
      for (unsigned int v = 0; v < dim; ++v)
        if (sheets[k].moves[v])
          {
            const unsigned int i             = sheets[k].nodes[v];
            const dealii::Tensor<1, dim> &N  = sums[i];
            const dealii::Tensor<1, dim> &nk = normals[k];
            Matrix &T                        = maps[k][v];
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
                T[c][c] = areas[i] > 0 ? nk.norm() / areas[i] : 1.;
          }
    return maps;
  }


  template <int dim>
  void
  DivergenceFree<dim>::Moments::clear()
  {
    std::fill_n(&shapes[0][0], dim * n, 0.);
    std::fill_n(&corrections[0][0][0], dim * dim * n_modes, 0.);
  }


  template <int dim>
  void
  DivergenceFree<dim>::Moments::add(const dealii::Point<dim> &unit,
                                    const std::array<double, dim> &barycentric,
                                    const double weight,
                                    const Reconstruction<dim> *reconstruction)
  {
    double values[n], w[dim][n_modes];
    EulerianSpace<dim>::shape_values(unit, values);
    for (unsigned int v = 0; v < dim; ++v)
      for (unsigned int i = 0; i < n; ++i)
        shapes[v][i] += weight * barycentric[v] * values[i];
    if (!reconstruction)
      return;
    reconstruction->corrections(unit, w);
    for (unsigned int v = 0; v < dim; ++v)
      for (unsigned int c = 0; c < dim; ++c)
        for (unsigned int m = 0; m < n_modes; ++m)
          corrections[v][c][m] += weight * barycentric[v] * w[c][m];
  }


  template <int dim>
  void
  DivergenceFree<dim>::add_sheets(const EulerianSpace<dim> &space,
                                  const std::vector<Sheet> &sheets,
                                  const Positions<dim> &X)
  {
    // The few blocks of a node, as a list, and the coefficients of the corrections of each block.
    constexpr unsigned int none = -1;
    struct Mixed
    {
      unsigned int next;
      double modes[dim][n_modes];
    };
    std::vector<unsigned int> first(X.size(), none);
    std::vector<Mixed> mixed;
    const auto block_of = [&](const unsigned int node, const unsigned int cell) {
      for (unsigned int b = first[node]; b != none; b = mixed[b].next)
        if (blocks[b].cell == cell)
          return b;
      blocks.push_back({node, cell, {}});
      mixed.push_back({first[node], {}});
      return first[node] = blocks.size() - 1;
    };

    const auto maps = flux_maps(sheets, X);
    Moments moments;
    const auto distribute = [&](const unsigned int k, const unsigned int cell) {
      for (unsigned int v = 0; v < dim; ++v)
        {
          if (!sheets[k].moves[v])
            continue;
          const unsigned int b = block_of(sheets[k].nodes[v], cell);
          const Matrix &T      = maps[k][v];
          for (unsigned int a = 0; a < dim; ++a)
            for (unsigned int c = 0; c < dim; ++c)
              {
                for (unsigned int i = 0; i < n; ++i)
                  blocks[b].weights[a][c * n + i] += T[c][a] * moments.shapes[v][i];
                if (reconstruct)
                  for (unsigned int m = 0; m < n_modes; ++m)
                    mixed[b].modes[a][m] += T[c][a] * moments.corrections[v][c][m];
              }
        }
    };

    std::array<dealii::Point<dim>, dim> corners;
    for (unsigned int k = 0; k < sheets.size(); ++k)
      {
        for (unsigned int v = 0; v < dim; ++v)
          corners[v] = X[sheets[k].nodes[v]];
        if (rule == Rule::gauss)
          for (unsigned int q = 0; q < quadrature.size(); ++q)
            {
              std::array<double, dim> barycentric{1.};
              for (unsigned int v = 1; v < dim; ++v)
                {
                  barycentric[v] = quadrature.point(q)[v - 1];
                  barycentric[0] -= barycentric[v];
                }
              dealii::Point<dim> x, unit;
              for (unsigned int v = 0; v < dim; ++v)
                x += barycentric[v] * corners[v];
              const unsigned int cell = space.forest().locate(x, unit);
              if (cell == CartesianForest<dim>::not_here)
                continue;
              moments.clear();
              moments.add(unit, barycentric, quadrature.weight(q), reconstruction.get());
              distribute(k, cell);
            }
        else
          space.forest().cut(corners, [&](const unsigned int cell, const auto &piece) {
            moments.clear();
            // A fan of simplices about the first corner.
            for (unsigned int s = 1; s + dim <= piece.size() + 1; ++s)
              {
                const auto corner = [&](const unsigned int v) -> const auto &
                {
                  return piece[v == 0 ? 0 : s + v - 1];
                };
                // The part of the facet it covers.
                Matrix barycentric;
                for (unsigned int v = 0; v < dim; ++v)
                  for (unsigned int w = 0; w < dim; ++w)
                    barycentric[v][w] = corner(v).barycentric[w];
                const double part = std::abs(determinant(barycentric));
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
                    moments.add(unit, lambda, part * quadrature.weight(q), reconstruction.get());
                  }
              }
            distribute(k, cell);
          });
      }

    if (reconstruct)
      for (unsigned int b = 0; b < blocks.size(); ++b)
        for (unsigned int a = 0; a < dim; ++a)
          reconstruction->subtract_transpose(mixed[b].modes[a], blocks[b].weights[a]);
  }


  template <int dim>
  void
  DivergenceFree<dim>::interpolate(const EulerianSpace<dim> &space,
                                   const VelocityVector &u,
                                   NodalField<dim> &U) const
  {
    std::vector<double> values(n_points * dim, 0.);
    double local[n_velocity];
    for (const Block &block : blocks)
      {
        const unsigned int *dofs = space.velocity_dofs(block.cell);
        for (unsigned int j = 0; j < n_velocity; ++j)
          local[j] = u.local_element(dofs[j]);
        for (unsigned int a = 0; a < dim; ++a)
          {
            double sum = 0;
            for (unsigned int j = 0; j < n_velocity; ++j)
              sum += block.weights[a][j] * local[j];
            values[block.point * dim + a] += sum;
          }
      }
    for (const Plain &point : plain)
      {
        const unsigned int *dofs = space.velocity_dofs(point.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < n; ++i)
            values[point.point * dim + a] += point.values[i] * u.local_element(dofs[a * n + i]);
      }
    dealii::Utilities::MPI::sum(values, space.communicator(), values);
    U.resize(n_points);
    for (unsigned int q = 0; q < n_points; ++q)
      for (unsigned int a = 0; a < dim; ++a)
        U[q][a] = values[q * dim + a];
  }


  template <int dim>
  void
  DivergenceFree<dim>::spread(const EulerianSpace<dim> &space,
                              const NodalField<dim> &f,
                              VelocityVector &rhs) const
  {
    rhs.zero_out_ghost_values();
    for (const Block &block : blocks)
      {
        const unsigned int *dofs         = space.velocity_dofs(block.cell);
        const dealii::Tensor<1, dim> &fq = f[block.point];
        for (unsigned int j = 0; j < n_velocity; ++j)
          {
            double sum = 0;
            for (unsigned int a = 0; a < dim; ++a)
              sum += block.weights[a][j] * fq[a];
            rhs.local_element(dofs[j]) += sum;
          }
      }
    for (const Plain &point : plain)
      {
        const unsigned int *dofs = space.velocity_dofs(point.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < n; ++i)
            rhs.local_element(dofs[a * n + i]) += point.values[i] * f[point.point][a];
      }
    rhs.compress(dealii::VectorOperation::add);
  }


  template <int dim>
  MatrixEntries
  DivergenceFree<dim>::entries(const EulerianSpace<dim> &space) const
  {
    MatrixEntries result;
    for (const Block &block : blocks)
      {
        const unsigned int *dofs = space.velocity_dofs(block.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int j = 0; j < n_velocity; ++j)
            if (block.weights[a][j] != 0)
              result.push_back({std::uint64_t(block.point) * dim + a,
                                space.velocity.get_partitioner()->local_to_global(dofs[j]),
                                block.weights[a][j]});
      }
    for (const Plain &point : plain)
      {
        const unsigned int *dofs = space.velocity_dofs(point.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < n; ++i)
            result.push_back({std::uint64_t(point.point) * dim + a,
                              space.velocity.get_partitioner()->local_to_global(dofs[a * n + i]),
                              point.values[i]});
      }
    return result;
  }
} // namespace feib


FEIB_PLUGIN("divergence_free", "1.0", registry)
{
  registry.add<feib::CouplingOperator, feib::DivergenceFree>("divergence_free",
                                                             divergence_free_schema);
}
