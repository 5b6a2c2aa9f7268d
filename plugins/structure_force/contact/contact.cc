// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/message.h>
#include <feib/plugin.h>
#include <feib/registry.h>
#include <feib/structure_force.h>

#include "contact_schema.h"
#include "surface.h"

#include <map>
#include <optional>

namespace feib
{
  /// Repulsion at short range between the parts of a structure, of parts with themselves, and from
  /// walls:
  ///   E = k d sum_i w_i [ sum_F c_F b(|X_i - F|/d) + sum_walls b(|X_i - wall|/d) ],
  ///   b(r) = -(1 - r)^2 ln r for r < 1, else 0,
  /// over nodes i of the surface, w_i what they stand for, and facets, edges and vertices F of the
  /// surface apart from them. c_F is such that, with all distances alike, those c_F add up to 1
  /// that lie around any point of the surface: where it is flat, or a node looks at a ridge, just
  /// one b is left, whatever the mesh (Li et al., ACM Trans. Graph. 39 (2020) 49, and their
  /// convergent formulation of 2023).
  template <int dim>
  class Contact : public StructureForce<dim>
  {
  public:
    using Body      = typename StructureForce<dim>::Body;
    using Stiffness = typename StructureForce<dim>::Stiffness;
    using Vector    = dealii::Tensor<1, dim>;

    explicit Contact(const Parameters &parameters)
      : parameters(parameters)
      , range(parameters.number("range"))
      , strength(parameters.number("strength"))
    {}

    void
    attach(const Body &body) override
    {
      double self_distance = std::numeric_limits<double>::infinity();
      if (parameters.has("self_distance"))
        self_distance = parameters.number("self_distance");
      if (self_distance < 2 * range)
        parameters.fail("self_distance",
                        "must be at least 2 ranges, " + readable(2 * range) +
                          ", that neighbours do not repel each other; found " +
                          readable(self_distance));
      for (unsigned int a = 0; a < dim; ++a)
        if (const double length = body.domain.upper[a] - body.domain.lower[a];
            body.domain.periodic(a) && range > length / 4)
          parameters.fail("range",
                          "must be at most a quarter of the box in a periodic direction, " +
                            readable(length / 4) + ", found " + readable(range));
      communicator = body.mesh.communicator();
      domain       = &body.domain;
      surface.emplace(body.mesh, body.positions, body.domain, self_distance);
      for (const unsigned int i : surface->nodes)
        names[i] = body.mesh.node_number(i);
      last = body.positions;
      check_start();
      if (parameters.boolean("walls"))
        find_walls();
      reference_measures = body.mesh.node_measures();
    }

    double
    energy(const Positions<dim> &X) const override
    {
      double sum = 0;
      for (const Term &term : terms_at(X))
        sum += strength * range * term.weight * barrier(distance(term, X), 0);
      return sum;
    }

    void
    load(const Positions<dim> &X, NodalField<dim> &load) const override
    {
      for (const Term &term : terms_at(X))
        {
          const Gap gap(term, X);
          const double slope = strength * term.weight * barrier(gap.r.norm(), 1) / gap.r.norm();
          for (unsigned int j = 0; j < term.n; ++j)
            load[term.nodes[j]] -= slope * gap.shares[j] * gap.r;
        }
    }

    void
    load_derivative(const Positions<dim> &X,
                    const NodalField<dim> &dX,
                    NodalField<dim> &dload) const override
    {
      for (const Term &term : terms_at(X))
        for_each_entry(term, X, [&](const auto &row, const auto &column, const double value) {
          dload[row.first][row.second] -= value * dX[column.first][column.second];
        });
    }

    void
    tangent(const Positions<dim> &X, MatrixEntries &entries) const override
    {
      const std::vector<Term> &all = terms_at(X);
      const std::size_t n_ranks    = dealii::Utilities::MPI::n_mpi_processes(communicator),
                        rank       = dealii::Utilities::MPI::this_mpi_process(communicator);
      for (std::size_t t = all.size() * rank / n_ranks; t < all.size() * (rank + 1) / n_ranks; ++t)
        for_each_entry(all[t], X, [&](const auto &row, const auto &column, const double value) {
          entries.push_back({std::uint64_t(row.first) * dim + row.second,
                             std::uint64_t(column.first) * dim + column.second,
                             value});
        });
    }

    /// At least that of a contact at half of the range: what is not in contact yet will be.
    Stiffness
    stiffness(const Positions<dim> &X) const override
    {
      NodalField<dim> rows(reference_measures.size());
      for (const Term &term : terms_at(X))
        for_each_entry(term, X, [&](const auto &row, const auto &, const double value) {
          rows[row.first][row.second] += std::abs(value);
        });
      const double half = strength / range * barrier(range / 2, 2);
      double result     = 0;
      for (const unsigned int i : surface->nodes)
        for (unsigned int a = 0; a < dim; ++a)
          result =
            std::max(result,
                     std::max(rows[i][a], 2 * half * surface->measures[i]) / reference_measures[i]);
      return {result, 0.};
    }

    void
    update_state(const Positions<dim> &X) override
    {
      check_way(X);
      last = X;
    }

    void
    archive(Archive &archive) override
    {
      archive("last", last);
    }

  private:
    using Facet = typename ContactSurface<dim>::Facet;

    /// weight times b of the distance of a node from the plane, line or point of others; or, n = 1,
    /// from a wall.
    struct Term
    {
      double weight;
      unsigned int n;                          // nodes
      std::array<unsigned int, dim + 1> nodes; // the node, and those of what it is near
      Vector shift;                            // of the others
      unsigned int normal;                     // of the wall
      double wall;                             // its place
    };

    /// A face of the box that repels some nodes where it is tight.
    struct Wall
    {
      unsigned int normal;
      bool upper;
      double place;
      std::vector<unsigned int> nodes;
    };

    /// The derivatives of half the squared distance of a term by its nodes, shares[j] r, and those
    /// of these. The nearest point is where the distance is least, so that its motion counts in
    /// second derivatives alone.
    struct Gap
    {
      Gap(const Term &term, const Positions<dim> &X)
        : n(term.n)
      {
        shares[0] = 1;
        if (n == 1)
          {
            r[term.normal] = X[term.nodes[0]][term.normal] - term.wall;
            return;
          }
        for (unsigned int k = 1; k < n; ++k)
          corners[k - 1] = X[term.nodes[k]] + term.shift;
        const auto weights = nearest_in_plane<dim>(X[term.nodes[0]], corners, n - 1);
        r                  = X[term.nodes[0]] - combination<dim>(weights, corners, n - 1);
        for (unsigned int k = 1; k < n; ++k)
          shares[k] = -weights[k - 1];
      }

      /// The second derivatives, without the share of a wall's normal: from nodes j and k.
      dealii::Tensor<2, dim>
      second(const unsigned int j, const unsigned int k) const
      {
        dealii::Tensor<2, dim> result;
        if (n == 1)
          return outer_product(r, r) / r.norm_square();
        for (unsigned int a = 0; a < dim; ++a)
          result[a][a] = shares[j] * shares[k];
        const auto edge = [&](const unsigned int m) { return corners[m] - corners[0]; };
        // That of the nearest point's coordinate along edge m and the place of node j.
        const auto mixed = [&](const unsigned int j, const unsigned int m) {
          return -shares[j] * edge(m) - (double(j == m + 1) - double(j == 1)) * r;
        };
        if (n == 3)
          result -= outer_product(mixed(j, 1), mixed(k, 1)) / edge(1).norm_square();
        if (n == 4)
          {
            const double aa = edge(1) * edge(1), ab = edge(1) * edge(2), bb = edge(2) * edge(2);
            result -= (bb * outer_product(mixed(j, 1), mixed(k, 1)) -
                       ab * outer_product(mixed(j, 1), mixed(k, 2)) -
                       ab * outer_product(mixed(j, 2), mixed(k, 1)) +
                       aa * outer_product(mixed(j, 2), mixed(k, 2))) /
                      (aa * bb - ab * ab);
          }
        return result;
      }

      const unsigned int n;
      Vector r; // from the nearest point to the node
      std::array<double, dim + 1> shares{};
      Corners<dim> corners;
    };

    static double
    distance(const Term &term, const Positions<dim> &X)
    {
      return Gap(term, X).r.norm();
    }

    /// b and its derivatives by r, at a distance.
    double
    barrier(const double distance, const unsigned int derivative) const
    {
      const double r = distance / range, s = 1 - r;
      if (r >= 1)
        return 0;
      return derivative == 0   ? -s * s * std::log(r)
             : derivative == 1 ? 2 * s * std::log(r) - s * s / r
                               : -2 * std::log(r) + 4 * s / r + s * s / (r * r);
    }

    /// The second derivatives of a term's energy.
    template <typename Action>
    void
    for_each_entry(const Term &term, const Positions<dim> &X, const Action &action) const
    {
      const Gap gap(term, X);
      const double d = gap.r.norm(), first = strength * term.weight * barrier(d, 1) / d,
                   second = (strength / range * term.weight * barrier(d, 2) - first) / (d * d);
      for (unsigned int j = 0; j < term.n; ++j)
        for (unsigned int k = 0; k < term.n; ++k)
          {
            const dealii::Tensor<2, dim> block =
              second * gap.shares[j] * gap.shares[k] * outer_product(gap.r, gap.r) +
              first * gap.second(j, k);
            for (unsigned int a = 0; a < dim; ++a)
              for (unsigned int b = 0; b < dim; ++b)
                action(std::make_pair(term.nodes[j], a),
                       std::make_pair(term.nodes[k], b),
                       block[a][b]);
          }
    }

    /// Those within the range at X; kept for the next question.
    const std::vector<Term> &
    terms_at(const Positions<dim> &X) const
    {
      if (X == place_of_terms)
        return terms;
      terms.clear();
      std::vector<std::pair<Facet, Vector>> near; // to the node asked about last
      unsigned int node = 0;
      const auto finish = [&] {
        add_terms(X, node, near);
        near.clear();
      };
      surface->for_each_near(X,
                             range,
                             [&](const unsigned int i, const Facet &facet, const Vector &shift) {
                               if (i != node)
                                 finish();
                               node = i;
                               near.emplace_back(facet, shift);
                             });
      finish();
      for (const Wall &wall : walls)
        for (const unsigned int i : wall.nodes)
          if (std::abs(height(wall, X[i])) < range && tight(wall, X[i]))
            terms.push_back({surface->measures[i], 1, {i}, {}, wall.normal, wall.place});
      place_of_terms = X;
      return terms;
    }

    /// The terms of a node, from the facets it is near to. A facet counts 1; an edge or a vertex,
    /// what is lacking to 1 when all facets and edges that have it are summed up. All of these that
    /// matter are there, as none is farther away. Each is seen at its nearest face alone, and most
    /// cancel out.
    void
    add_terms(const Positions<dim> &X,
              const unsigned int i,
              const std::vector<std::pair<Facet, Vector>> &near) const
    {
      using Face = std::vector<unsigned int>; // its nodes, sorted
      std::map<Face, std::pair<double, Vector>> faces;
      for (const auto &[facet, shift] : near)
        {
          Face nodes(facet.begin(), facet.end());
          std::sort(nodes.begin(), nodes.end());
          for (unsigned int subset = 1; subset < 1u << dim; ++subset)
            faces.emplace(part_of(nodes, subset), std::make_pair(1., shift));
        }
      std::map<Face, std::pair<double, Vector>> seen;
      for (unsigned int n = dim; n > 0; --n)
        for (auto &[nodes, share] : faces)
          {
            if (nodes.size() != n)
              continue;
            for (unsigned int subset = 1; subset + 1 < 1u << n; ++subset)
              faces.at(part_of(nodes, subset)).first -= share.first;
            Corners<dim> corners;
            for (unsigned int k = 0; k < n; ++k)
              corners[k] = X[nodes[k]] + share.second;
            const auto [subset, distance] = nearest_face<dim>(X[i], corners, n);
            if (distance < range)
              seen.emplace(part_of(nodes, subset), std::make_pair(0., share.second))
                .first->second.first += share.first;
          }
      for (const auto &[nodes, share] : seen)
        if (share.first != 0)
          {
            Term term{surface->measures[i] * share.first,
                      static_cast<unsigned int>(nodes.size() + 1),
                      {i},
                      share.second,
                      0,
                      0.};
            std::copy(nodes.begin(), nodes.end(), term.nodes.begin() + 1);
            terms.push_back(term);
          }
    }

    /// Those of some nodes whose bits are set.
    static std::vector<unsigned int>
    part_of(const std::vector<unsigned int> &nodes, const unsigned int subset)
    {
      std::vector<unsigned int> result;
      for (unsigned int k = 0; k < nodes.size(); ++k)
        if (subset >> k & 1)
          result.push_back(nodes[k]);
      return result;
    }

    /// The faces of the box that may be walls. What stands on one, with what of its part starts
    /// within the range, is not repelled from it.
    void
    find_walls()
    {
      for (unsigned int f = 0; f < 2 * dim; ++f)
        {
          const unsigned int a = f / 2;
          if (domain->periodic(a))
            continue;
          Wall wall{a, f % 2 == 1, f % 2 ? domain->upper[a] : domain->lower[a], {}};
          const double touching = round_off(domain->lower[a], domain->upper[a]);
          std::set<unsigned int> standing; // parts
          for (const unsigned int i : surface->nodes)
            if (height(wall, last[i]) <= touching && tight(wall, last[i]))
              standing.insert(surface->part[i]);
          for (const unsigned int i : surface->nodes)
            if (height(wall, last[i]) >= range || standing.count(surface->part[i]) == 0)
              wall.nodes.push_back(i);
          walls.push_back(wall);
        }
    }

    static double
    height(const Wall &wall, const dealii::Point<dim> &x)
    {
      return (x[wall.normal] - wall.place) * (wall.upper ? -1 : 1);
    }

    /// Whether nothing can cross the face beside a place.
    bool
    tight(const Wall &wall, dealii::Point<dim> x) const
    {
      for (unsigned int a = 0; a < dim; ++a)
        if (domain->periodic(a))
          {
            const double period = domain->upper[a] - domain->lower[a];
            x[a] -= period * std::floor((x[a] - domain->lower[a]) / period);
          }
      x[wall.normal] = wall.place;
      return domain->held(x)[wall.normal];
    }

    std::string
    text(const unsigned int i, const Facet &facet) const
    {
      std::string result = "node " + std::to_string(names.at(i)) + " and the facet of nodes ";
      for (unsigned int k = 0; k < dim; ++k)
        result += (k == 0         ? ""
                   : k + 1 == dim ? " and "
                                  : ", ") +
                  std::to_string(names.at(facet[k]));
      return result;
    }

    /// Refuses a structure that crosses itself at the start.
    void
    check_start() const
    {
      const auto check = [&](const unsigned int i, const Facet &facet, const Vector &shift) {
        Corners<dim> corners;
        for (unsigned int k = 0; k < dim; ++k)
          corners[k] = last[facet[k]] + shift;
        for (const unsigned int j : surface->edges[i])
          if (surface->apart(j, facet, shift) && crosses<dim>(last[i], last[j], corners))
            parameters.fail("",
                            "keeps apart what starts apart; the structure crosses itself at the "
                            "start, between " +
                              text(i, facet));
      };
      surface->for_each_near(last, surface->longest_edge(last), check);
    }

    /// Throws RunFailure where nodes and facets, or edges in space, have passed through each other
    /// on their straight way from their last places, or nodes through a wall.
    void
    check_way(const Positions<dim> &X) const
    {
      for (const Wall &wall : walls)
        for (const unsigned int i : wall.nodes)
          if (height(wall, X[i]) <= 0 && tight(wall, X[i]))
            throw RunFailure("node " + std::to_string(names.at(i)) +
                             " has passed through the wall " + "xyz"[wall.normal] +
                             (wall.upper ? "_max" : "_min"));
      double farthest = 0;
      for (const unsigned int i : surface->nodes)
        farthest = std::max(farthest, X[i].distance(last[i]));
      if (farthest == 0)
        return;
      // Of edges in space that meet, nodes were as near as that and the length of an edge.
      const double reach = 2 * farthest + (dim == 3 ? surface->longest_edge(last) : 0.);
      surface->for_each_near(
        last, reach, [&](const unsigned int i, const Facet &facet, const Vector &shift) {
          if (passed(X, i, facet, shift))
            throw RunFailure(text(i, facet) + " have passed through each other");
        });
    }

    bool
    passed(const Positions<dim> &X,
           const unsigned int i,
           const Facet &facet,
           const Vector &shift) const
    {
      std::array<dealii::Point<dim>, dim + 1> from, to;
      const auto set = [&](const unsigned int k, const unsigned int node, const Vector &shift) {
        from[k] = last[node] + shift;
        to[k]   = X[node] + shift;
      };
      set(0, i, {});
      for (unsigned int k = 0; k < dim; ++k)
        set(k + 1, facet[k], shift);
      if (meet<dim>(from, to, 1))
        return true;
      if (dim == 3)
        for (const unsigned int j : surface->edges[i])
          if (surface->apart(j, facet, shift))
            for (unsigned int k = 0; k < dim; ++k)
              {
                set(1, j, {});
                set(2, facet[k], shift);
                set(dim, facet[(k + 1) % dim], shift);
                if (meet<dim>(from, to, 2))
                  return true;
              }
      return false;
    }

    const Parameters parameters;
    const double range, strength;
    MPI_Comm communicator     = MPI_COMM_WORLD;
    const Domain<dim> *domain = nullptr;
    std::optional<ContactSurface<dim>> surface;
    std::map<unsigned int, std::uint64_t> names; // of the nodes of the surface, for messages
    std::vector<Wall> walls;
    std::vector<double> reference_measures; // of all nodes, for the forecast of steps
    Positions<dim> last;                    // where the nodes were at the end of the last step
    mutable Positions<dim> place_of_terms;
    mutable std::vector<Term> terms;
  };
} // namespace feib

FEIB_PLUGIN("contact", "1.0", registry)
{
  registry.add<feib::StructureForce, feib::Contact>("contact", contact_schema);
}
