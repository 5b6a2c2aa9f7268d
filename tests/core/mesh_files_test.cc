// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes of other people's kinds: each is read right or refused with a sentence.
#include "elastic_structure_test.h"
#include "mesh_writers.h"

#include <set>

using namespace feib;
using namespace feib::testing;

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(StructureModelKit);

namespace
{
  const std::string body = "hyperelastic", membrane = "membrane";
  const std::string neo_hookean = R"({"neo_hookean": {"shear_modulus": 2}})";
  const std::string linear      = R"({"anisotropic_linear": {"stiffness": 2}})";

  const Encoding encodings[] = {Encoding::ascii, Encoding::native, Encoding::swapped};

  /// A file, and what should come of it.
  struct Foreign
  {
    std::string what, text;
    Mesh mesh; // what it holds
    std::vector<std::string> remarks = {};
  };

  /// The unit square, in two groups, with data.
  Mesh
  marked(Mesh mesh)
  {
    for (unsigned int e = 0; e < mesh.elements.size(); ++e)
      {
        mesh.groups.push_back({e < mesh.elements.size() / 2 ? 3 : 7});
        mesh.fibre.push_back({1. + e, .5 * e, 1e-3 * e});
      }
    mesh.names = {{3, "soft tissue"}, {7, "stiff"}};
    return mesh;
  }

  double
  measure_of(const Mesh &mesh)
  {
    double result = 0;
    for (const auto &element : mesh.elements)
      {
        dealii::Tensor<2, 3> edges;
        for (unsigned int k = 0; k < 3; ++k)
          for (unsigned int a = 0; a < 3; ++a)
            edges[k][a] =
              k < mesh.m ? mesh.nodes[element[k + 1]][a] - mesh.nodes[element[0]][a] : 0;
        result += mesh.m == 1   ? edges[0].norm()
                  : mesh.m == 2 ? cross_product_3d(edges[0], edges[1]).norm() / 2
                                : std::abs(determinant(edges)) / 6;
      }
    return result;
  }

  template <int dim>
  void
  check(const Foreign &file, const std::string &slot)
  {
    SCOPED_TRACE(file.what);
    const Mesh &given = file.mesh;
    const TemporaryFile there(file.text);
    const auto model = make_model<dim>(given.m == dim ? body : membrane,
                                       "{\"" + slot + "\": {\"file\": \"" + there.name + "\"}}",
                                       given.m == 1 ? linear : neo_hookean);
    const auto &mesh = model->mesh();
    EXPECT_NEAR(check_mesh(mesh), measure_of(given), 1e-12 * measure_of(given));
    ASSERT_EQ(mesh.n_elements(), given.elements.size());
    std::set<unsigned int> used;
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      {
        const auto &element = mesh.elements()[e];
        EXPECT_EQ(int(element.material_id), given.groups.empty() ? 0 : given.groups[e][0]);
        for (unsigned int c = 0; c < 3 && !given.fibre.empty(); ++c)
          {
            EXPECT_EQ(mesh.element_data().at("the fibre")[e][c], given.fibre[e][c]);
          }
        dealii::Point<dim> centroid;
        for (unsigned int k = 0; k <= given.m; ++k)
          {
            used.insert(given.elements[e][k]);
            for (unsigned int a = 0; a < dim; ++a)
              centroid[a] += given.nodes[given.elements[e][k]][a] / (given.m + 1);
          }
        EXPECT_LT(centroid.distance(element.centroid), 1e-14);
      }
    EXPECT_EQ(mesh.n_nodes(), used.size());
    std::vector<std::string> kinds;
    for (const auto &remark : mesh.remarks())
      kinds.push_back(remark.kind);
    EXPECT_EQ(kinds, file.remarks);
  }

  void
  check(const Foreign &file, const std::string &slot)
  {
    const bool plane = std::all_of(file.mesh.nodes.begin(), file.mesh.nodes.end(), [](auto &node) {
      return node[2] == 0;
    });
    plane ? check<2>(file, slot) : check<3>(file, slot);
  }

  /// Of every shape, with everything.
  std::vector<Mesh>
  meshes()
  {
    return {marked(square(3)), marked(cube()), marked(loop(1, 6)), marked(surface(1))};
  }

  /// Either a mesh or a sentence comes out, whatever goes in.
  void
  survives(const std::string &text, const std::string &slot)
  {
    const TemporaryFile file(text);
    try
      {
        const auto model =
          make_model<2>(body, "{\"" + slot + "\": {\"file\": \"" + file.name + "\"}}", neo_hookean);
        EXPECT_TRUE(std::isfinite(check_mesh(model->mesh())));
      }
    catch (const Error &error)
      {
        EXPECT_TRUE(contains(error.issues().front().pointer, "/mesh"));
        EXPECT_GT(error.issues().front().message.size(), 20u);
      }
  }

  /// Cut anywhere, and with bytes and numbers of eight bytes that are wrong.
  void
  survives_damage(const std::string &text, const std::string &slot)
  {
    for (std::size_t n = 0; n < text.size(); n += 3)
      survives(text.substr(0, n), slot);
    for (std::size_t n = 0; n < text.size(); n += 3)
      {
        std::string changed = text;
        changed[n]          = char(changed[n] ^ 0x55);
        survives(changed, slot);
        for (const std::uint64_t number : {std::uint64_t(1) << 60, ~std::uint64_t(0)})
          if (n % 6 == 0 && n + 8 <= text.size())
            {
              std::memcpy(changed.data() + n, &number, 8);
              survives(changed, slot);
            }
      }
  }
} // namespace

TEST(MeshFiles, GmshOfBothFormatsInAllEncodings)
{
  for (const Mesh &mesh : meshes())
    for (const Encoding encoding : encodings)
      {
        const std::string what =
          " m = " + std::to_string(mesh.m) + ", encoding " + std::to_string(int(encoding));
        check({"2.2" + what, mesh.format_2(encoding), mesh}, "gmsh");
        check({"4.1" + what, mesh.format_4(encoding), mesh}, "gmsh");
        check({"2.2, second order" + what,
               mesh.second_order().format_2(encoding),
               mesh,
               {"higher_order"}},
              "gmsh");
        check({"4.1, second order" + what,
               mesh.second_order().format_4(encoding),
               mesh,
               {"higher_order"}},
              "gmsh");
      }
}

TEST(MeshFiles, ElementsInTheOtherSenseAreTurned)
{
  for (Mesh mesh : meshes())
    {
      // All of them: a matter of taste.
      Mesh all = mesh;
      for (auto &element : all.elements)
        std::swap(element[0], element[1]);
      check({"all", all.format_4(), all}, "gmsh");
      std::swap(mesh.elements[2][0], mesh.elements[2][1]);
      check({"one", mesh.format_2(), mesh, {"orientation"}}, "gmsh");
    }
  Mesh mesh = square(2);
  std::swap(mesh.elements[5][0], mesh.elements[5][1]);
  const TemporaryFile file(mesh.format_4());
  const auto remark = make_model<2>(body, gmsh(file), neo_hookean)->mesh().remarks()[0];
  EXPECT_EQ(remark.value, 1);
  EXPECT_TRUE(contains(remark.text,
                       "lists the nodes of 1 of its 8 elements in the other sense than those of "
                       "the others, as of element 106: they are turned"));
}

// A binary file of format 4.1 may have any sections; ghosts are no elements.
TEST(MeshFiles, OtherSectionsOfBinaryFiles)
{
  const Mesh mesh = marked(square(1));
  Numbers ghosts{Encoding::native};
  ghosts.line("$GhostElements").put(std::uint64_t(1)).put(std::uint64_t(101)).put(2);
  ghosts.put(std::uint64_t(1)).put(1).line("\n$EndGhostElements");
  check({"ghosts", mesh.format_4(Encoding::native) + ghosts.text, mesh}, "gmsh");
  const std::string text = mesh.format_4(Encoding::native) + "$Strange\n\x01\x02";
  const TemporaryFile file(text);
  EXPECT_TRUE(
    contains(error_of<2>(body, gmsh(file), neo_hookean),
             "byte " + std::to_string(text.size() - 3) + ": the file ends inside $Strange"));
}

// Parts of entities, with the groups; 4.1 binary.
TEST(MeshFiles, PartitionedBinaryGmsh)
{
  using Size  = std::uint64_t;
  Mesh mesh   = square(1);
  mesh.groups = {{5}, {5}};
  for (const Encoding encoding : {Encoding::native, Encoding::swapped})
    {
      Numbers parts{encoding};
      parts.line("$PartitionedEntities").put(Size(2)).put(Size(1)).put(9).put(2);
      for (const unsigned int n : {0, 0, 1, 0})
        parts.put(Size(n));
      parts.put(1).put(2).put(1).put(Size(2)).put(1).put(2);
      for (unsigned int c = 0; c < 6; ++c)
        parts.put(double(c));
      parts.put(Size(1)).put(4).put(Size(2)).put(1).put(-2).line("\n$EndPartitionedEntities");
      Mesh expected   = mesh;
      expected.groups = {{4}, {4}};
      check({"partitioned",
             replace(mesh.format_4(encoding), "$EndEntities\n", "$EndEntities\n" + parts.text),
             expected},
            "gmsh");
    }
}

TEST(MeshFiles, DamagedBinaryGmshIsRefused)
{
  for (const Encoding encoding : {Encoding::native, Encoding::swapped})
    {
      survives_damage(marked(square(1)).format_2(encoding), "gmsh");
      survives_damage(marked(square(1)).format_4(encoding), "gmsh");
    }
  const auto refused = [](const std::string &text, const std::string &sentence) {
    const TemporaryFile file(text);
    EXPECT_TRUE(contains(error_of<2>(body, gmsh(file), neo_hookean), sentence));
  };
  Mesh mesh        = square(1);
  mesh.nodes[2][1] = std::nan("");
  refused(mesh.format_4(Encoding::native), "in $Nodes where a finite number is expected");
  refused(mesh.format_2(Encoding::swapped), "in $Nodes where a finite number is expected");
  mesh             = square(1);
  mesh.elements[1] = {0, 3, 9};
  refused(mesh.format_2(Encoding::native), "element 102 has node 100, which does not exist");
  refused(mesh.format_4(Encoding::swapped), "element 102 has node 100, which does not exist");
}
