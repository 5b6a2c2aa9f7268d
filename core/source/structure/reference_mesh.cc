// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/message.h>
#include <feib/reference_mesh.h>

#include "gmsh_file.h"

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace feib
{
  namespace
  {
    using dealii::Point;
    using dealii::Tensor;

    /// Nodes and simplices while a mesh is being built.
    template <int dim>
    struct Builder
    {
      explicit Builder(const MPI_Comm communicator)
        : communicator(communicator)
      {}

      const MPI_Comm communicator;
      std::vector<Point<dim>> nodes;
      std::vector<typename LagrangianMesh<dim>::Simplex> simplices;

      unsigned int
      node(const Point<dim> &place)
      {
        nodes.push_back(place);
        return nodes.size() - 1;
      }

      /// A simplex whose corners are where its nodes are.
      void
      simplex(const std::vector<unsigned int> &vertices, const unsigned int material_id = 0)
      {
        simplices.emplace_back();
        simplices.back().material_id = material_id;
        for (unsigned int k = 0; k < vertices.size(); ++k)
          {
            simplices.back().nodes[k]   = vertices[k];
            simplices.back().corners[k] = nodes[vertices[k]];
          }
      }

      LagrangianMesh<dim>
      build(const unsigned int structure_dim, std::vector<std::uint64_t> node_numbers = {})
      {
        return LagrangianMesh<dim>(
          structure_dim, std::move(nodes), simplices, std::move(node_numbers), communicator);
      }
    };

    template <int dim>
    Point<dim>
    point(const Parameters &block, const std::string &key)
    {
      const std::vector<double> numbers = block.numbers(key);
      Point<dim> result;
      for (unsigned int i = 0; i < dim; ++i)
        result[i] = numbers[i];
      return result;
    }

    /// Numbers of cells; far too many is a mistake, not a wish.
    std::vector<int>
    cells(const Parameters &block, const double simplices_per_cell)
    {
      std::vector<int> n = block.integers("cells");
      double total       = simplices_per_cell;
      for (const int n_k : n)
        total *= n_k;
      if (total > 1e8)
        block.fail("cells",
                   "gives " + std::to_string(std::llround(total / 1e6)) +
                     " million elements, at most 100 million are allowed");
      return n;
    }

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

    /// A grid of n x k quadrilaterals, cut along the same diagonal; @p place: from indices to
    /// reference coordinates; @p periodic: the n-th column is the first.
    template <typename Place>
    LagrangianMesh<2>
    grid(const MPI_Comm communicator,
         const unsigned int n,
         const unsigned int k,
         const bool periodic,
         const Place &place)
    {
      Builder<2> builder(communicator);
      const unsigned int columns = periodic ? n : n + 1;
      for (unsigned int j = 0; j <= k; ++j)
        for (unsigned int i = 0; i < columns; ++i)
          builder.node(place(i, j));
      const auto triangle = [&](const std::array<std::array<unsigned int, 2>, 3> &corners) {
        builder.simplices.emplace_back();
        for (unsigned int c = 0; c < 3; ++c)
          {
            const auto [i, j]                   = corners[c];
            builder.simplices.back().nodes[c]   = j * columns + i % columns;
            builder.simplices.back().corners[c] = place(i, j);
          }
      };
      for (unsigned int j = 0; j < k; ++j)
        for (unsigned int i = 0; i < n; ++i)
          {
            triangle({{{{i, j}}, {{i + 1, j}}, {{i + 1, j + 1}}}});
            triangle({{{{i, j}}, {{i + 1, j + 1}}, {{i, j + 1}}}});
          }
      return builder.build(2);
    }

    template <int dim>
    void
    check_corners(const Parameters &block, const Point<dim> &lower, const Point<dim> &upper)
    {
      for (unsigned int i = 0; i < dim; ++i)
        if (!(lower[i] < upper[i]))
          block.fail("upper",
                     "must be greater than \"lower\" in every direction, found " +
                       readable(upper[i]) + " and " + readable(lower[i]));
    }

    LagrangianMesh<2>
    rectangle(const Parameters &block)
    {
      const Point<2> lower = point<2>(block, "lower"), upper = point<2>(block, "upper");
      check_corners(block, lower, upper);
      const std::vector<int> n = cells(block, 2);
      return grid(
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
      return grid(
        block.communicator(), n[0], n[1], true, [&](const unsigned int i, const unsigned int j) {
          return Point<2>(length * i / n[0], width * j / n[1]);
        });
    }

    LagrangianMesh<2>
    ring(const Parameters &block)
    {
      const Point<2> centre = point<2>(block, "centre");
      const double inner = block.number("inner_radius"), outer = block.number("outer_radius");
      if (!(inner < outer))
        block.fail("outer_radius",
                   "must be greater than \"inner_radius\" (" + readable(inner) + "), found " +
                     readable(outer));
      const std::vector<int> n = cells(block, 2);
      if (n[0] < 3)
        block.fail("cells",
                   "needs at least 3 cells around the ring, found " + std::to_string(n[0]));
      return grid(
        block.communicator(), n[0], n[1], true, [&](const unsigned int i, const unsigned int j) {
          // The same place, to the last bit, for both ends of a circle.
          const double angle  = 2 * dealii::numbers::PI * (i % n[0]) / n[0];
          const double radius = inner + (outer - inner) * j / n[1];
          return centre + radius * Tensor<1, 2>({std::cos(angle), std::sin(angle)});
        });
    }

    /// Concentric rings of 6, 12, 18, ... nodes around the centre: nearly equilateral triangles.
    LagrangianMesh<2>
    disc(const Parameters &block)
    {
      const Point<2> centre    = point<2>(block, "centre");
      const double radius      = block.number("radius");
      const unsigned int rings = block.integer("rings");
      Builder<2> builder(block.communicator());
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

    // --- dim = 3

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

    /// The icosahedron (solid: with its centre, 20 tetrahedra), refined by halving all edges. New
    /// nodes are pushed out to the mean distance of the edge's ends, so shells stay spherical.
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
        {
          std::map<std::pair<unsigned int, unsigned int>, unsigned int> middles;
          const auto middle = [&](const unsigned int a, const unsigned int b) {
            const auto [found, is_new] = middles.try_emplace(std::minmax(a, b));
            if (is_new)
              {
                const Point<3> x = builder.nodes[a], y = builder.nodes[b];
                const Tensor<1, 3> sum = Tensor<1, 3>(x) + Tensor<1, 3>(y);
                found->second =
                  builder.node(Point<3>(sum / sum.norm() * (x.norm() + y.norm()) / 2));
              }
            return found->second;
          };
          std::vector<std::vector<unsigned int>> finer;
          for (const auto &v : elements)
            {
              const unsigned int ab = middle(v[0], v[1]), bc = middle(v[1], v[2]),
                                 ca = middle(v[2], v[0]);
              if (!solid)
                {
                  finer.push_back({v[0], ab, ca});
                  finer.push_back({v[1], bc, ab});
                  finer.push_back({v[2], ca, bc});
                  finer.push_back({ab, bc, ca});
                  continue;
                }
              const unsigned int ad = middle(v[0], v[3]), bd = middle(v[1], v[3]),
                                 cd = middle(v[2], v[3]);
              finer.push_back({v[0], ab, ca, ad});
              finer.push_back({v[1], ab, bc, bd});
              finer.push_back({v[2], ca, bc, cd});
              finer.push_back({v[3], ad, bd, cd});
              // The octahedron in the middle, cut along its shortest diagonal: ends, and the four
              // other nodes in a circle.
              std::array<std::array<unsigned int, 6>, 3> cuts{{{{ab, cd, bc, bd, ad, ca}},
                                                               {{bc, ad, ab, bd, cd, ca}},
                                                               {{ca, bd, ab, bc, cd, ad}}}};
              const auto shortest =
                std::min_element(cuts.begin(), cuts.end(), [&](const auto &p, const auto &q) {
                  return builder.nodes[p[0]].distance(builder.nodes[p[1]]) <
                         builder.nodes[q[0]].distance(builder.nodes[q[1]]) * (1 - 1e-10);
                });
              for (unsigned int k = 0; k < 4; ++k)
                finer.push_back({(*shortest)[0],
                                 (*shortest)[1],
                                 (*shortest)[2 + k],
                                 (*shortest)[2 + (k + 1) % 4]});
            }
          elements = std::move(finer);
        }
      for (Point<3> &x : builder.nodes)
        x = centre + radius * Tensor<1, 3>(x);
      for (const auto &element : elements)
        builder.simplex(element);
      return builder.build(solid ? 3 : 2);
    }

    // --- any dimension

    /// What a file must hold for a structure.
    void
    check_content(const GmshFile &file, const unsigned int structure_dim, const int dim)
    {
      static const char *const names[] = {"points", "segments", "triangles", "tetrahedra"};
      std::string found;
      for (unsigned int m = 3; m > 0; --m)
        if (!file.simplices[m].empty())
          found += (found.empty() ? "" : " and ") + std::to_string(file.simplices[m].size()) + " " +
                   names[m];
      if (!file.others.empty())
        found += (found.empty() ? "" : " and ") + file.others;
      bool fits = !file.simplices[structure_dim].empty() && file.others_dimension < structure_dim;
      for (unsigned int m = structure_dim + 1; m < 4; ++m)
        fits = fits && file.simplices[m].empty();
      if (!fits)
        throw Error("holds " + (found.empty() ? "no elements" : found) +
                    "; a structure of dimension " + std::to_string(structure_dim) +
                    " in dimension " + std::to_string(dim) + " needs " + names[structure_dim] +
                    ", and nothing of higher dimension or order" +
                    (file.others.empty() ? "" : " (Mesh.ElementOrder = 1, Mesh.RecombineAll = 0)"));
    }

    /// For each place, the index of the first one that is the same but for round-off.
    template <int dim>
    std::vector<unsigned int>
    places_without_repeats(const std::vector<Point<dim>> &places)
    {
      // Along a direction that no mesh is aligned with, few others are near.
      Tensor<1, dim> direction;
      for (unsigned int a = 0; a < dim; ++a)
        direction[a] = std::pow(.7548776662466927, a);
      std::vector<std::pair<double, unsigned int>> order;
      double extent = 0;
      for (unsigned int i = 0; i < places.size(); ++i)
        {
          order.emplace_back(direction * (places[i] - places[0]), i);
          extent = std::max(extent, places[i].distance(places[0]));
        }
      std::sort(order.begin(), order.end());
      const double tolerance = 1e-8 * extent;
      std::vector<unsigned int> result(places.size());
      for (unsigned int k = 0; k < order.size(); ++k)
        {
          const unsigned int i = order[k].second;
          result[i]            = i;
          for (unsigned int l = k; l-- > 0 && order[k].first - order[l].first < 2 * tolerance;)
            if (const unsigned int j = order[l].second; places[i].distance(places[j]) <= tolerance)
              {
                result[i] = result[j];
                break;
              }
        }
      std::vector<unsigned int> smallest(places.size(), places.size());
      for (unsigned int i = 0; i < places.size(); ++i)
        {
          unsigned int &index = smallest[result[i]];
          index               = std::min(index, i);
          result[i]           = index;
        }
      return result;
    }

    /// The places of the nodes that elements of the structure use. @p used: their indices in the
    /// file.
    template <int dim>
    std::vector<Point<dim>>
    used_places(const GmshFile &file,
                const unsigned int structure_dim,
                std::vector<unsigned int> &used)
    {
      std::vector<bool> is_used(file.nodes.size(), false);
      for (const GmshFile::Simplex &simplex : file.simplices[structure_dim])
        for (unsigned int k = 0; k <= structure_dim; ++k)
          is_used[simplex.nodes[k]] = true;
      std::vector<Point<dim>> places;
      double largest = 0;
      for (unsigned int i = 0; i < file.nodes.size(); ++i)
        if (is_used[i])
          {
            used.push_back(i);
            places.emplace_back();
            for (unsigned int a = 0; a < dim; ++a)
              places.back()[a] = file.nodes[i].place[a];
            largest = std::max(largest, places.back().distance(places.front()));
          }
      for (const unsigned int i : used)
        if (dim == 2 && std::abs(file.nodes[i].place[2]) > 1e-8 * largest)
          throw Error("has nodes outside the plane z = 0, where a structure in dimension 2 must "
                      "lie, as node " +
                      std::to_string(file.nodes[i].number) + " in line " +
                      std::to_string(file.nodes[i].line) +
                      " with z = " + readable(file.nodes[i].place[2]));
      return places;
    }

    /// Says what is doubtful about the mesh of a file. @p example: the numbers of two nodes at one
    /// place.
    template <int dim>
    void
    add_remarks(LagrangianMesh<dim> &mesh,
                const GmshFile::Several &several,
                const unsigned int n_unmerged,
                const std::pair<std::uint64_t, std::uint64_t> &example)
    {
      if (several.count > 0)
        mesh.add_remark(
          {"groups",
           double(several.count),
           std::to_string(several.count) +
             " of its elements are in several physical groups of the file, as element " +
             std::to_string(several.example) + " in " + std::to_string(several.kept) + " and " +
             std::to_string(several.other) + ": the first one is taken for the material"});
      if (n_unmerged == 0)
        return;
      const std::vector<unsigned int> parts = mesh.parts();
      const unsigned int n_parts            = *std::max_element(parts.begin(), parts.end()) + 1;
      mesh.add_remark({"unmerged_nodes",
                       double(n_unmerged),
                       std::to_string(n_unmerged) + " of its nodes lie where others do, as nodes " +
                         std::to_string(example.first) + " and " + std::to_string(example.second) +
                         ", and are not joined: they move apart. The mesh has " +
                         std::to_string(n_parts) + (n_parts == 1 ? " part" : " parts") +
                         "; \"merge\": true in its block makes one node of "
                         "those at one place"});
    }

    /// The data of the elements, not a number where the file does not say.
    template <int dim>
    void
    add_element_data(LagrangianMesh<dim> &mesh, const std::map<std::string, GmshFile::Data> &given)
    {
      typename LagrangianMesh<dim>::ElementData data;
      for (const auto &[name, values] : given)
        {
          bool any = false;
          std::vector<dealii::Tensor<1, 3>> of_elements;
          for (const auto &element : mesh.elements())
            {
              const auto found = values.find(element.number);
              any              = any || found != values.end();
              of_elements.emplace_back();
              for (unsigned int c = 0; c < 3; ++c)
                of_elements.back()[c] = found != values.end()
                                          ? found->second[c]
                                          : std::numeric_limits<double>::quiet_NaN();
            }
          if (any)
            data[name] = std::move(of_elements);
        }
      mesh.set_element_data(std::move(data));
    }

    template <int dim>
    LagrangianMesh<dim>
    gmsh(const std::string &path,
         const unsigned int structure_dim,
         const bool merge,
         const MPI_Comm communicator)
    {
      const GmshFile file(path, communicator);
      Builder<dim> builder(communicator);
      std::vector<std::uint64_t> numbers;
      unsigned int n_unmerged = 0;
      std::pair<std::uint64_t, std::uint64_t> example;
      try
        {
          check_content(file, structure_dim, dim);
          std::vector<unsigned int> used;
          const std::vector<Point<dim>> places  = used_places<dim>(file, structure_dim, used);
          const std::vector<unsigned int> first = places_without_repeats(places);
          std::vector<unsigned int> node_of(file.nodes.size()); // of the structure
          for (unsigned int i = 0; i < places.size(); ++i)
            {
              const std::uint64_t number = file.nodes[used[i]].number;
              if (first[i] != i && n_unmerged++ == 0)
                example = {file.nodes[used[first[i]]].number, number};
              if (merge && first[i] != i)
                node_of[used[i]] = node_of[used[first[i]]];
              else
                {
                  node_of[used[i]] = builder.node(places[i]);
                  numbers.push_back(number);
                }
            }
          for (const GmshFile::Simplex &simplex : file.simplices[structure_dim])
            {
              std::vector<unsigned int> nodes;
              for (unsigned int k = 0; k <= structure_dim; ++k)
                nodes.push_back(node_of[simplex.nodes[k]]);
              builder.simplex(nodes, simplex.material_id);
              builder.simplices.back().number = simplex.number;
            }
          LagrangianMesh<dim> mesh = builder.build(structure_dim, std::move(numbers));
          add_element_data(mesh, file.element_data);
          add_remarks(mesh, file.several[structure_dim], merge ? 0 : n_unmerged, example);
          return mesh;
        }
      catch (const Error &error)
        {
          throw Error("file \"" + readable(path) + "\": " + error.issues().front().message);
        }
    }

    // --- by name

    struct Named
    {
      const char *name;
      unsigned int structure_dim, dim;
    };
    constexpr std::array<Named, 9> meshes{{{"closed_curve", 1, 2},
                                           {"open_curve", 1, 2},
                                           {"rectangle", 2, 2},
                                           {"periodic_strip", 2, 2},
                                           {"disc", 2, 2},
                                           {"ring", 2, 2},
                                           {"sphere", 2, 3},
                                           {"ball", 3, 3},
                                           {"box", 3, 3}}};

    LagrangianMesh<2>
    named_mesh(const std::string &name, const Parameters &block, std::integral_constant<int, 2>)
    {
      return name == "closed_curve"     ? curve(block, true)
             : name == "open_curve"     ? curve(block, false)
             : name == "rectangle"      ? rectangle(block)
             : name == "periodic_strip" ? periodic_strip(block)
             : name == "ring"           ? ring(block)
                                        : disc(block);
    }

    LagrangianMesh<3>
    named_mesh(const std::string &name, const Parameters &block, std::integral_constant<int, 3>)
    {
      return name == "box" ? box(block) : icosahedral(block, name == "ball");
    }
  } // namespace

  template <int dim>
  LagrangianMesh<dim>
  make_reference_mesh(const Parameters &mesh, const unsigned int structure_dim)
  {
    const auto [name, block] = mesh.choice();
    std::string allowed;
    for (const Named &known : meshes)
      if (known.structure_dim == structure_dim && known.dim == dim)
        allowed += std::string(known.name) + ", ";
    for (const Named &known : meshes)
      if (known.name == name && (known.structure_dim != structure_dim || known.dim != dim))
        mesh.fail(name,
                  name + " is a mesh of dimension " + std::to_string(known.structure_dim) +
                    " for dimension " + std::to_string(known.dim) + "; a " +
                    (structure_dim == dim ? "thick body" : "membrane") + " in dimension " +
                    std::to_string(dim) + " needs a mesh of dimension " +
                    std::to_string(structure_dim) + ": " + allowed + "gmsh");
    if (name != "gmsh")
      return named_mesh(name, block, std::integral_constant<int, dim>());
    const std::string file = block.string("file");
    const std::string path = file.empty() || file[0] == '/' || block.directory().empty()
                               ? file
                               : block.directory() + "/" + file;
    try
      {
        return gmsh<dim>(path, structure_dim, block.boolean("merge"), block.communicator());
      }
    catch (const Error &error)
      {
        block.fail("file", error.issues().front().message);
      }
  }

  template LagrangianMesh<2> make_reference_mesh<2>(const Parameters &, unsigned int);
  template LagrangianMesh<3> make_reference_mesh<3>(const Parameters &, unsigned int);
} // namespace feib
