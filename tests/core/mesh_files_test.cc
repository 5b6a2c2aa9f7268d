// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes of other people's kinds: each is read right or refused with a sentence.
#include "elastic_structure_test.h"

#include <feib/structure_force.h>

#include "vtk_writers.h"

#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_out.h>
#include <deal.II/grid/tria.h>

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
    const std::size_t step = text.size() / 80 + 1;
    for (std::size_t n = 0; n < text.size(); n += step)
      survives(text.substr(0, n), slot);
    for (std::size_t n = 0; n < text.size(); n += step)
      {
        std::string changed = text;
        changed[n]          = char(changed[n] ^ 0x55);
        survives(changed, slot);
        for (const std::uint64_t number : {std::uint64_t(1) << 60, ~std::uint64_t(0)})
          if (n % 2 == 0 && n + 8 <= text.size())
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

TEST(MeshFiles, LegacyVtk)
{
  for (const Mesh &mesh : meshes())
    for (const bool binary : {false, true})
      for (const bool version_5 : {false, true})
        {
          const std::string what = "m = " + std::to_string(mesh.m) + (binary ? ", binary" : "") +
                                   (version_5 ? ", version 5.1" : "");
          check({what, legacy_vtk(mesh, binary, version_5), mesh}, "vtk");
          check({what + ", second order",
                 legacy_vtk(mesh.second_order(), binary, version_5),
                 mesh,
                 {"higher_order"}},
                "vtk");
        }
}

TEST(MeshFiles, VtuInAllEncodings)
{
  for (const Mesh &mesh : meshes())
    for (const Vtu::Where where :
         {Vtu::ascii, Vtu::inline_base64, Vtu::appended_base64, Vtu::appended_raw})
      for (unsigned int bits = 0; bits < (where == Vtu::ascii ? 1 : 16); ++bits)
        {
          Vtu vtu{where, (bits & 1) > 0, (bits & 2) > 0, (bits & 4) > 0, (bits & 8) > 0};
          const std::string what = "m = " + std::to_string(mesh.m) + ", where " +
                                   std::to_string(where) + ", bits " + std::to_string(bits);
          check({what, vtu.text(mesh), mesh}, "vtk");
          check({what + ", second order", vtu.text(mesh.second_order()), mesh, {"higher_order"}},
                "vtk");
        }
}

// Lines of several segments, cells of lower dimension, points without a cell, several pieces,
// ghosts.
TEST(MeshFiles, WhatElseIsInFilesOfVtk)
{
  const std::string head = "# vtk DataFile Version 3.0\n\nascii\ndataset unstructured_grid\n";
  Mesh chain{1, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {{0, 1}, {1, 2}}, {{5}, {5}}};
  check({"polyline",
         head + "points 3 float\n0 0 0 1 0 0 1 1 0\ncells 1 4\n3 0 1 2\ncell_types 1\n4\n"
                "cell_data 1\nscalars gmsh:physical long\nlookup_table t\n-5\n",
         chain},
        "vtk");
  Mesh mesh = square(1);
  check({"lower dimensions",
         head +
           "POINTS 5 float 9 9 9 0 0 0 1 0 0 0 1 0 1 1 0\nCELLS 4 13 1 0 2 1 2 3 1 2 4 3 1 4 3\n"
           "CELL_TYPES 4\n1 3 5 5\nPOINT_DATA 5\nCOLOR_SCALARS c 1\n1 1 1 1 1\n"
           "VECTORS v double\n1 2 3 4 5 6 7 8 9 1 2 3 4 5 nan\n",
         mesh},
        "vtk");
  const std::string text  = Vtu().text(marked(square(1)));
  const std::size_t begin = text.find("<Piece"), end = text.find("</UnstructuredGrid>");
  const std::string piece = text.substr(begin, end - begin);
  const auto with         = [&](const std::string &second) {
    return text.substr(0, end) + second + text.substr(end);
  };
  std::string ghosts = replace(
    piece,
    "</CellData>",
    "<DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">1 1</DataArray></CellData>");
  check({"ghosts", with(ghosts), marked(square(1))}, "vtk");
  // The same once more, two away.
  const Mesh two     = marked(square(1)) + marked(square(1)).shifted({2, 0, 0});
  std::string second = Vtu().text(marked(square(1)).shifted({2, 0, 0}));
  second             = second.substr(begin, second.find("</UnstructuredGrid>") - begin);
  Mesh expected      = two;
  expected.fibre.clear();
  check({"two pieces", with(second), expected}, "vtk");
}

TEST(MeshFiles, WhatIsWrongWithAFileOfVtk)
{
  const auto refused = [](const std::string &text, const std::string &sentence) {
    const TemporaryFile file(text);
    const std::string message =
      error_of<2>(body, R"({"vtk": {"file": ")" + file.name + R"("}})", neo_hookean);
    EXPECT_TRUE(contains(message, sentence));
    EXPECT_TRUE(contains(message, "/mesh/vtk/file: file \"" + file.name + "\""));
  };
  const Mesh mesh          = marked(square(1));
  const std::string legacy = legacy_vtk(mesh, false), vtu = Vtu().text(mesh);
  Vtu encoded{Vtu::inline_base64, true};
  const std::string packed = encoded.text(mesh);
  refused("", "line 1: the file is empty; Feib reads VTK's legacy format");
  refused("solid\n", "line 1: found \"solid\"; Feib reads VTK's legacy format");
  refused(replace(legacy, "ASCII", "HEX"), "line 3: found \"HEX\" where ASCII or BINARY");
  refused(replace(legacy, "UNSTRUCTURED_GRID", "POLYDATA"),
          "found \"DATASET POLYDATA\"; Feib reads");
  refused(replace(legacy, "POINTS 4 double", "POINTS 4 string"), "numbers of the type \"string\"");
  refused(replace(legacy, "POINTS 4 double", "POINTS 1152921504606846976 double"),
          "found \"CELLS\" in POINTS where a number is expected");
  refused(replace(legacy_vtk(mesh, true), "POINTS 4 d", "POINTS 1152921504606846976 d"),
          "the file ends inside POINTS");
  refused(replace(legacy_vtk(mesh, true), "POINTS 4 d", "POINTS 6148914691236517206 d"),
          "the file ends inside POINTS");
  refused(replace(legacy, "CELLS 2 8", "CELLS 3 8"), "fewer numbers than its 3 cells say");
  refused(replace(legacy, "CELLS 2 8", "CELLS 1 8"), "more numbers than its 1 cells say");
  refused(replace(legacy, "3 0 1 3", "3 0 1 4"), "cell 0 has the point 4; there are 4, 0 to 3");
  refused(replace(legacy, "3 0 1 3", "3 0 1 -1"), "cell 0 has the point -1; there are 4, 0 to 3");
  refused(replace(legacy, "3 0 1 3", "3 0 1.5 3"), "cell 0 has the point 1.5; there are 4");
  refused(replace(legacy, "1 0 0\n", "1 nan 0\n"), "point 1 has the coordinate nan");
  refused(replace(legacy, "CELL_DATA 2", "CELL_DATA 1"), "found \"7\" where a part of an unstr");
  refused(replace(legacy, "\n5 5\n", "\n9 9\n"), "has 3 points, 4 are needed");
  refused(replace(legacy, "\n5 5\n", "\n7 7\n"), "holds polygons; a structure of dimension 2");
  refused(replace(legacy, "\n5 5\n", "\n42 42\n"), "holds cells of VTK's type 42; a structure");
  refused(replace(legacy, "\n3 7\n", "\n3 -7\n"),
          "element 1 has the material -7; ids are 0, 1, 2, ...");

  refused(replace(vtu, "\"UnstructuredGrid", "\"PolyData"), "of the type \"PolyData\"; Feib reads");
  refused(replace(vtu, "<VTKFile type", "<svg type"), "line 3: found <svg>");
  refused(replace(packed, "ZLib", "LZ4"), "compressed by \"vtkLZ4DataCompressor\"; Feib reads");
  refused(replace(vtu, "NumberOfPoints=\"4", "NumberOfPoints=\"5"),
          "line 5: this piece says that it has 5 points, its arrays have 4");
  refused(replace(vtu, "NumberOfCells=\"2", "NumberOfCells=\"1152921504606846976"),
          "says that it has 1152921504606846976 cells, its arrays have 2");
  refused(replace(vtu, "Float64", "String"), "an array of the type \"String\"; it is Int8");
  refused(replace(vtu, "connectivity", "connection"), "cell 0 ends in the list of points at 3");
  refused(replace(packed, "format=\"binary", "format=\"zip"), "it is ascii, binary or appended");
  refused(replace(packed, "format=\"binary", "format=\"appended"), "has no <AppendedData>");
  refused(vtu.substr(0, vtu.size() - 12), "the file ends without </VTKFile>");
  // A block that would be a billion billion bytes.
  Numbers bomb{Encoding::native};
  bomb.put(std::uint32_t(1)).put(~std::uint32_t(0)).put(~std::uint32_t(0)).put(std::uint32_t(8));
  const std::size_t at = packed.find("binary\">\n", packed.find("Name=\"Points\"")) + 9;
  refused(packed.substr(0, at) + in_base64(bomb.text) + in_base64("12345678") +
            packed.substr(packed.find('\n', at)),
          "the array \"Points\" has a compressed block that is too short for its size");
}

TEST(MeshFiles, DamagedFilesOfVtkAreRefused)
{
  const Mesh mesh = marked(square(1));
  for (const bool version_5 : {false, true})
    survives_damage(legacy_vtk(mesh, true, version_5), "vtk");
  for (const Vtu::Where where : {Vtu::inline_base64, Vtu::appended_raw})
    {
      Vtu vtu{where, where == Vtu::inline_base64};
      survives_damage(vtu.text(mesh), "vtk");
    }
}

namespace
{
  /// The unit square or cube of simplices as deal.II writes it, in two materials.
  template <int dim>
  void
  check_what_deal_ii_writes()
  {
    dealii::Triangulation<dim> triangulation;
    dealii::GridGenerator::subdivided_hyper_cube_with_simplices(triangulation, 2);
    unsigned int n_marked = 0;
    for (const auto &cell : triangulation.active_cell_iterators())
      if (cell->center()[0] > .5)
        {
          cell->set_material_id(3);
          ++n_marked;
        }
    std::ostringstream vtk, vtu;
    const dealii::GridOut out;
    out.write_vtk(triangulation, vtk);
    out.write_vtu(triangulation, vtu);
    std::vector<std::string> texts{vtk.str(), vtu.str()};
#ifdef DEAL_II_GMSH_WITH_API
    const TemporaryFile msh("");
    out.write_msh(triangulation, msh.name);
    std::ostringstream content;
    content << std::ifstream(msh.name).rdbuf();
    texts.push_back(content.str());
#endif
    for (const std::string &text : texts)
      {
        SCOPED_TRACE(text.substr(0, 300));
        const std::string slot = text[0] == '$' ? "gmsh" : "vtk";
        const TemporaryFile file(text);
        const auto model =
          make_model<dim>(body,
                          "{\"" + slot + R"(": {"file": ")" + file.name + R"(", "merge": true}})",
                          neo_hookean);
        EXPECT_NEAR(check_mesh(model->mesh()), 1, 1e-5); // of numbers in single precision
        EXPECT_EQ(model->mesh().n_elements(), triangulation.n_active_cells());
        EXPECT_EQ(model->mesh().n_nodes(), triangulation.n_used_vertices());
        unsigned int n = 0, id = 3;
        for (const auto &[name, group] : model->mesh().material_names())
          if (contains(name, "MaterialID:3"))
            id = group;
        for (const auto &element : model->mesh().elements())
          n += element.material_id == id;
        // The vtu file holds no integers.
        EXPECT_EQ(n, text == vtu.str() ? 0 : n_marked);
      }
  }
} // namespace

// Files of another hand than that which wrote the readers.
TEST(MeshFiles, WhatDealIIWrites)
{
  check_what_deal_ii_writes<2>();
  check_what_deal_ii_writes<3>();
}

// A force on the elements of a group, by its name.
TEST(MeshFiles, ForcesActOnNamedGroups)
{
  const TemporaryFile file(marked(square(2)).format_4());
  const auto model = make_model<2>(body, gmsh(file), neo_hookean);
  const auto total = [&](const std::string &material) {
    const auto force = registry().create<StructureForce<2>>(
      "traction", R"({"force": [2, -1], "on": {"materials": [)" + material + "]}}");
    const Domain<2> box(dealii::Point<2>(), dealii::Point<2>(1, 1), {{4, 4}});
    force->attach({model->mesh(), model->positions, {}, {0.}, box});
    NodalField<2> result(model->mesh());
    force->load(model->positions, result);
    return result.sum([&](const unsigned int i) { return result[i]; });
  };
  for (const char *const material : {"3", "\"soft tissue\""})
    EXPECT_LT((total(material) - dealii::Tensor<1, 2>({1, -.5})).norm(), 1e-14) << material;
  try
    {
      total(R"(3, "soft")");
      ADD_FAILURE();
    }
  catch (const Error &error)
    {
      EXPECT_TRUE(contains(error.what(),
                           R"(/on/materials/1: found "soft"; the materials of the mesh have the )"
                           R"(names "soft tissue", "stiff")"))
        << error.what();
    }
}

// The groups' names stand for their numbers in the case.
TEST(MeshFiles, MaterialsHaveTheNamesOfGroups)
{
  const auto by_material = [](const std::string &materials) {
    return R"({"by_material": {"laws": [{"materials": [)" + materials +
           R"(], "law": {"neo_hookean": {"shear_modulus": 2}}},
               {"materials": [7], "law": {"neo_hookean": {"shear_modulus": 20}}}]}})";
  };
  const Mesh mesh = marked(square(2));
  for (const Encoding encoding : encodings)
    for (const std::string &text : {mesh.format_2(encoding), mesh.format_4(encoding)})
      {
        const TemporaryFile file(text);
        const std::string slot = gmsh(file);
        const auto named       = make_model<2>(body, slot, by_material(R"("soft tissue")"));
        const auto numbered    = make_model<2>(body, slot, by_material("3"));
        EXPECT_EQ(named->mesh().material_names(),
                  (std::map<std::string, unsigned int>{{"soft tissue", 3}, {"stiff", 7}}));
        const Positions<2> X = shaken(*named);
        EXPECT_GT(named->energy(X), 0);
        EXPECT_EQ(named->energy(X), numbered->energy(X));
        EXPECT_TRUE(contains(error_of<2>(body, slot, by_material(R"("soft")")),
                             "has no law for the material 3 (\"soft tissue\") of the mesh; there "
                             "are laws for soft, 7"));
        // Where the case says what the materials are, the names are void.
        EXPECT_TRUE(
          contains(error_of<2>(body, slot, by_material(R"("soft tissue")"), R"("material": 3)"),
                   "has no law for the material 3 of the mesh"));
      }
}
