// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes from files: what is read, what is refused, what is doubtful.
#include "elastic_structure_test.h"
#include "mesh_writers.h"

#include <filesystem>

#include <sys/stat.h>

using namespace feib;
using namespace feib::testing;

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(StructureModelKit);

namespace
{
  const std::string body = "hyperelastic", membrane = "membrane";
  const std::string neo_hookean = R"({"neo_hookean": {"shear_modulus": 2}})";
  const std::string stress_free = R"({"neo_hookean": {"shear_modulus": 2, "stress_free": true}})";
  const std::string linear      = R"({"anisotropic_linear": {"stiffness": 2}})";

  template <int dim>
  std::unique_ptr<StructureModel<dim>>
  model_of(const std::string &component,
           const std::string &text,
           const std::string &more    = "",
           const std::string &options = "")
  {
    const TemporaryFile file(text);
    return make_model<dim>(component,
                           R"({"gmsh": {"file": ")" + file.name + "\"" + options + "}}",
                           component == membrane && dim == 2 ? linear : neo_hookean,
                           more);
  }

  template <int dim>
  std::string
  trouble(const std::string &component,
          const std::string &text,
          const std::string &more    = "",
          const std::string &options = "")
  {
    const TemporaryFile file(text);
    return error_of<dim>(component,
                         R"({"gmsh": {"file": ")" + file.name + "\"" + options + "}}",
                         component == membrane && dim == 2 ? linear : neo_hookean,
                         more);
  }

  const std::string merge = R"(, "merge": true)";

  /// The kinds of a mesh's remarks.
  template <int dim>
  std::vector<std::string>
  remarks(const StructureModel<dim> &model)
  {
    std::vector<std::string> kinds;
    for (const auto &remark : model.mesh().remarks())
      kinds.push_back(remark.kind);
    return kinds;
  }

  template <int dim>
  unsigned int
  n_parts(const StructureModel<dim> &model)
  {
    const std::vector<unsigned int> parts = model.mesh().parts();
    return *std::max_element(parts.begin(), parts.end()) + 1;
  }

  using Kinds = std::vector<std::string>;
} // namespace

// --- what is read

TEST(Gmsh, BothFormats)
{
  for (const std::string &text : square(3).texts())
    {
      const auto model = model_of<2>(body, text);
      EXPECT_NEAR(check_mesh(model->mesh()), 1, 1e-14);
      EXPECT_EQ(n_parts(*model), 1u);
      EXPECT_EQ(remarks(*model), Kinds());
      EXPECT_EQ(model->mesh().elements()[17].number, 118u);
      EXPECT_EQ(model->mesh().node_number(15), 160u);
    }
  for (const std::string &text : cube().texts())
    EXPECT_NEAR(check_mesh(model_of<3>(body, text)->mesh()), 1, 1e-14);
  for (const std::string &text : surface(1).texts())
    EXPECT_TRUE(model_of<3>(membrane, text)->mesh().closed());
  for (const std::string &text : loop(1, 5).texts())
    EXPECT_TRUE(model_of<2>(membrane, text)->mesh().closed());
}

// What this structure does not use: other nodes, points, elements of lower dimension, sections.
TEST(Gmsh, TheRestOfAFileDoesNotMatter)
{
  std::string text = square(1).format_2();
  text =
    replace(text, "$Nodes\n4\n", "$Comments\n$ 1 2 $Nodes\n$EndComments\n$Nodes\n5\n7 5 5 5\n");
  text = replace(text, "$Elements\n2\n", "$Elements\n4\n1 15 2 3 1 10\n2 1 2 4 1 10 20\n");
  const auto model = model_of<2>(body, text);
  EXPECT_NEAR(check_mesh(model->mesh()), 1, 1e-14);
  EXPECT_EQ(model->mesh().n_nodes(), 4u);
  // Lines that end as in Windows, and no empty line at the end.
  std::string windows;
  for (const char c : square(1).format_4())
    windows += c == '\n' ? "\r\n" : std::string(1, c);
  windows.resize(windows.size() - 2);
  EXPECT_NEAR(check_mesh(model_of<2>(body, windows)->mesh()), 1, 1e-14);
}

/// A plane within round-off of z = 0, in any units.
TEST(Gmsh, ThePlaneZIsZero)
{
  for (const double unit : {1e-9, 1., 1e9})
    {
      Mesh mesh = square(2);
      for (auto &node : mesh.nodes)
        node = {unit * node[0], unit * node[1], 2e-9 * unit};
      EXPECT_EQ(trouble<2>(body, mesh.format_2()), "");
      mesh.nodes[5][2] = .01 * unit;
      EXPECT_TRUE(
        contains(trouble<2>(body, mesh.format_4()),
                 "as node 60 in line 25 with z = " + std::string(unit == 1 ? "0.01" : "")));
    }
}

// --- groups

TEST(Gmsh, AnElementInTwoGroupsIsOfTheFirst)
{
  Mesh mesh       = square(2);
  mesh            = mesh.in_groups({11, 13});
  mesh.groups[3]  = {12};
  mesh.groups[5]  = {12, 11, 13};
  const Mesh full = cube().in_groups({3, 4});
  for (const bool format_2 : {true, false})
    {
      const auto model = model_of<2>(body, format_2 ? mesh.format_2() : mesh.format_4());
      EXPECT_NEAR(check_mesh(model->mesh()), 1, 1e-14);
      std::map<unsigned int, unsigned int> count;
      for (const auto &element : model->mesh().elements())
        ++count[element.material_id];
      EXPECT_EQ(count, (std::map<unsigned int, unsigned int>{{11, 6}, {12, 2}}));
      ASSERT_EQ(remarks(*model), Kinds{"groups"});
      EXPECT_EQ(model->mesh().remarks()[0].value, 7);
      EXPECT_TRUE(contains(model->mesh().remarks()[0].text, "as element 101 in 11 and 13"));
      // Where the case says what the materials are, groups say nothing.
      EXPECT_EQ(remarks(*model_of<2>(body,
                                     format_2 ? mesh.format_2() : mesh.format_4(),
                                     R"("material": "s1 > 0.5 ? 1 : 0")")),
                Kinds());

      const auto solid = model_of<3>(body, format_2 ? full.format_2() : full.format_4());
      EXPECT_EQ(remarks(*solid), Kinds{"groups"});
      EXPECT_EQ(solid->mesh().elements()[5].material_id, 3u);
      const Mesh curve = loop(1, 6).in_groups({1, 2});
      EXPECT_EQ(remarks(*model_of<2>(membrane, format_2 ? curve.format_2() : curve.format_4())),
                Kinds{"groups"});
      // Groups of elements that the structure is not made of do not matter.
      EXPECT_EQ(remarks(*model_of<2>(body, square(2).in_groups({4}).format_4())), Kinds());
    }
}

TEST(Gmsh, ARepeatedElementIsRefused)
{
  const auto repeated = [](Mesh mesh) {
    mesh.elements.push_back(mesh.elements[0]);
    if (!mesh.groups.empty())
      mesh.groups.push_back(mesh.groups[0]);
    std::swap(mesh.elements.back()[0], mesh.elements.back()[1]);
    return mesh;
  };
  for (const Mesh &mesh : {repeated(square(2)), repeated(square(2).in_groups({4}))})
    EXPECT_TRUE(contains(trouble<2>(body, mesh.format_2()), "/mesh/gmsh/file: file \"") &&
                contains(trouble<2>(body, mesh.format_2()), "element 109 repeats element 101"));
  EXPECT_TRUE(contains(trouble<2>(body, repeated(square(2)).format_4()), "repeats element 101"));
  EXPECT_TRUE(contains(trouble<3>(body, repeated(cube()).format_4()), "repeats element 101"));
  EXPECT_TRUE(contains(trouble<2>(membrane, repeated(loop(1, 4)).format_2()),
                       "element 105 repeats element 101"));
  EXPECT_TRUE(contains(trouble<3>(membrane, repeated(surface(1)).format_4()), "repeats element"));
  // The same triangle of two surfaces is no triangle in two groups.
  std::string text = square(1).in_groups({1, 2}).format_2();
  EXPECT_TRUE(contains(trouble<2>(body, replace(text, "102 2 2 2 1", "102 2 2 2 7")),
                       "element 102 repeats element 101"));
}

// The elements of a partitioned file belong to parts of entities, which have the groups.
TEST(Gmsh, PartitionedFilesKeepTheirGroups)
{
  Mesh mesh = square(2).in_groups({11});
  for (unsigned int e = 4; e < 8; ++e)
    mesh.groups[e] = {12};
  const auto whole = model_of<2>(body, mesh.format_4());
  ASSERT_EQ(whole->mesh().interfaces().size(), 2u);
  // Entities 1 and 2 are cut into 3 and 4; some tell of ghosts.
  std::string text = replace(mesh.format_4(),
                             "$EndEntities\n",
                             "$EndEntities\n$PartitionedEntities\n2\n2\n5 1\n6 2\n1 0 2 0\n"
                             "1 0 1 1 1 0 0 0 0\n"
                             "3 2 1 1 1 0 0 0 1 1 1 1 11 0\n4 2 2 2 1 2 0 0 0 1 1 1 1 12 1 7\n"
                             "$EndPartitionedEntities\n");
  text = replace(replace(text, "\n2 1 2 4\n", "\n2 3 2 4\n"), "\n2 2 2 4\n", "\n2 4 2 4\n");
  const auto parts = model_of<2>(body, text);
  EXPECT_EQ(parts->mesh().interfaces(), whole->mesh().interfaces());
  EXPECT_EQ(parts->mesh().elements()[7].material_id, 12u);
  EXPECT_EQ(remarks(*parts), Kinds());
  // Bodies in space, curves and surfaces.
  const auto cut = [](Mesh mesh) {
    mesh = mesh.in_groups({11});
    for (unsigned int e = mesh.elements.size() / 2; e < mesh.elements.size(); ++e)
      mesh.groups[e] = {12};
    std::string file = mesh.format_4(), entities = "$PartitionedEntities\n2\n0\n";
    for (unsigned int d = 0; d < 4; ++d)
      entities += std::string(d == mesh.m ? "2" : "0") + (d < 3 ? " " : "\n");
    for (const std::string n : {"1", "2"})
      {
        const std::string m = std::to_string(mesh.m);
        entities += "3" + n + " " + m + " " + n + " 1 " + n + " 0 0 0 1 1 1 1 1" + n + " 0\n";
        file = replace(file,
                       "\n" + m + " " + n + " " + std::to_string(mesh.gmsh_type()) + " ",
                       "\n" + m + " 3" + n + " " + std::to_string(mesh.gmsh_type()) + " ");
      }
    return replace(file,
                   "$EndEntities\n",
                   "$EndEntities\n" + entities + "$EndPartitionedEntities\n");
  };
  EXPECT_EQ(model_of<3>(body, cut(cube()))->mesh().elements()[2].material_id, 11u);
  EXPECT_EQ(model_of<3>(body, cut(cube()))->mesh().elements()[3].material_id, 12u);
  EXPECT_EQ(model_of<2>(membrane, cut(loop(1, 6)))->mesh().elements()[5].material_id, 12u);
  EXPECT_EQ(model_of<3>(membrane, cut(surface(1)))->mesh().elements()[1].material_id, 11u);
  EXPECT_EQ(model_of<3>(membrane, cut(surface(1)))->mesh().elements()[2].material_id, 12u);
  // Format 2.2: more tags.
  text = square(1).in_groups({5}).format_2();
  text =
    replace(replace(text, "101 2 2 5 1", "101 2 4 5 1 1 1"), "102 2 2 5 1", "102 2 5 5 1 2 2 -1");
  EXPECT_EQ(model_of<2>(body, text)->mesh().elements()[1].material_id, 5u);
}

// --- files that contradict themselves

TEST(Gmsh, CountsAreChecked)
{
  const std::string two = square(1).format_2(), four = square(1).format_4();
  for (const char *const count :
       {"1", "3", "99999999999999999999", "99999999999", "-1", "2.5", "x"})
    {
      EXPECT_TRUE(
        contains(trouble<2>(body, replace(two, "$Elements\n2", "$Elements\n" + std::string(count))),
                 "$Elements"))
        << count;
      EXPECT_TRUE(
        contains(trouble<2>(body, replace(two, "$Nodes\n4", "$Nodes\n" + std::string(count))),
                 "$Nodes"))
        << count;
      EXPECT_TRUE(
        contains(trouble<2>(body, replace(four, "2 1 2 2\n", "2 1 2 " + std::string(count) + "\n")),
                 "$Elements"))
        << count;
      EXPECT_TRUE(
        contains(trouble<2>(body, replace(four, "2 1 0 4\n", "2 1 0 " + std::string(count) + "\n")),
                 "$Nodes"))
        << count;
    }
  EXPECT_TRUE(contains(trouble<2>(body, replace(four, "1 4 10 40", "1 5 10 40")),
                       "$Nodes says that it holds 5, its blocks hold 4"));
  EXPECT_TRUE(contains(trouble<2>(body, replace(four, "1 2 101 102", "1 1 101 102")),
                       "$Elements says that it holds 1, its blocks hold 2"));
  EXPECT_TRUE(
    contains(trouble<2>(body, replace(four, "0 0 1 0\n", "0 0 99999999999 0\n")), "$Entities"));
}

TEST(Gmsh, WhatStandsTwiceOrNowhere)
{
  const std::string two = square(1).format_2(), four = square(1).format_4();
  EXPECT_TRUE(contains(trouble<2>(body, replace(two, "\n20 ", "\n10 ")),
                       "line 7: node 10 stands here a second time, at another place"));
  // At the same place it may.
  EXPECT_EQ(trouble<2>(body,
                       replace(two, "$Nodes\n4\n10 0 0 0\n", "$Nodes\n5\n10 0 0 0\n10 0 0 0\n")),
            "");
  EXPECT_TRUE(
    contains(trouble<2>(body, replace(four, "\n20\n", "\n10\n")), "node 10 stands here a second"));
  EXPECT_TRUE(contains(trouble<2>(body, replace(two, "\n102 ", "\n101 ")),
                       "line 14: element 101 stands here a second time"));
  EXPECT_TRUE(contains(trouble<2>(body, replace(four, "\n102 ", "\n101 ")),
                       "element 101 stands here a second"));
  for (const std::string &text : {two, four})
    EXPECT_TRUE(contains(trouble<2>(body, replace(text, " 40 30\n", " 40 50\n")),
                         "element 102 has node 50, which does not exist"));
  EXPECT_TRUE(
    contains(trouble<2>(body, replace(four, "\n2 1 2 2\n", "\n2 7 2 2\n")),
             "triangles belong to the entity 7 of dimension 2, which $Entities does not list"));
  EXPECT_TRUE(contains(trouble<2>(body, replace(four, "\n2 1 2 2\n", "\n1 1 2 2\n")),
                       "triangles belong to an entity of dimension 2, found one of dimension 1"));
  EXPECT_TRUE(contains(trouble<2>(body, replace(two, "101 2 2 0 1 10 20 40", "101 2 2 0 1 10 20")),
                       "line 13: element 101 of the triangles needs 3 nodes, found 2"));
  EXPECT_TRUE(
    contains(trouble<2>(body, replace(two, "101 2 2 0 1 10 20 40", "101 2 2 0 1 10 20 40 30")),
             "line 13: element 101 of the triangles needs 3 nodes, found more: \" 30\""));
  EXPECT_TRUE(
    contains(trouble<2>(body, replace(two, "101 2 2 0 1 10 20 40", "101 2 2 0 1 10 20 10")),
             "element 101 is degenerate: it has node 10 at (0, 0) twice"));
  EXPECT_TRUE(contains(trouble<2>(body, replace(two, "20 1 0 0", "20 0.5 0.5 0")),
                       "element 101 at (0.5, 0.5) is degenerate: its corners lie on one line"));
}

TEST(Gmsh, PlacesAreFinite)
{
  for (const std::string &text : square(1).texts())
    for (const std::string number : {"nan", "inf", "-infinity", "1e400", "1,5", "x"})
      EXPECT_TRUE(contains(trouble<2>(body, replace(text, "1 1 0\n", "1 " + number + " 0\n")),
                           "found \"" + number + "\" in $Nodes where a finite number is expected"));
}

namespace
{
  /// Either a mesh or a sentence comes out, whatever goes in.
  void
  survives(const std::string &text)
  {
    const TemporaryFile file(text);
    try
      {
        const auto model = make_model<2>(body, gmsh(file), neo_hookean);
        EXPECT_TRUE(std::isfinite(check_mesh(model->mesh()))) << text;
      }
    catch (const Error &error)
      {
        EXPECT_TRUE(contains(error.issues().front().pointer, "/mesh")) << text;
        EXPECT_GT(error.issues().front().message.size(), 20u) << text;
      }
  }
} // namespace

TEST(Gmsh, FilesCutAnywhereAreRefused)
{
  for (const std::string &text : square(1).in_groups({1, 2}).texts())
    for (std::size_t n = 0; n + 1 < text.size(); ++n)
      EXPECT_NE(trouble<2>(body, text.substr(0, n)), "") << text.substr(0, n);
}

TEST(Gmsh, AnyWordMayBeWrong)
{
  for (const std::string &text : square(1).in_groups({1, 2}).texts())
    for (std::size_t n = 0; n < text.size(); ++n)
      if ((n == 0 || std::isspace(text[n - 1])) && !std::isspace(text[n]))
        for (const char *const word :
             {"nan", "-1", "0", "7", "1e300", "18446744073709551615", "$End"})
          survives(text.substr(0, n) + word + text.substr(text.find_first_of(" \n", n)));
}

TEST(Gmsh, OtherKindsOfFiles)
{
  const std::string two = square(1).format_2(), four = square(1).format_4();
  const auto refused = [](const std::string &text, const std::string &sentence) {
    const std::string message = trouble<2>(body, text);
    EXPECT_TRUE(contains(message, sentence));
    EXPECT_TRUE(contains(message, "/mesh/gmsh/file: file \""));
  };
  const std::string allowed = "; Feib reads files of the formats 2.2 and 4.1, ASCII and binary";
  refused(replace(four, "4.1 0 8", "4 0 8"), "line 2: the file is of format 4" + allowed);
  refused(replace(four, "4.1 0 8", "4 1 8"), "the file is of format 4, binary" + allowed);
  refused(replace(two, "2.2 0 8", "2.2 1 8"), "its first number should be 1, of either endianness");
  refused(replace(two, "2.2 0 8", "2.2 1 4"), "numbers of the binary file have 4 bytes");
  refused("", "line 1: the file is empty" + allowed);
  refused(" \n\n", "the file is empty" + allowed);
  refused("solid ball\n", "line 1: found \"solid\" where a section ($...) is expected" + allowed);
  refused("\x1f\x8b\x08 gz", "found \"\\u001f\\x8b\\u0008\" where a section");
  refused("$NOD\n1\n1 0 0 0\n$ENDNOD\n", "found \"$NOD\" where $MeshFormat is expected" + allowed);
  refused("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n",
          "holds no elements; a structure of dimension 2");

  // Quadrilaterals, second order, another dimension.
  refused(replace(two, "101 2 2 0 1 10 20 40", "101 3 2 0 1 10 20 40 30"),
          "holds 1 triangles and quadrilaterals; a structure of dimension 2 in dimension 2 needs "
          "triangles, and nothing of higher dimension or another shape (in Gmsh, "
          "Mesh.RecombineAll = 0)");
  refused(replace(four, "2 1 2 2\n", "2 1 9 2\n"),
          "element 101 of the triangles of second order needs 6 nodes, found 3");
  refused(replace(four, "2 1 2 2\n", "2 1 99 2\n"), "holds elements of Gmsh type 99; a structure");
  refused(cube().format_4(), "holds 6 tetrahedra; a structure of dimension 2 in dimension 2 needs");
  EXPECT_TRUE(contains(trouble<3>(body, two), "holds 2 triangles; a structure of dimension 3"));
  EXPECT_TRUE(contains(trouble<2>(membrane, two), "holds 2 triangles; a structure of dimension 1"));
}

TEST(Gmsh, WhatIsNoFile)
{
  const auto message = [](const std::string &name) {
    return error_of<2>(body, R"({"gmsh": {"file": ")" + name + R"("}})", neo_hookean);
  };
  EXPECT_TRUE(contains(message("/nowhere/a.msh"),
                       "/mesh/gmsh/file: file \"/nowhere/a.msh\": there is no such file"));
  EXPECT_TRUE(contains(message("/tmp"), "file \"/tmp\": is a folder"));
  EXPECT_TRUE(contains(message("/dev/null"), "file \"/dev/null\": is a fifo or a device"));
  const TemporaryFile file("");
  std::remove(file.name.c_str());
  ASSERT_EQ(mkfifo(file.name.c_str(), 0600), 0); // nobody will ever write into it
  EXPECT_TRUE(contains(message(file.name), "is a fifo or a device, not a file"));
}

// What one rank sees of files the others need not see; all hear the same.
TEST(Gmsh, RankZeroReadsForAll)
{
  const bool first = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
  const TemporaryFile file(square(2).format_2());
  const auto mesh = [&](const bool there) {
    return R"({"gmsh": {"file": ")" + (there ? file.name : "/nowhere/a.msh") + R"("}})";
  };
  EXPECT_EQ(error_of<2>(body, mesh(first), neo_hookean), "");
  EXPECT_TRUE(contains(error_of<2>(body, mesh(!first), neo_hookean), ": there is no such file"));
}

TEST(Gmsh, RanksMayReadForThemselves)
{
  const unsigned int n = 2 + dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  const TemporaryFile file(square(n).format_2());
  const auto model =
    registry().create<StructureModel<2>>(body,
                                         R"({"name": "body", "mesh": )" + gmsh(file) +
                                           R"(, "law": )" + neo_hookean + "}",
                                         MPI_COMM_SELF);
  EXPECT_EQ(model->mesh().n_elements(), 2 * n * n);
}

// --- elements that overlap

TEST(Gmsh, TwoElementsOnOneSideOfAFaceAreRefused)
{
  Mesh triangles{2, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 3.5, 0}}, {{0, 1, 2}, {0, 1, 3}}, {}};
  Mesh tetrahedra{3,
                  {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}, {1, 1, 5}},
                  {{0, 1, 2, 3}, {2, 1, 0, 4}},
                  {}};
  const std::string sentence = "elements 101 and 102 at (";
  for (const std::string &text : triangles.texts())
    EXPECT_TRUE(contains(trouble<2>(body, text), sentence));
  for (const std::string &text : tetrahedra.texts())
    EXPECT_TRUE(contains(trouble<3>(body, text), sentence));
  // On the other side they are neighbours.
  triangles.nodes[3]  = {1, -1, 0};
  tetrahedra.nodes[4] = {1, 1, -1};
  EXPECT_EQ(trouble<2>(body, triangles.format_2()), "");
  EXPECT_EQ(trouble<3>(body, tetrahedra.format_2()), "");
}

TEST(Gmsh, PartsThatOverlapAreRefused)
{
  for (const Mesh &mesh : {square(4) + square(4).shifted({.3, .2, 0}), square(2) + square(2)})
    for (const std::string &text : mesh.texts())
      EXPECT_TRUE(contains(trouble<2>(body, text), "/mesh: lets elements 1"));
  EXPECT_TRUE(
    contains(trouble<3>(body, (cube() + cube().shifted({.1, 0, .2})).format_4()), " overlap at ("));
  // What fills a place twice is judged where it starts.
  const std::string apart = (square(2) + square(2).shifted({2, 0, 0})).format_4();
  EXPECT_EQ(trouble<2>(body, apart), "");
  EXPECT_TRUE(
    contains(trouble<2>(body, apart, R"("initial_position": ["s1 > 1.5 ? s1 - 1.9 : s1", "s2"])"),
             "/initial_position: lets elements"));
  // Side by side with other nodes, faces overlap by less than elements.
  EXPECT_EQ(trouble<2>(body, (square(3) + square(4).shifted({.999, .1, 0})).format_2()), "");
}

// A body folded by its map, with a law that needs no positive determinant.
TEST(Gmsh, FoldedBodiesAreRefused)
{
  const std::string fold = R"j("initial_position": ["0.5 + abs(s1 - 0.5)", "s2"])j";
  for (const std::string &text : square(4).texts())
    EXPECT_TRUE(contains(trouble<2>(body, text, fold),
                         "/initial_position: folds the body: 16 of its 32 elements are turned over "
                         "against the others, as element 1"));
  // The fold goes through elements.
  EXPECT_TRUE(contains(trouble<2>(body, square(3).format_2(), fold), "/initial_position: f"));
  EXPECT_TRUE(contains(error_of<2>(body, R"({"rectangle": {"cells": [6, 2]}})", neo_hookean, fold),
                       "/initial_position: folds the body: 12 of its 24"));
  EXPECT_TRUE(contains(error_of<3>(body,
                                   R"({"box": {"cells": [2, 1, 1]}})",
                                   neo_hookean,
                                   R"j("initial_position": ["0.5 + abs(s1 - 0.5)", "s2", "s3"])j"),
                       "/initial_position: folds the body: 6 of its 12"));
  EXPECT_TRUE(
    contains(trouble<2>(body, square(2).format_2(), R"("initial_position": ["s1", "s1"])"),
             "/initial_position: flattens element 101 at the reference place ("));
  // One node too far, and one mirrored as a whole, which is no fold.
  EXPECT_TRUE(contains(
    trouble<2>(
      body,
      square(3).format_2(),
      R"("initial_position": ["s1 > 0.2 && s1 < 0.4 && s2 > 0.2 && s2 < 0.4 ? 1.5 : s1", "s2"])"),
    "/initial_position: folds the body"));
  EXPECT_EQ(trouble<2>(body, square(3).format_2(), R"("initial_position": ["-s1", "s2"])"), "");
}

// --- nodes at one place

TEST(Gmsh, NodesAtOnePlaceAreToldOrMerged)
{
  const auto check = [](const auto &model, const unsigned int n, const unsigned int parts) {
    ASSERT_EQ(remarks(*model), Kinds{"unmerged_nodes"});
    EXPECT_EQ(model->mesh().remarks()[0].value, n);
    EXPECT_TRUE(contains(model->mesh().remarks()[0].text, std::to_string(n) + " of its nodes lie"));
    EXPECT_TRUE(contains(model->mesh().remarks()[0].text,
                         "has " + std::to_string(parts) + (parts == 1 ? " part;" : " parts;")));
  };
  // Far from the origin, and with round-off.
  for (const double far : {0., 1e5})
    {
      const Mesh halves =
        square(4).shifted({far, 0, 0}) + square(4).shifted({far + 1 + (far > 0 ? 1e-10 : 0), 0, 0});
      for (const std::string &text : halves.texts())
        {
          check(model_of<2>(body, text), 5, 2);
          const auto merged = model_of<2>(body, text, "", merge);
          EXPECT_EQ(remarks(*merged), Kinds());
          EXPECT_EQ(n_parts(*merged), 1u);
          EXPECT_EQ(merged->mesh().n_nodes(), 45u);
          EXPECT_NEAR(check_mesh(merged->mesh()), 2, 1e-9);
        }
    }
  const std::string cubes = (cube() + cube().shifted({0, 0, 1})).format_4();
  check(model_of<3>(body, cubes), 4, 2);
  EXPECT_EQ(n_parts(*model_of<3>(body, cubes, "", merge)), 1u);

  // A loop of pieces is closed when it is merged, and has an inside.
  Mesh pieces{1, {}, {}, {}};
  const Mesh polygon = loop(2, 7);
  for (unsigned int i = 0; i < 7; ++i)
    pieces += Mesh{1, {polygon.nodes[i], polygon.nodes[(i + 1) % 7]}, {{0, 1}}, {}};
  check(model_of<2>(membrane, pieces.format_2()), 7, 7);
  const auto closed = model_of<2>(membrane, pieces.format_2(), "", merge);
  EXPECT_TRUE(closed->mesh().closed());
  EXPECT_NEAR(closed->measure(closed->positions), area(2, 7), 1e-13);

  // A slit: one part.
  Mesh slit = square(2);
  slit.nodes.push_back(slit.nodes[7]); // the middle of the upper side, for elements on the right
  for (auto &node : slit.elements[6])
    node = node == 7 ? 9 : node;
  for (auto &node : slit.elements[7])
    node = node == 7 ? 9 : node;
  check(model_of<2>(body, slit.format_2()), 1, 1);
  // Near is not the same.
  EXPECT_EQ(remarks(
              *model_of<2>(body, (square(2) + square(2).shifted({1.00001, 0, 0})).format_2())),
            Kinds());
}

// --- membranes of several parts

namespace
{
  template <int dim>
  void
  encloses(const Mesh &mesh, const double measure, const dealii::Point<dim> &centroid)
  {
    for (const std::string &text : mesh.texts())
      {
        const auto model = model_of<dim>(membrane, text);
        EXPECT_NEAR(model->measure(model->positions), measure, 1e-12 * measure);
        EXPECT_LT(model->centroid(model->positions).distance(centroid), 1e-12);
        EXPECT_EQ(remarks(*model), Kinds());
        EXPECT_GT(check_mesh(model->mesh()), 0);
        // Normals outward: by the divergence theorem, from the facets that couplings see.
        double sum = 0;
        for (const auto &facet : model->mesh().surface())
          {
            dealii::Tensor<2, dim> corners;
            for (unsigned int k = 0; k < dim; ++k)
              corners[k] = model->positions[facet[k]];
            sum += determinant(corners) / (dim == 2 ? 2 : 6);
          }
        EXPECT_NEAR(sum, measure, 1e-12 * measure);
        // The load is what it is without turning.
        const NodalField<dim> f = load(*model, shaken(*model));
        dealii::Tensor<1, dim> total;
        for (const auto &force : f)
          total += force;
        EXPECT_LT(total.norm(), 1e-13 * norm(f));
      }
  }
} // namespace

TEST(Gmsh, LoopsSideBySide)
{
  for (const bool turned : {false, true})
    for (const bool other_turned : {false, true})
      encloses<2>(loop(1, 12, turned) + loop(.5, 8, other_turned).shifted({3, 0, 0}),
                  area(1, 12) + area(.5, 8),
                  dealii::Point<2>(3 * area(.5, 8) / (area(1, 12) + area(.5, 8)), 0));
}

TEST(Gmsh, LoopsInLoops)
{
  for (const bool turned : {false, true})
    for (const bool other_turned : {false, true})
      {
        const double hole = area(.5, 9), all = area(2, 40) - hole;
        const Mesh outer = loop(2, 40, turned),
                   inner = loop(.5, 9, other_turned).shifted({.5, 0, 0});
        encloses<2>(outer + inner, all, dealii::Point<2>(-.5 * hole / all, 0));
        encloses<2>(inner + outer, all, dealii::Point<2>(-.5 * hole / all, 0));
        // An island in the hole.
        const double island = area(.2, 5);
        encloses<2>(inner + loop(.2, 5, turned).shifted({.5, 0, 0}) + outer,
                    all + island,
                    dealii::Point<2>((.5 * island - .5 * hole) / (all + island), 0));
      }
}

TEST(Gmsh, SurfacesSideBySideAndInSurfaces)
{
  for (const bool turned : {false, true})
    for (const bool other_turned : {false, true})
      {
        encloses<3>(surface(1, turned) + surface(.5, other_turned).shifted({4, 0, 0}),
                    8 / 3. * (1 + .125),
                    dealii::Point<3>(4 * .125 / 1.125, 0, 0));
        encloses<3>(surface(1, turned) + surface(.2, other_turned).shifted({.1, 0, 0}),
                    8 / 3. * (1 - .008),
                    dealii::Point<3>(-.1 * .008 / .992, 0, 0));
      }
}

TEST(Gmsh, LoopsThatTouchOrCross)
{
  // Two squares with a side in common, not joined: neither is in the other.
  const auto box = [](const double x, const bool turned) {
    Mesh mesh{1, {}, {}, {}};
    for (unsigned int i = 0; i < 8; ++i)
      {
        const unsigned int j = turned ? 8 - i : i;
        const double a[] = {0, .5, 1, 1, 1, .5, 0, 0}, b[] = {0, 0, 0, .5, 1, 1, 1, .5};
        mesh.nodes.push_back({x + a[j % 8], b[j % 8], 0});
        mesh.elements.push_back({i, (i + 1) % 8});
      }
    return mesh;
  };
  for (const bool turned : {false, true})
    {
      const auto model = model_of<2>(membrane, (box(0, false) + box(1, turned)).format_2());
      EXPECT_NEAR(model->measure(model->positions), 2, 1e-14);
      EXPECT_LT(model->centroid(model->positions).distance(dealii::Point<2>(1, .5)), 1e-14);
      EXPECT_EQ(remarks(*model), Kinds{"unmerged_nodes"});
    }
  const auto crossing = model_of<2>(membrane, (box(0, false) + box(.6, false)).format_2());
  ASSERT_FALSE(crossing->mesh().remarks().empty());
  EXPECT_EQ(crossing->mesh().remarks()[0].kind, "overlap");
  EXPECT_TRUE(contains(crossing->mesh().remarks()[0].text, "part of element 1"));
}
