// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kernel.h"
#include "regularised_delta_schema.h"

#include <feib/coupling_operator.h>
#include <feib/failure.h>
#include <feib/plugin.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <unordered_map>

namespace feib
{
  /// Peskin's map: U_q = sum_n V_n delta(x_n - X_q) u_n over the nodes n of the fluid's lattice, a
  /// rule for the integral of delta(x - X_q) u(x). V_n is summed over the cells of the node, so
  /// that each cell adds its own part, hanging nodes have theirs, and all is added once. With
  ///   delta(x) = prod_a phi(x_a/s_a)/s_a,  s the spacing at X_q,
  /// and, when reproducing, times c_q(x - X_q), the linear polynomial for which the sum is exact
  /// for constant and linear u.
  template <int dim>
  class RegularisedDelta : public CouplingOperator<dim>
  {
  public:
    explicit RegularisedDelta(const Parameters &parameters)
      : kernel(parameters.string("kernel"))
      , of_nodes(parameters.string("spacing") == "nodes")
      , reproducing(parameters.boolean("reproducing"))
    {}

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
    static constexpr unsigned int n         = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_moments = (dim + 1) * (dim + 2) / 2;

    using Place   = typename Lattice<dim>::Place;
    using Offset  = dealii::Tensor<1, dim>;
    using Moments = dealii::Tensor<1, n_moments>; // of 1, r_a and r_a r_b with a <= b

    /// A cell with nodes within reach of a point: products of line give the weights of its nodes,
    /// which are at r + step (0, 1 or 2) from the point in each direction, in spacings.
    struct Part
    {
      unsigned int point, cell;
      double line[dim][3];
      Offset r;
      double step;
    };

    /// c(r) = constant + slope . r
    struct Correction
    {
      double constant = 1;
      Offset slope;
    };

    /// Numbers the corners and finds the levels of this rank's cells.
    void index_cells(const EulerianSpace<dim> &space);

    /// The edge of a cell in units of the lattice, the same in each direction.
    static std::int64_t
    edge_of(const EulerianSpace<dim> &space, const unsigned int cell)
    {
      return (space.lattice().extent(0) / space.domain().cells[0]) >> space.cells()[cell].level;
    }

    /// The edge, in units of the lattice, of the cell around each point. Throws RunFailure when a
    /// point is not in the box. Collective.
    NodalValues<dealii::Tensor<1, 1>> edges_around(const EulerianSpace<dim> &space,
                                                   const Positions<dim> &x,
                                                   const LagrangianPoints &points) const;

    /// Adds the parts of point q, at x in a cell of this edge.
    void add_point(const EulerianSpace<dim> &space,
                   unsigned int q,
                   const dealii::Point<dim> &x,
                   std::int64_t edge);

    /// Along one direction: a cell of which a node is within reach.
    struct Line
    {
      std::int64_t lower; // in units of the lattice, before wrapping
      double r;           // from the point to the lower end, in spacings
      double values[3];   // factors of the weights
    };

    /// All such cells of this edge, for a point at z.
    std::vector<Line> lines(double z, std::int64_t edge, double spacing) const;

    /// This rank's cell with this corner (before wrapping) and edge, or not_here.
    unsigned int find_cell(const EulerianSpace<dim> &space, Place corner, std::int64_t edge) const;

    /// Throws RunFailure when the kernel at this place reaches beyond a wall.
    void check_walls(const EulerianSpace<dim> &space,
                     unsigned int q,
                     const dealii::Point<dim> &x,
                     const Offset &z,
                     double radius) const;

    /// Makes the weights those that reproduce linear fields. Collective.
    void correct(const EulerianSpace<dim> &space, const LagrangianPoints &points);

    /// Calls visit(node of the cell, weight, r) for the nodes of a part.
    template <class Visit>
    void for_each_node(const Part &part, const Visit &visit) const;

    /// Calls visit(point, a, local index of the unknown, weight) for all that moves component a of
    /// a point.
    template <class Visit>
    void for_each_entry(const EulerianSpace<dim> &space, const Visit &visit) const;

    // What the case says.
    Kernel kernel;
    bool of_nodes; // the spacing: that of nodes, else the cells' edges
    bool reproducing;

    // This rank's cells, by the place of their lower corner, and the levels that they have.
    std::unordered_map<std::uint64_t, unsigned int> cell_at;
    std::vector<std::int64_t> edges;
    unsigned int revision = 0;

    // The geometry.
    NodalField<dim> zero;                    // of the points
    std::vector<std::array<bool, dim>> held; // components of them that are zero, as walls have them
    std::vector<Part> parts;
    std::vector<Correction> corrections;
  };


  namespace
  {
    template <int dim>
    [[noreturn]] void
    refuse(const unsigned int q, const dealii::Point<dim> &x, const std::string &why)
    {
      std::ostringstream message;
      message << "point " << q << " of a structure is at (" << x << "), " << why;
      throw RunFailure(message.str());
    }
  } // namespace


  template <int dim>
  void
  RegularisedDelta<dim>::set_geometry(const EulerianSpace<dim> &space,
                                      const LagrangianMesh<dim> &,
                                      const Positions<dim> &X,
                                      const LagrangianPoints &points)
  {
    const Positions<dim> x = points.positions(X);
    zero                   = NodalField<dim>(points);
    index_cells(space);
    const auto edge = edges_around(space, x, points);
    parts.clear();
    held.clear();
    corrections.assign(x.size(), {});
    agree(space.communicator(), [&] {
      for (unsigned int q = 0; q < x.size(); ++q)
        {
          held.push_back(space.domain().held(x[q]));
          add_point(space, q, x[q], std::int64_t(edge[q][0]));
        }
    });
    if (reproducing)
      correct(space, points);
  }


  template <int dim>
  void
  RegularisedDelta<dim>::index_cells(const EulerianSpace<dim> &space)
  {
    if (revision == space.revision())
      return;
    revision = space.revision();
    cell_at.clear();
    edges.clear();
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        cell_at.emplace(Lattice<dim>::key(space.lattice().nearest(space.cells()[c].lower)), c);
        const std::int64_t edge = edge_of(space, c);
        if (std::find(edges.begin(), edges.end(), edge) == edges.end())
          edges.push_back(edge);
      }
  }


  template <int dim>
  NodalValues<dealii::Tensor<1, 1>>
  RegularisedDelta<dim>::edges_around(const EulerianSpace<dim> &space,
                                      const Positions<dim> &x,
                                      const LagrangianPoints &points) const
  {
    agree(space.communicator(), [&] {
      for (unsigned int q = 0; q < x.size(); ++q)
        if (!space.forest().inside(x[q]))
          refuse(q, x[q], "outside the box");
    });
    NodalValues<dealii::Tensor<1, 1>> result(points);
    dealii::Point<dim> unit;
    for (unsigned int q = 0; q < x.size(); ++q)
      if (const unsigned int c = space.forest().locate(x[q], unit);
          c != CartesianForest<dim>::not_here)
        result[q][0] = edge_of(space, c);
    result.compress(space.communicator());
    result.update_ghosts();
    return result;
  }


  template <int dim>
  void
  RegularisedDelta<dim>::check_walls(const EulerianSpace<dim> &space,
                                     const unsigned int q,
                                     const dealii::Point<dim> &x,
                                     const Offset &z,
                                     const double radius) const
  {
    const Lattice<dim> &lattice = space.lattice();
    for (unsigned int a = 0; a < dim; ++a)
      if (!lattice.periodic(a) &&
          (z[a] < radius * (1 - 1e-9) || lattice.extent(a) - z[a] < radius * (1 - 1e-9)))
        {
          std::ostringstream why;
          why << "nearer to a side of the box than the kernel of the coupling reaches, which is "
              << radius * lattice.unit()[a] << "; \"reproducing\": true is for such places";
          refuse(q, x, why.str());
        }
  }


  template <int dim>
  void
  RegularisedDelta<dim>::add_point(const EulerianSpace<dim> &space,
                                   const unsigned int q,
                                   const dealii::Point<dim> &x,
                                   const std::int64_t edge)
  {
    const Lattice<dim> &lattice = space.lattice();
    const double spacing        = of_nodes ? edge / 2. : edge;
    Offset z                    = lattice.scaled(x);
    for (unsigned int a = 0; a < dim; ++a)
      if (lattice.periodic(a))
        z[a] -= lattice.extent(a) * std::floor(z[a] / lattice.extent(a));
    if (!reproducing)
      check_walls(space, q, x, z, kernel.radius() * spacing);

    for (const std::int64_t size : edges)
      {
        std::array<std::vector<Line>, dim> along;
        std::size_t n_cells = 1;
        for (unsigned int a = 0; a < dim; ++a)
          {
            along[a] = lines(z[a], size, spacing);
            n_cells *= along[a].size();
          }
        Part part{q, 0, {}, {}, size / 2. / spacing};
        for (std::size_t i = 0; i < n_cells; ++i)
          {
            Place corner;
            std::size_t rest = i;
            for (unsigned int a = 0; a < dim; ++a)
              {
                const Line &line = along[a][rest % along[a].size()];
                rest /= along[a].size();
                corner[a] = line.lower;
                part.r[a] = line.r;
                std::copy_n(line.values, 3, part.line[a]);
              }
            part.cell = find_cell(space, corner, size);
            if (part.cell == CartesianForest<dim>::not_here)
              continue;
            if (size != edge && !reproducing)
              refuse(q,
                     x,
                     "where the kernel of the coupling reaches cells of another size; "
                     "\"reproducing\": true is for such places");
            parts.push_back(part);
          }
      }
  }


  template <int dim>
  std::vector<typename RegularisedDelta<dim>::Line>
  RegularisedDelta<dim>::lines(const double z, const std::int64_t edge, const double spacing) const
  {
    // The cell's rule: the trapezium rule between its nodes, which on equal cells weighs all nodes
    // alike, or Simpson's, which is exact for quadratic velocities.
    const double middle = of_nodes ? 1. / 2 : 2. / 3, radius = kernel.radius() * spacing;
    const std::int64_t first = std::floor((z - radius) / edge),
                       end   = std::ceil((z + radius) / edge);
    std::vector<Line> result;
    for (std::int64_t i = first; i < end; ++i)
      {
        Line line{i * edge, (i * edge - z) / spacing, {}};
        bool reached = false;
        for (unsigned int k = 0; k < 3; ++k)
          {
            const double phi = kernel(line.r + k * (edge / 2. / spacing));
            line.values[k]   = phi * edge / spacing * (k == 1 ? middle : (1 - middle) / 2);
            reached          = reached || phi > 0;
          }
        if (reached)
          result.push_back(line);
      }
    return result;
  }


  template <int dim>
  unsigned int
  RegularisedDelta<dim>::find_cell(const EulerianSpace<dim> &space,
                                   Place corner,
                                   const std::int64_t edge) const
  {
    if (!space.lattice().wrap(corner))
      return CartesianForest<dim>::not_here;
    const auto found = cell_at.find(Lattice<dim>::key(corner));
    return found != cell_at.end() && edge_of(space, found->second) == edge
             ? found->second
             : CartesianForest<dim>::not_here;
  }


  template <int dim>
  template <class Visit>
  void
  RegularisedDelta<dim>::for_each_node(const Part &part, const Visit &visit) const
  {
    const Correction &c = corrections[part.point];
    for (unsigned int node = 0; node < n; ++node)
      {
        double weight = 1;
        Offset r      = part.r;
        for (unsigned int a = 0, rest = node; a < dim; ++a, rest /= 3)
          {
            weight *= part.line[a][rest % 3];
            r[a] += part.step * (rest % 3);
          }
        if (weight != 0)
          visit(node, weight * (c.constant + c.slope * r), r);
      }
  }


  template <int dim>
  template <class Visit>
  void
  RegularisedDelta<dim>::for_each_entry(const EulerianSpace<dim> &space, const Visit &visit) const
  {
    for (const Part &part : parts)
      {
        const unsigned int *dofs = space.velocity_dofs(part.cell);
        for_each_node(part, [&](const unsigned int node, const double weight, const Offset &) {
          for (unsigned int a = 0; a < dim; ++a)
            if (!held[part.point][a])
              visit(part.point, a, dofs[a * n + node], weight);
        });
      }
  }


  template <int dim>
  void
  RegularisedDelta<dim>::correct(const EulerianSpace<dim> &space, const LagrangianPoints &points)
  {
    NodalValues<Moments> moments(points);
    for (const Part &part : parts)
      for_each_node(part, [&](const unsigned int, const double weight, const Offset &r) {
        Moments &sum   = moments[part.point];
        unsigned int k = 0;
        sum[k++] += weight;
        for (unsigned int a = 0; a < dim; ++a)
          sum[k++] += weight * r[a];
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int b = a; b < dim; ++b)
            sum[k++] += weight * r[a] * r[b];
      });
    moments.compress(space.communicator());
    moments.update_ghosts();

    // c(r) = 1/m + slope . (r - mean) has sum_n w_n c(r_n) = 1; that sum_n w_n c(r_n) r_n = 0 is an
    // equation for the slope with the covariance of the nodes. It is regular: weights are positive
    // within the kernel's reach, in which the cell around the point has two nodes in each
    // direction.
    for (unsigned int q = 0; q < moments.size(); ++q)
      {
        const double mass = moments[q][0];
        Offset mean;
        dealii::Tensor<2, dim> covariance;
        unsigned int k = 1;
        for (unsigned int a = 0; a < dim; ++a)
          mean[a] = moments[q][k++] / mass;
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int b = a; b < dim; ++b)
            covariance[a][b] = covariance[b][a] = moments[q][k++] - mass * mean[a] * mean[b];
        corrections[q].slope    = -invert(covariance) * mean;
        corrections[q].constant = 1 / mass - corrections[q].slope * mean;
      }
  }


  template <int dim>
  void
  RegularisedDelta<dim>::interpolate(const EulerianSpace<dim> &space,
                                     const VelocityVector &u,
                                     NodalField<dim> &U) const
  {
    U = zero;
    for_each_entry(space,
                   [&](const unsigned int q,
                       const unsigned int a,
                       const unsigned int dof,
                       const double weight) { U[q][a] += weight * u.local_element(dof); });
    U.compress(space.communicator());
    U.update_ghosts();
  }


  template <int dim>
  void
  RegularisedDelta<dim>::spread(const EulerianSpace<dim> &space,
                                const NodalField<dim> &f,
                                VelocityVector &rhs) const
  {
    rhs.zero_out_ghost_values();
    for_each_entry(space,
                   [&](const unsigned int q,
                       const unsigned int a,
                       const unsigned int dof,
                       const double weight) { rhs.local_element(dof) += weight * f[q][a]; });
    rhs.compress(dealii::VectorOperation::add);
  }


  template <int dim>
  MatrixEntries
  RegularisedDelta<dim>::entries(const EulerianSpace<dim> &space) const
  {
    MatrixEntries result;
    for_each_entry(
      space,
      [&](const unsigned int q, const unsigned int a, const unsigned int dof, const double weight) {
        result.push_back({std::uint64_t(q) * dim + a,
                          space.velocity.get_partitioner()->local_to_global(dof),
                          weight});
      });
    return result;
  }
} // namespace feib


FEIB_PLUGIN("regularised_delta", "1.0", registry)
{
  registry.add<feib::CouplingOperator, feib::RegularisedDelta>("regularised_delta",
                                                               regularised_delta_schema);
}
