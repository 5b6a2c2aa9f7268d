// SPDX-License-Identifier: LGPL-2.1-or-later
#include "built_in_meshes.h"
#include "mesh_builder.h"

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <array>
#include <map>

namespace feib
{
  namespace
  {
    using dealii::Point;
    using dealii::Tensor;

    LagrangianMesh<3>
    box(const Parameters &block)
    {
      const Point<3> lower = point<3>(block, "lower"), upper = point<3>(block, "upper");
      check_corners(block, lower, upper);
      const std::vector<int> n = cells(block, 6);
      Builder<3> builder(block.communicator());
      for (int k = 0; k <= n[2]; ++k)
        for (int j = 0; j <= n[1]; ++j)
          for (int i = 0; i <= n[0]; ++i)
            builder.node(Point<3>(lower[0] + (upper[0] - lower[0]) * i / n[0],
                                  lower[1] + (upper[1] - lower[1]) * j / n[1],
                                  lower[2] + (upper[2] - lower[2]) * k / n[2]));
      const std::array<unsigned int, 3> stride{{1u, n[0] + 1u, (n[0] + 1u) * (n[1] + 1u)}};
      // Kuhn: one tetrahedron for each order of the three directions, all along the main diagonal.
      std::array<unsigned int, 3> order{{0, 1, 2}};
      for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
          for (int i = 0; i < n[0]; ++i)
            do
              {
                const unsigned int a = i * stride[0] + j * stride[1] + k * stride[2];
                const unsigned int b = a + stride[order[0]], c = b + stride[order[1]];
                builder.simplex({a, b, c, c + stride[order[2]]});
            } while (std::next_permutation(order.begin(), order.end()));
      return builder.build(3);
    }

    /// The elements with all edges halved. New nodes are pushed out to the mean distance of the
    /// edge's ends from the origin.
    std::vector<std::vector<unsigned int>>
    finer(Builder<3> &builder, const std::vector<std::vector<unsigned int>> &elements)
    {
      std::map<std::pair<unsigned int, unsigned int>, unsigned int> middles;
      const auto middle = [&](const unsigned int a, const unsigned int b) {
        const auto [found, is_new] = middles.try_emplace(std::minmax(a, b));
        if (is_new)
          {
            const Point<3> x = builder.nodes[a], y = builder.nodes[b];
            const Tensor<1, 3> sum = Tensor<1, 3>(x) + Tensor<1, 3>(y);
            found->second = builder.node(Point<3>(sum / sum.norm() * (x.norm() + y.norm()) / 2));
          }
        return found->second;
      };
      std::vector<std::vector<unsigned int>> result;
      for (const auto &v : elements)
        {
          const unsigned int ab = middle(v[0], v[1]), bc = middle(v[1], v[2]),
                             ca = middle(v[2], v[0]);
          if (v.size() == 3)
            {
              result.push_back({v[0], ab, ca});
              result.push_back({v[1], bc, ab});
              result.push_back({v[2], ca, bc});
              result.push_back({ab, bc, ca});
              continue;
            }
          const unsigned int ad = middle(v[0], v[3]), bd = middle(v[1], v[3]),
                             cd = middle(v[2], v[3]);
          result.push_back({v[0], ab, ca, ad});
          result.push_back({v[1], ab, bc, bd});
          result.push_back({v[2], ca, bc, cd});
          result.push_back({v[3], ad, bd, cd});
          // The octahedron in the middle, cut along its shortest diagonal: ends, and the four
          // other nodes in a circle.
          std::array<std::array<unsigned int, 6>, 3> cuts{
            {{{ab, cd, bc, bd, ad, ca}}, {{bc, ad, ab, bd, cd, ca}}, {{ca, bd, ab, bc, cd, ad}}}};
          const auto shortest =
            std::min_element(cuts.begin(), cuts.end(), [&](const auto &p, const auto &q) {
              return builder.nodes[p[0]].distance(builder.nodes[p[1]]) <
                     builder.nodes[q[0]].distance(builder.nodes[q[1]]) * (1 - 1e-10);
            });
          for (unsigned int k = 0; k < 4; ++k)
            result.push_back(
              {(*shortest)[0], (*shortest)[1], (*shortest)[2 + k], (*shortest)[2 + (k + 1) % 4]});
        }
      return result;
    }

    /// The icosahedron (solid: with its centre, 20 tetrahedra), refined; shells stay spherical.
    LagrangianMesh<3>
    icosahedral(const Parameters &block, const bool solid)
    {
      const Point<3> centre          = point<3>(block, "centre");
      const double radius            = block.number("radius");
      const unsigned int refinements = block.integer("refinements");

      Builder<3> builder(block.communicator()); // on the unit ball around the origin
      const double golden = (1 + std::sqrt(5.)) / 2;
      for (const double one : {-1., 1.})
        for (const double g : {-golden, golden})
          for (unsigned int direction = 0; direction < 3; ++direction)
            {
              Point<3> x;
              x[direction]           = one;
              x[(direction + 1) % 3] = g;
              builder.node(Point<3>(x / x.norm()));
            }
      const double edge = 2 / std::sqrt(1 + golden * golden);
      std::vector<std::vector<unsigned int>> elements;
      const auto near = [&](const unsigned int i, const unsigned int j) {
        return builder.nodes[i].distance(builder.nodes[j]) < 1.1 * edge;
      };
      for (unsigned int i = 0; i < 12; ++i)
        for (unsigned int j = 0; j < i; ++j)
          for (unsigned int k = 0; k < j; ++k)
            if (near(i, j) && near(j, k) && near(k, i))
              elements.push_back({i, j, k});
      if (solid)
        {
          const unsigned int origin = builder.node(Point<3>());
          for (auto &element : elements)
            element.push_back(origin);
        }

      for (unsigned int r = 0; r < refinements; ++r)
        elements = finer(builder, elements);
      for (Point<3> &x : builder.nodes)
        x = centre + radius * Tensor<1, 3>(x);
      for (const auto &element : elements)
        builder.simplex(element);
      return builder.build(solid ? 3 : 2);
    }

    LagrangianMesh<3>
    sphere(const Parameters &block)
    {
      return icosahedral(block, false);
    }

    LagrangianMesh<3>
    ball(const Parameters &block)
    {
      return icosahedral(block, true);
    }

    /// The directions across the axis that a block names, and along it: an orthonormal frame, the
    /// axes of space in their order where the axis is one of them.
    Tensor<2, 3>
    frame(const Parameters &block)
    {
      const Point<3> axis = point<3>(block, "axis");
      if (!(axis.norm() > 0) || !std::isfinite(axis.norm()))
        block.fail("axis", "must have a direction, found [0, 0, 0]");
      const Tensor<1, 3> along = axis / axis.norm();
      unsigned int main        = 0;
      for (unsigned int a = 1; a < 3; ++a)
        if (std::abs(along[a]) > std::abs(along[main]))
          main = a;
      Tensor<1, 3> across;
      across[(main + 1) % 3] = 1;
      across -= (across * along) * along;
      across /= across.norm();
      Tensor<2, 3> result; // rows
      result[0] = across;
      result[1] = cross_product_3d(along, across);
      result[2] = along;
      return result;
    }

    /// The body whose section is a plane mesh, in @p n layers along the axis. Each prism is cut
    /// into three tetrahedra, its sides along the diagonal from the lower end of the smaller
    /// number.
    LagrangianMesh<3>
    extruded(const LagrangianMesh<2> &section, const Parameters &block, const unsigned int n)
    {
      const Point<3> centre    = point<3>(block, "centre");
      const double length      = block.number("length");
      const Tensor<2, 3> e     = frame(block);
      const unsigned int layer = section.n_nodes();
      Builder<3> builder(block.communicator());
      for (unsigned int k = 0; k <= n; ++k)
        for (const Point<2> &x : section.nodes())
          builder.node(centre + x[0] * e[0] + x[1] * e[1] + length * (double(k) / n - .5) * e[2]);
      for (unsigned int k = 0; k < n; ++k)
        for (const auto &triangle : section.elements())
          {
            std::array<unsigned int, 3> v{
              {triangle.nodes[0], triangle.nodes[1], triangle.nodes[2]}};
            std::sort(v.begin(), v.end());
            for (unsigned int &node : v)
              node += k * layer;
            const unsigned int a = v[0], b = v[1], c = v[2];
            builder.simplex({a, b, c, c + layer});
            builder.simplex({a, b, b + layer, c + layer});
            builder.simplex({a, a + layer, b + layer, c + layer});
          }
      return builder.build(3);
    }

    LagrangianMesh<3>
    tube(const Parameters &block)
    {
      const std::vector<int> n = cells(block, 6);
      return extruded(ring_mesh(block, Point<2>(), n), block, n[2]);
    }

    LagrangianMesh<3>
    solid_cylinder(const Parameters &block)
    {
      const int rings = block.integer("rings"), layers = block.integer("layers");
      check_number(block, "layers", 18. * rings * rings * layers);
      return extruded(disc_mesh(Point<2>(), block.number("radius"), rings, block.communicator()),
                      block,
                      layers);
    }

    LagrangianMesh<3>
    cylinder_surface(const Parameters &block)
    {
      const Point<3> centre = point<3>(block, "centre");
      const double radius = block.number("radius"), length = block.number("length");
      const std::vector<int> n = cells(block, 2);
      if (n[0] < 3)
        block.fail("cells",
                   "needs at least 3 cells around the cylinder, found " + std::to_string(n[0]));
      const Tensor<2, 3> e = frame(block);
      return grid<3>(
        block.communicator(), n[0], n[1], true, [&](const unsigned int i, const unsigned int j) {
          const double angle = 2 * dealii::numbers::PI * (i % n[0]) / n[0];
          return centre + radius * std::cos(angle) * e[0] + radius * std::sin(angle) * e[1] +
                 length * (double(j) / n[1] - .5) * e[2];
        });
    }

    /// Across the one direction in which its corners agree.
    LagrangianMesh<3>
    rectangle(const Parameters &block)
    {
      const Point<3> lower = point<3>(block, "lower"), upper = point<3>(block, "upper");
      unsigned int normal = 3, n_equal = 0;
      for (unsigned int a = 0; a < 3; ++a)
        if (lower[a] == upper[a])
          {
            normal = a;
            ++n_equal;
          }
        else if (!(lower[a] < upper[a]))
          n_equal = 3;
      if (n_equal != 1)
        block.fail("upper",
                   "must be equal to \"lower\" in one direction, that of the normal, and greater "
                   "in the two others, found [" +
                     readable(upper[0]) + ", " + readable(upper[1]) + ", " + readable(upper[2]) +
                     "] and [" + readable(lower[0]) + ", " + readable(lower[1]) + ", " +
                     readable(lower[2]) + "]");
      const std::vector<int> n = cells(block, 2);
      // In the order s1, s2, s3, turned so that the normal points along its axis.
      const unsigned int first = normal == 0 ? 1 : 0, second = normal == 2 ? 1 : 2;
      const bool turned    = normal == 1;
      const unsigned int a = turned ? second : first, b = turned ? first : second;
      const int n_a = n[turned], n_b = n[!turned];
      return grid<3>(
        block.communicator(), n_a, n_b, false, [&](const unsigned int i, const unsigned int j) {
          Point<3> result = lower;
          result[a] += (upper[a] - lower[a]) * i / n_a;
          result[b] += (upper[b] - lower[b]) * j / n_b;
          return result;
        });
    }
  } // namespace


  template <>
  const std::vector<BuiltInMesh<3>> &
  built_in_meshes()
  {
    static const std::vector<BuiltInMesh<3>> meshes{{"sphere", 2, sphere},
                                                    {"cylinder", 2, cylinder_surface},
                                                    {"rectangle", 2, rectangle},
                                                    {"ball", 3, ball},
                                                    {"box", 3, box},
                                                    {"cylinder", 3, solid_cylinder},
                                                    {"tube", 3, tube}};
    return meshes;
  }
} // namespace feib
