// SPDX-License-Identifier: LGPL-2.1-or-later
#include "data_array.h"

#include <feib/testing/output_writer_kit.h>

#include <deal.II/base/utilities.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <regex>

#include <zlib.h>

FEIB_TEST_OUTPUT_WRITER("vtu");

namespace
{
  using namespace feib;
  using namespace dealii;
  using feib::testing::exact_pressure;
  using feib::testing::exact_velocity;
  using feib::testing::make_state;
  using feib::testing::TemporaryFolder;

  /// The arrays of a vtu file by name, read without the library that wrote them.
  class VtuFile
  {
  public:
    explicit VtuFile(const std::string &text)
    {
      static const std::regex tag("<DataArray([^>]* format=\"binary\"[^>]*)>([^<]*)</DataArray>");
      static const std::regex name(" Name=\"([^\"]*)\""), type(" type=\"([^\"]*)\"");
      for (std::sregex_iterator match(text.begin(), text.end(), tag), end; match != end; ++match)
        {
          const std::string attributes = (*match)[1];
          std::smatch what;
          const std::string key =
            std::regex_search(attributes, what, name) ? what[1].str() : "Points";
          std::regex_search(attributes, what, type);
          arrays[key] = decode((*match)[2], what[1]);
        }
      static const std::regex version_tag("VTKFile[^>]* version=\"([0-9.]*)\"");
      std::smatch what;
      if (std::regex_search(text, what, version_tag))
        version = std::stod(what[1]);
    }

    const std::vector<double> &
    operator[](const std::string &name) const
    {
      return arrays.at(name);
    }

    template <int dim>
    Point<dim>
    point(const unsigned int i) const
    {
      Point<dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d] = arrays.at("Points")[3 * i + d];
      return result;
    }

    double version = 0;

  private:
    /// Base64 of numbers (blocks, bytes in a block, bytes in the last, compressed bytes of each),
    /// then base64 of the zlib streams.
    static std::vector<double>
    decode(std::string text, const std::string &type)
    {
      text.erase(std::remove_if(text.begin(), text.end(), ::isspace), text.end());
      const auto numbers = [&text](const std::size_t n) {
        const std::size_t length = (4 * n + 2) / 3 * 4; // in base64
        const auto head          = Utilities::decode_base64(text.substr(0, length));
        std::vector<std::uint32_t> result(n);
        std::memcpy(result.data(), head.data(), 4 * n);
        return std::make_pair(result, length);
      };
      const std::size_t n_blocks = numbers(3).first[0];
      const auto [sizes, end]    = numbers(3 + n_blocks);
      const auto packed          = Utilities::decode_base64(text.substr(end));
      std::vector<unsigned char> bytes((n_blocks - 1) * sizes[1] + sizes[2]);
      std::size_t at = 0;
      for (std::size_t k = 0; k < n_blocks; ++k)
        {
          const uLongf wanted = k + 1 < n_blocks ? sizes[1] : sizes[2];
          uLongf n_bytes      = wanted;
          EXPECT_EQ(
            uncompress(bytes.data() + k * sizes[1], &n_bytes, packed.data() + at, sizes[3 + k]),
            Z_OK);
          EXPECT_EQ(n_bytes, wanted);
          at += sizes[3 + k];
        }
      EXPECT_EQ(at, packed.size());
      if (type == "Float32")
        return convert<float>(bytes);
      if (type == "Float64")
        return convert<double>(bytes);
      if (type == "Int32")
        return convert<std::int32_t>(bytes);
      EXPECT_EQ(type, "UInt8");
      return convert<std::uint8_t>(bytes);
    }

    template <typename T>
    static std::vector<double>
    convert(const std::vector<unsigned char> &bytes)
    {
      std::vector<T> values(bytes.size() / sizeof(T));
      std::memcpy(values.data(), bytes.data(), bytes.size());
      return {values.begin(), values.end()};
    }

    std::map<std::string, std::vector<double>> arrays;
  };

  /// In units of the cell, twice: where VTK expects the points of a Lagrange cell of degree 2.
  template <int dim>
  std::vector<std::array<int, 3>>
  lagrange_points(const bool old_order)
  {
    if (dim == 2)
      return {{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 0}, {2, 1}, {1, 2}, {0, 1}, {1, 1}};
    std::vector<std::array<int, 3>> points = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2},
                                              {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 0, 0}, {2, 1, 0},
                                              {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2}, {1, 2, 2},
                                              {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1},
                                              {0, 1, 1}, {2, 1, 1}, {1, 0, 1}, {1, 2, 1}, {1, 1, 0},
                                              {1, 1, 2}, {1, 1, 1}};
    if (old_order)
      std::swap(points[18], points[19]);
    return points;
  }

  template <int dim>
  void
  check_fluid()
  {
    TemporaryFolder folder;
    const auto space = make_state<dim>();
    const std::vector<ImmersedStructure<dim>> structures;
    const Ledger ledger;
    const auto writer = feib::testing::registry().create<OutputWriter<dim>>("vtu");
    writer->write({10, .25, folder.path, *space, structures, ledger});

    const VtuFile vtu(folder.read("fluid_000010." + std::to_string(folder.rank()) + ".vtu"));
    const unsigned int n_nodes = EulerianSpace<dim>::n_nodes;
    const unsigned int n_cells = vtu["types"].size();
    EXPECT_EQ(n_cells, space->cells().size());
    for (const double type : vtu["types"])
      EXPECT_EQ(type, dim == 2 ? 70 : 72); // VTK_LAGRANGE_QUADRILATERAL, _HEXAHEDRON
    ASSERT_EQ(vtu["Points"].size(), 3 * n_nodes * n_cells);
    ASSERT_EQ(vtu["connectivity"].size(), n_nodes * n_cells);

    // Readers of VTK 9 swap two edges of hexahedra in files older than version 2.2.
    const auto lagrange = lagrange_points<dim>(vtu.version < 2.2);
    for (unsigned int c = 0; c < n_cells; ++c)
      {
        const Point<dim> lower = vtu.point<dim>(vtu["connectivity"][c * n_nodes]);
        const Tensor<1, dim> size =
          vtu.point<dim>(vtu["connectivity"][c * n_nodes + (dim == 2 ? 2 : 6)]) - lower;
        for (unsigned int i = 0; i < n_nodes; ++i)
          {
            const unsigned int point = vtu["connectivity"][c * n_nodes + i];
            const Point<dim> x       = vtu.point<dim>(point);
            for (unsigned int d = 0; d < dim; ++d)
              EXPECT_NEAR(x[d], lower[d] + size[d] * lagrange[i][d] / 2., 1e-15);
            for (unsigned int d = 0; d < dim; ++d)
              EXPECT_NEAR(vtu["velocity"][3 * point + d], exact_velocity<dim>(x)[d], 2e-6);
            EXPECT_NEAR(vtu["pressure"][point], exact_pressure<dim>(x), 2e-6);
            EXPECT_EQ(vtu["subdomain"][point], folder.rank());
            EXPECT_EQ(vtu["level"][point], x[0] == .5 ? vtu["level"][point] : x[0] < .5);
          }
      }

    const std::string record = folder.read("fluid_000010.pvtu");
    for (unsigned int r = 0; r < Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD); ++r)
      EXPECT_NE(record.find("fluid_000010." + std::to_string(r) + ".vtu"), std::string::npos);
    EXPECT_NE(record.find("velocity"), std::string::npos);
  }

  TEST(Vtu, LongArraysAreDividedIntoBlocks)
  {
    // The bytes of a block are written in 32 bits.
    std::vector<double> values(100);
    for (unsigned int i = 0; i < values.size(); ++i)
      values[i] = std::sin(i);
    for (const std::size_t block : {800, 799, 400, 96, 7})
      EXPECT_EQ(VtuFile(feib::data_array("name", 1, values, block))["name"], values) << block;
    EXPECT_EQ(VtuFile(feib::data_array("name", 1, std::vector<double>()))["name"].size(), 0u);
  }

  /// Vorticity, shear rate and Q of the exact velocity.
  TEST(Vtu, DerivativesOfTheVelocity)
  {
    TemporaryFolder folder;
    const auto space = make_state<2>();
    const std::vector<ImmersedStructure<2>> structures;
    const Ledger ledger;
    const auto writer =
      feib::testing::registry().create<OutputWriter<2>>("vtu", R"({"derivatives": true})");
    writer->write({10, .5, folder.path, *space, structures, ledger});
    const VtuFile vtu(folder.read("fluid_000010." + std::to_string(folder.rank()) + ".vtu"));
    ASSERT_EQ(vtu["vorticity"].size(), 9 * space->cells().size());
    for (unsigned int i = 0; i < vtu["vorticity"].size(); ++i)
      {
        // u = (1 + x^2 - 2 x y, y^2 + 3 x - y + x y / 2)
        const Point<2> x = vtu.point<2>(i);
        const double u_x = 2 * x[0] - 2 * x[1], u_y = -2 * x[0], v_x = 3 + x[1] / 2,
                     v_y  = 2 * x[1] - 1 + x[0] / 2;
        const double D_xy = (u_y + v_x) / 2, W = v_x - u_y;
        const double D = u_x * u_x + v_y * v_y + 2 * D_xy * D_xy;
        EXPECT_NEAR(vtu["vorticity"][i], W, 1e-5);
        EXPECT_NEAR(vtu["shear_rate"][i], std::sqrt(2 * D), 1e-5);
        EXPECT_NEAR(vtu["q_criterion"][i], (W * W / 2 - D) / 2, 1e-5);
      }
  }

  TEST(Vtu, FluidFieldsAreExact2D)
  {
    check_fluid<2>();
  }

  TEST(Vtu, FluidFieldsAreExact3D)
  {
    check_fluid<3>();
  }

  /// Force densities, and the projection of fields of elements, which keeps their integrals.
  template <int dim>
  void
  check_nodal_fields(const std::vector<ImmersedStructure<dim>> &structures,
                     const EulerianSpace<dim> &space)
  {
    TemporaryFolder folder;
    const Ledger ledger;
    const StructureModel<dim> &model = *structures[0].model;
    const auto writer =
      feib::testing::registry().create<OutputWriter<dim>>("vtu", R"({"nodal": true})");
    writer->write({0, 0., folder.path, space, structures, ledger});
    const VtuFile vtu(folder.read("body_000000.vtu"));
    const auto &mesh     = model.mesh();
    const unsigned int n = mesh.structure_dim() + 1;
    NodalField<dim> load;
    model.load(model.positions, load);
    std::vector<double> measures(mesh.n_nodes(), 0.), energy(mesh.n_nodes(), 0.);
    double total = 0;
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      {
        const auto &element = mesh.elements()[e];
        total += element.measure * model.energy_density(model.positions)[e];
        for (unsigned int k = 0; k < n; ++k)
          {
            measures[element.nodes[k]] += element.measure / n;
            energy[element.nodes[k]] =
              vtu["energy_density_nodal"][unsigned(vtu["connectivity"][n * e + k])];
          }
      }
    double projected = 0;
    for (unsigned int i = 0; i < mesh.n_nodes(); ++i)
      projected += measures[i] * energy[i];
    EXPECT_NEAR(projected, total, 1e-13 * std::abs(total));
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      for (unsigned int k = 0; k < n; ++k)
        {
          const unsigned int node = mesh.elements()[e].nodes[k];
          for (unsigned int a = 0; a < dim; ++a)
            EXPECT_NEAR(vtu["force_density"][3 * unsigned(vtu["connectivity"][n * e + k]) + a],
                        load[node][a] / measures[node],
                        1e-12 * (1 + std::abs(load[node][a] / measures[node])));
        }
    MPI_Barrier(MPI_COMM_WORLD);
  }

  template <int dim>
  void
  check_structure(const std::string &component, const std::string &block, const int type)
  {
    TemporaryFolder folder;
    const auto space = make_state<dim>();
    std::vector<ImmersedStructure<dim>> structures(1);
    const Ledger ledger;
    structures[0].model = feib::testing::registry().create<StructureModel<dim>>(component, block);
    StructureModel<dim> &model = *structures[0].model;
    for (Point<dim> &x : model.positions)
      x[0] += .125 * x[1] * x[1];
    const auto writer = feib::testing::registry().create<OutputWriter<dim>>("vtu");
    writer->write({0, 0., folder.path, *space, structures, ledger});
    const VtuFile vtu(folder.read("body_000000.vtu"));
    check_nodal_fields<dim>(structures, *space);

    const auto &mesh     = model.mesh();
    const auto density   = model.energy_density(model.positions);
    const auto stress    = model.cauchy_stress(model.positions);
    const unsigned int n = mesh.structure_dim() + 1;
    ASSERT_EQ(vtu["types"].size(), mesh.n_elements());
    ASSERT_EQ(vtu["connectivity"].size(), n * mesh.n_elements());
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      {
        const auto &element = mesh.elements()[e];
        EXPECT_EQ(vtu["types"][e], type);
        for (unsigned int k = 0; k < n; ++k)
          {
            const unsigned int point = vtu["connectivity"][n * e + k];
            EXPECT_EQ(vtu.point<dim>(point), model.positions[element.nodes[k]]);
            EXPECT_EQ(vtu["energy_density"][point], density[e]);
            // x_0 has become x_0 + x_1^2/8.
            const Point<dim> &X = model.positions[element.nodes[k]];
            EXPECT_NEAR(vtu["displacement"][3 * point], .125 * X[1] * X[1], 1e-15);
            EXPECT_EQ(vtu["displacement"][3 * point + 1], 0);
            // F takes the step between two reference corners to that between their places.
            const unsigned int next = vtu["connectivity"][n * e + (k + 1) % n];
            for (unsigned int i = 0; i < dim; ++i)
              {
                double step = 0;
                for (unsigned int j = 0; j < dim; ++j)
                  step += vtu["F"][9 * point + 3 * i + j] *
                          (vtu["reference"][3 * next + j] - vtu["reference"][3 * point + j]);
                EXPECT_NEAR(step, vtu.point<dim>(next)[i] - vtu.point<dim>(point)[i], 1e-14);
              }
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j)
                EXPECT_EQ(vtu["cauchy_stress"][9 * point + 3 * i + j], stress[e][i][j]);
            EXPECT_NEAR(vtu["von_mises_stress"][point],
                        std::sqrt(1.5) * deviator(stress[e]).norm(),
                        1e-14);
            EXPECT_EQ(vtu["material_id"][point], element.material_id);
            // The gradient of a shape function takes the step between two corners to 1 or 0.
            for (unsigned int i = 0; i < n; ++i)
              {
                double change = 0;
                for (unsigned int a = 0; a + 1 < n; ++a)
                  for (unsigned int d = 0; d < dim; ++d)
                    change += element.shape_gradients[i][a] * element.frame[a][d] *
                              (vtu["reference"][3 * point + d] - element.centroid[d]);
                EXPECT_NEAR(change, (i == k) - 1. / n, 1e-12);
              }
          }
      }
  }

  std::string
  body(const std::string &rest)
  {
    return R"({"name": "body", "law": {"neo_hookean": {"shear_modulus": 1}}, )" + rest + "}";
  }

  TEST(Vtu, StructuresOfAllDimensions)
  {
    check_structure<2>("membrane",
                       body(R"json("mesh": {"closed_curve": {"length": 1, "elements": 8}},
                         "initial_position": ["0.5 + 0.2 * cos(2 * pi * s1)",
                                              "0.5 + 0.2 * sin(2 * pi * s1)"])json"),
                       3);
    check_structure<2>("hyperelastic",
                       body(R"("mesh": {"disc": {"radius": 0.25, "rings": 2}})"),
                       5);
    check_structure<3>("membrane",
                       body(R"("mesh": {"sphere": {"radius": 0.25, "refinements": 0}})"),
                       5);
    check_structure<3>("hyperelastic",
                       body(R"("mesh": {"ball": {"radius": 0.25, "refinements": 0}})"),
                       10);
  }

  /// A structure and cells in the unit box at @p origin, where single precision has no digits left.
  /// @p block: with X, Y (and Z) for the middle of the box.
  template <int dim>
  void
  check_far_away(const std::array<double, dim> &origin,
                 const std::string &component,
                 std::string block)
  {
    const auto list = [&](const double shift) {
      std::string text;
      for (const double x : origin)
        text += (text.empty() ? "" : ", ") + Utilities::to_string(x + shift);
      return "[" + text + "]";
    };
    for (unsigned int a = 0; a < dim; ++a)
      for (std::size_t at; (at = block.find("XYZ"[a])) != std::string::npos;)
        block.replace(at, 1, Utilities::to_string(origin[a] + .5));
    TemporaryFolder folder;
    const auto space =
      feib::testing::make_space<dim>("{\"lower\": " + list(0) + ", \"upper\": " + list(1) +
                                     ", \"cells\": " + (dim == 2 ? "[4, 4]}" : "[4, 4, 4]}"));
    std::vector<ImmersedStructure<dim>> structures(1);
    const Ledger ledger;
    structures[0].model =
      feib::testing::registry().create<StructureModel<dim>>(component, body(block));
    const auto writer = feib::testing::registry().create<OutputWriter<dim>>("vtu");
    writer->write({0, 0., folder.path, *space, structures, ledger});

    const VtuFile written(folder.read("body_000000.vtu"));
    const auto &model    = *structures[0].model;
    const unsigned int n = model.mesh().structure_dim() + 1;
    for (unsigned int e = 0; e < model.mesh().n_elements(); ++e)
      for (unsigned int k = 0; k < n; ++k)
        {
          const auto &element      = model.mesh().elements()[e];
          const unsigned int point = written["connectivity"][n * e + k];
          EXPECT_EQ(written.point<dim>(point), model.positions[element.nodes[k]]);
          EXPECT_EQ(written["material_id"][point], element.material_id);
          for (unsigned int a = 0; a < dim; ++a)
            if (model.mesh().structure_dim() == dim) // the reference coordinates are places
              {
                EXPECT_NEAR(written["reference"][3 * point + a],
                            model.positions[element.nodes[k]][a],
                            1e-15 * std::abs(origin[a]) + 1e-15);
              }
        }

    const VtuFile fluid(folder.read("fluid_000000." + std::to_string(folder.rank()) + ".vtu"));
    constexpr unsigned int n_nodes = EulerianSpace<dim>::n_nodes;
    for (unsigned int c = 0; c < fluid["types"].size(); ++c)
      for (unsigned int a = 0; a < dim; ++a)
        EXPECT_EQ(fluid.point<dim>(fluid["connectivity"][n_nodes * c + (dim == 2 ? 2 : 6)])[a] -
                    fluid.point<dim>(fluid["connectivity"][n_nodes * c])[a],
                  .25);
    EXPECT_NE(folder.read("fluid_000000.pvtu").find("\"Float64\" NumberOfComponents=\"3\""),
              std::string::npos);
  }

  TEST(Vtu, NoDigitsAreLostFarFromTheOrigin)
  {
    const std::string disc = R"("mesh": {"disc": {"centre": [X, Y], "radius": 0.25, "rings": 3}},
                                "material": "16777217")";
    check_far_away<2>({1e6, 1e6}, "hyperelastic", disc);
    check_far_away<2>({1e8, -1e8}, "hyperelastic", disc);
    check_far_away<2>({-1e9, 0}, "hyperelastic", disc);
    check_far_away<2>({1e8, -1e8},
                      "membrane",
                      R"j("mesh": {"closed_curve": {"length": 1, "elements": 12}},
                          "initial_position": ["X + 0.2 * cos(2 * pi * s1)",
                                               "Y + 0.2 * sin(2 * pi * s1)"])j");
    check_far_away<3>(
      {1e8, 0, -1e8},
      "hyperelastic",
      R"("mesh": {"ball": {"centre": [X, Y, Z], "radius": 0.25, "refinements": 0}})");
    check_far_away<3>({0, 1e8, 1e8},
                      "membrane",
                      R"("mesh": {"sphere": {"radius": 0.25, "refinements": 0}},
                         "initial_position": ["s1 + X", "s2 + Y", "s3 + Z"])");
  }

  TEST(Vtu, TheSeriesNamesAllTimes)
  {
    TemporaryFolder folder;
    const auto space = make_state<2>();
    const std::vector<ImmersedStructure<2>> structures;
    const Ledger ledger;
    const auto writer = feib::testing::registry().create<OutputWriter<2>>("vtu");
    writer->write({0, 0., folder.path, *space, structures, ledger});
    writer->write({10, .25, folder.path, *space, structures, ledger});
    const std::string series = folder.read("fluid.pvd");
    EXPECT_TRUE(std::regex_search(series,
                                  std::regex("timestep=\"0\"[^>]*fluid_000000.pvtu[^]*"
                                             "timestep=\"0.25\"[^>]*fluid_000010.pvtu")))
      << series;
  }
} // namespace
