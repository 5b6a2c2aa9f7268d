// SPDX-License-Identifier: LGPL-2.1-or-later
#include "built_in_meshes.h"
#include "mesh_builder.h"

#include <deal.II/base/numbers.h>

namespace feib
{
  namespace
  {
    using dealii::Point;
    using dealii::Tensor;

    // --- m = 1, dim = 2

    LagrangianMesh<2>
    curve(const Parameters &block, const bool closed)
    {
      const double length  = block.number("length");
      const unsigned int n = block.integer("elements");
      Builder<2> builder(block.communicator());
      const auto place = [&](const unsigned int i) { return Point<2>(length * i / n, 0); };
      for (unsigned int i = 0; i < (closed ? n : n + 1); ++i)
        builder.node(place(i));
      for (unsigned int i = 0; i < n; ++i)
        {
          builder.simplex({i, closed ? (i + 1) % n : i + 1});
          builder.simplices.back().corners[1] = place(i + 1);
        }
      return builder.build(1);
    }

    // --- m = dim = 2

    LagrangianMesh<2>
    rectangle(const Parameters &block)
    {
      const Point<2> lower = point<2>(block, "lower"), upper = point<2>(block, "upper");
      check_corners(block, lower, upper);
      const std::vector<int> n = cells(block, 2);
      return grid<2>(
        block.communicator(), n[0], n[1], false, [&](const unsigned int i, const unsigned int j) {
          return Point<2>(lower[0] + (upper[0] - lower[0]) * i / n[0],
                          lower[1] + (upper[1] - lower[1]) * j / n[1]);
        });
    }

    LagrangianMesh<2>
    periodic_strip(const Parameters &block)
    {
      const double length = block.number("length"), width = block.number("width");
      const std::vector<int> n = cells(block, 2);
      if (n[0] < 3)
        block.fail("cells",
                   "needs at least 3 cells along the strip, found " + std::to_string(n[0]));
      return grid<2>(
        block.communicator(), n[0], n[1], true, [&](const unsigned int i, const unsigned int j) {
          return Point<2>(length * i / n[0], width * j / n[1]);
        });
    }

    LagrangianMesh<2>
    ring(const Parameters &block)
    {
      return ring_mesh(block, point<2>(block, "centre"), cells(block, 2));
    }

    LagrangianMesh<2>
    disc(const Parameters &block)
    {
      return disc_mesh(point<2>(block, "centre"),
                       block.number("radius"),
                       block.integer("rings"),
                       block.communicator());
    }

    LagrangianMesh<2>
    closed_curve(const Parameters &block)
    {
      return curve(block, true);
    }

    LagrangianMesh<2>
    open_curve(const Parameters &block)
    {
      return curve(block, false);
    }
  } // namespace


  LagrangianMesh<2>
  ring_mesh(const Parameters &block, const Point<2> &centre, const std::vector<int> &n)
  {
    const double inner = block.number("inner_radius"), outer = block.number("outer_radius");
    if (!(inner < outer))
      block.fail("outer_radius",
                 "must be greater than \"inner_radius\" (" + readable(inner) + "), found " +
                   readable(outer));
    if (n[0] < 3)
      block.fail("cells", "needs at least 3 cells around the ring, found " + std::to_string(n[0]));
    return grid<2>(
      block.communicator(), n[0], n[1], true, [&](const unsigned int i, const unsigned int j) {
        // The same place, to the last bit, for both ends of a circle.
        const double angle  = 2 * dealii::numbers::PI * (i % n[0]) / n[0];
        const double radius = inner + (outer - inner) * j / n[1];
        return centre + radius * Tensor<1, 2>({std::cos(angle), std::sin(angle)});
      });
  }


  // Rings of 6, 12, 18, ... nodes around the centre: nearly equilateral triangles.
  LagrangianMesh<2>
  disc_mesh(const Point<2> &centre,
            const double radius,
            const unsigned int rings,
            const MPI_Comm communicator)
  {
    Builder<2> builder(communicator);
    const auto node = [](const unsigned int k, const unsigned int j) {
      return k == 0 ? 0 : 1 + 3 * k * (k - 1) + j % (6 * k);
    };
    builder.node(centre);
    for (unsigned int k = 1; k <= rings; ++k)
      for (unsigned int j = 0; j < 6 * k; ++j)
        {
          const double angle = dealii::numbers::PI * j / (3. * k);
          builder.node(centre +
                       (radius * k / rings) * Tensor<1, 2>({std::cos(angle), std::sin(angle)}));
        }
    for (unsigned int k = 1; k <= rings; ++k)
      for (unsigned int sector = 0; sector < 6; ++sector)
        for (unsigned int j = 0; j < k; ++j)
          {
            const unsigned int outer = sector * k + j, inner = sector * (k - 1) + j;
            builder.simplex({node(k, outer), node(k, outer + 1), node(k - 1, inner)});
            if (j + 1 < k)
              builder.simplex({node(k - 1, inner), node(k, outer + 1), node(k - 1, inner + 1)});
          }
    return builder.build(2);
  }


  template <>
  const std::vector<BuiltInMesh<2>> &
  built_in_meshes()
  {
    static const std::vector<BuiltInMesh<2>> meshes{{"closed_curve", 1, closed_curve},
                                                    {"open_curve", 1, open_curve},
                                                    {"rectangle", 2, rectangle},
                                                    {"periodic_strip", 2, periodic_strip},
                                                    {"disc", 2, disc},
                                                    {"ring", 2, ring}};
    return meshes;
  }
} // namespace feib
