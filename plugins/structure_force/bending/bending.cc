// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/expression.h>
#include <feib/periodic_images.h>
#include <feib/plugin.h>
#include <feib/registry.h>
#include <feib/structure_force/stencil_force.h>

#include "bending_schema.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace feib
{
  /// Resistance to bending, by discrete curvatures 2 tan(theta/2) of the angle theta between two
  /// elements (Bergou et al., ACM Trans. Graph. 27 (2008) 63). All measures are those of reference.
  ///
  /// Curves: E = sum over inner nodes of B/2 (2 tan(theta/2) / l - curvature)^2 l, l half the
  /// lengths of both elements. Converges to B/2 int (theta' - curvature)^2 ds.
  ///
  /// Surfaces: E = sum over inner edges of B/2 w (2 tan(theta/2) - d curvature)^2, w = |e|^2/A, A
  /// the area of both triangles and d = 2/3 A/|e| the distance of their centroids across the edge
  /// (Grinspun et al., Proc. Symp. Comput. Anim. (2003) 62, whose weight is 6 w / B).
  ///
  /// Where a structure goes on as its image in a periodic box, that is inside it.
  template <int dim>
  class Bending : public StencilForce<Bending<dim>, dim + 1, dim>
  {
  public:
    using Body      = typename StructureForce<dim>::Body;
    using Stiffness = typename StructureForce<dim>::Stiffness;

    template <typename Number>
    using Vector = std::array<Number, dim>;

    explicit Bending(const Parameters &parameters)
      : parameters(parameters)
      , rigidity(parameters.number("rigidity"))
    {}

    void
    attach(const Body &body) override
    {
      if (body.mesh.structure_dim() == dim)
        parameters.fail("",
                        "acts on curves and surfaces; this structure is a body, whose law resists "
                        "bending");
      const auto curvature =
        parse_expressions<dim>(parameters, "curvature", 1, Variables::reference);
      this->communicator = body.mesh.communicator();
      for (const auto &face : body.mesh.faces())
        if (!face.at_boundary())
          add_stencil(body.mesh, side(face, 0), side(face, 1), {}, *curvature);
      add_seams(body, *curvature);
      if (const Issues issues = curvature->not_finite(MPI_COMM_SELF); !issues.empty())
        throw Error(issues);
      if (parameters.boolean("initial_shape"))
        for (unsigned int s = 0; s < this->stencils.size(); ++s)
          {
            std::array<Vector<Lanes>, dim + 1> X;
            for (unsigned int k = 0; k <= dim; ++k)
              for (unsigned int a = 0; a < dim; ++a)
                X[k][a] = body.positions[this->stencils[s][k]][a] + (k == dim ? shifts[a][s] : 0.);
            rest[s] += angle(X)[0];
          }
    }

    template <typename Number>
    Number
    stencil_energy(const std::array<Vector<Number>, dim + 1> &X, const PointBatch &batch) const
    {
      std::array<Vector<Number>, dim + 1> in_place = X;
      for (unsigned int a = 0; a < dim; ++a)
        in_place[dim][a] = X[dim][a] + batch(shifts[a]);
      const Number bent = angle(in_place) - batch(rest);
      return bent * bent * batch(weights);
    }

    Stiffness
    stiffness(const Positions<dim> &) const override
    {
      return {0., rigidity};
    }

  private:
    using Mesh  = LagrangianMesh<dim>;
    using Face  = typename Mesh::Face;
    using Shift = dealii::Tensor<1, dim>;

    /// An element at a face, and its node opposite.
    struct Side
    {
      unsigned int element, opposite;
    };

    static Side
    side(const Face &face, const unsigned int which)
    {
      return {face.elements[which], face.opposite[which]};
    }

    /// By how many whole periods the nodes of one end are away from those of another, which must be
    /// the same for all; zero: they are not each other's images.
    static Shift
    shift_between(const Body &body, const Face &one, const Face &other)
    {
      constexpr double near            = 1e-6; // of the box
      const dealii::Tensor<1, dim> box = body.domain.upper - body.domain.lower;
      const Positions<dim> &X          = body.positions;
      for (unsigned int j = 0; j + 1 < dim; ++j)
        {
          Shift shift = X[one.nodes[j]] - X[other.nodes[0]];
          for (unsigned int a = 0; a < dim; ++a)
            shift[a] = body.domain.periodic(a) ? box[a] * std::round(shift[a] / box[a]) : 0.;
          const auto is_image = [&](const unsigned int i) {
            return std::any_of(one.nodes.begin(),
                               one.nodes.begin() + dim - 1,
                               [&](const unsigned int k) {
                                 return X[k].distance(X[i] + shift) < near * box.norm();
                               });
          };
          if (shift.norm() > 0 &&
              std::all_of(other.nodes.begin(), other.nodes.begin() + dim - 1, is_image))
            return shift;
        }
      return {};
    }

    /// The ends of a structure that are images of each other.
    void
    add_seams(const Body &body, const dealii::Function<dim> &curvature)
    {
      using Nodes = std::array<unsigned int, dim - 1>;
      const std::vector<unsigned int> images =
        periodic_images(body.domain, body.mesh, body.positions);
      std::map<Nodes, std::vector<const Face *>> ends; // that wait for their images
      for (const Face &face : body.mesh.faces())
        if (face.at_boundary())
          {
            Nodes nodes;
            for (unsigned int k = 0; k + 1 < dim; ++k)
              nodes[k] = images[face.nodes[k]];
            std::sort(nodes.begin(), nodes.end());
            std::vector<const Face *> &waiting = ends[nodes];
            Shift shift;
            const auto other =
              std::find_if(waiting.begin(), waiting.end(), [&](const Face *const end) {
                shift = shift_between(body, *end, face);
                return shift.norm() > 0;
              });
            if (other == waiting.end())
              {
                waiting.push_back(&face);
                continue;
              }
            add_stencil(body.mesh, side(**other, 0), side(face, 0), shift, curvature);
            waiting.erase(other);
          }
    }

    /// Between two elements, the @p second of which is by @p shift away from where it is.
    void
    add_stencil(const Mesh &mesh,
                const Side &one,
                const Side &other,
                const Shift &shift,
                const dealii::Function<dim> &curvature)
    {
      const auto &first = mesh.elements()[one.element], &second = mesh.elements()[other.element];
      const unsigned int k = one.opposite, l = other.opposite;
      double sign = 1;
      if constexpr (dim == 2)
        {
          // The nodes in the direction of the curve.
          const bool forward = k == 0;
          const auto &before = forward ? first : second, &after = forward ? second : first;
          const double length = (first.measure + second.measure) / 2;
          sign                = forward ? 1. : -1.;
          this->stencils.push_back({before.nodes[0], before.nodes[1], after.nodes[1]});
          weights.push_back(rigidity / 2 / length);
          rest.push_back(length * curvature.value(mesh.nodes()[before.nodes[1]]));
        }
      else
        {
          const double edge = 2 * first.measure * first.shape_gradients[k].norm(),
                       area = first.measure + second.measure;
          this->stencils.push_back(
            {first.nodes[(k + 1) % 3], first.nodes[(k + 2) % 3], first.nodes[k], second.nodes[l]});
          weights.push_back(rigidity / 2 * edge * edge / area);
          rest.push_back(2. / 3 * area / edge * curvature.value(first.centroid));
        }
      for (unsigned int a = 0; a < dim; ++a)
        shifts[a].push_back(sign * shift[a]);
    }

    template <typename Number>
    static Vector<Number>
    difference(const Vector<Number> &a, const Vector<Number> &b)
    {
      Vector<Number> result;
      for (unsigned int i = 0; i < dim; ++i)
        result[i] = a[i] - b[i];
      return result;
    }

    template <typename Number>
    static Number
    dot(const Vector<Number> &a, const Vector<Number> &b)
    {
      Number sum = a[0] * b[0];
      for (unsigned int i = 1; i < dim; ++i)
        sum += a[i] * b[i];
      return sum;
    }

    template <typename Number>
    static Vector<Number>
    cross(const Vector<Number> &a, const Vector<Number> &b)
    {
      return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }

    /// 2 tan(theta/2) of the angle between two vectors, given the sine times their lengths.
    template <typename Number>
    static Number
    twice_tangent(const Number &sine, const Vector<Number> &a, const Vector<Number> &b)
    {
      return Lanes(2.) * sine / (sqrt(dot(a, a) * dot(b, b)) + dot(a, b));
    }

    template <typename Number>
    static Number
    angle(const std::array<Vector<Number>, dim + 1> &X)
    {
      if constexpr (dim == 2)
        {
          const Vector<Number> a = difference(X[1], X[0]), b = difference(X[2], X[1]);
          return twice_tangent<Number>(a[0] * b[1] - a[1] * b[0], a, b);
        }
      else
        {
          const Vector<Number> edge = difference(X[1], X[0]);
          const Vector<Number> a    = cross(edge, difference(X[2], X[0])),
                               b    = cross(difference(X[3], X[0]), edge);
          return twice_tangent<Number>(dot(cross(a, b), edge) / sqrt(dot(edge, edge)), a, b);
        }
    }

    const Parameters parameters;
    const double rigidity;
    std::vector<double> weights, rest;           // of stencils
    std::array<std::vector<double>, dim> shifts; // of their last nodes
  };
} // namespace feib

FEIB_PLUGIN("bending", "1.0", registry)
{
  registry.add<feib::StructureForce, feib::Bending>("bending", bending_schema);
}
