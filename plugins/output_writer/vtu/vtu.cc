// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/appended_file.h>
#include <feib/failure.h>
#include <feib/output_writer.h>
#include <feib/plugin.h>

#include <deal.II/base/data_out_base.h>
#include <deal.II/base/mpi.h>
#include <deal.II/numerics/data_out.h>
#include <deal.II/numerics/data_postprocessor.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <regex>
#include <iomanip>
#include <sstream>

#include "data_array.h"
#include "vtu_schema.h"

namespace
{
  using namespace dealii;

  void
  write_file(const std::string &name, const std::string &text)
  {
    errno = 0;
    std::ofstream file(name, std::ios::binary);
    file << text;
    file.close();
    if (!file)
      throw feib::RunFailure("cannot write " + name +
                             (errno ? std::string(": ") + std::strerror(errno) : ""));
  }

  /// Adds a point, with the three coordinates that VTK wants.
  template <int dim>
  void
  append(std::vector<double> &coordinates, const Point<dim> &point)
  {
    for (unsigned int d = 0; d < 3; ++d)
      coordinates.push_back(d < dim ? point[d] : 0.);
  }

  /// Numbers for each element, or each node.
  struct Field
  {
    std::string name;
    unsigned int n_components;
    std::vector<double> values;
  };

  /// F as a matrix of the space, by rows: the part along the structure, which for curves and
  /// surfaces is all there is.
  template <int dim>
  Field
  deformation_gradient(const feib::LagrangianMesh<dim> &mesh, const feib::Positions<dim> &X)
  {
    Field result{"F", 9, std::vector<double>(9 * mesh.n_elements(), 0.)};
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      {
        const auto &element = mesh.elements()[e];
        for (unsigned int k = 0; k <= mesh.structure_dim(); ++k)
          for (unsigned int l = 0; l < mesh.structure_dim(); ++l)
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j)
                result.values[9 * e + 3 * i + j] +=
                  X[element.nodes[k]][i] * element.shape_gradients[k][l] * element.frame[l][j];
      }
    return result;
  }

  /// J, the present measure of an element over that of reference.
  template <int dim>
  Field
  stretch(const feib::LagrangianMesh<dim> &mesh, const feib::Positions<dim> &X)
  {
    Field result{"J", 1, {}};
    for (const auto &element : mesh.elements())
      result.values.push_back(mesh.measure(element, X) / element.measure);
    return result;
  }

  /// The elastic stress and sqrt(3/2) |its deviator|.
  template <int dim>
  std::vector<Field>
  stresses(const std::vector<SymmetricTensor<2, dim>> &cauchy)
  {
    Field stress{"cauchy_stress", 9, {}}, von_mises{"von_mises_stress", 1, {}};
    for (const SymmetricTensor<2, dim> &sigma : cauchy)
      {
        for (unsigned int i = 0; i < 3; ++i)
          for (unsigned int j = 0; j < 3; ++j)
            stress.values.push_back(i < dim && j < dim ? sigma[i][j] : 0.);
        von_mises.values.push_back(std::sqrt(1.5) * deviator(sigma).norm());
      }
    return {stress, von_mises};
  }

  /// A vector for each node, as three numbers.
  template <int dim, typename Values>
  Field
  nodal_field(const std::string &name, const Values &vectors)
  {
    Field result{name, 3, {}};
    for (const auto &vector : vectors)
      for (unsigned int d = 0; d < 3; ++d)
        result.values.push_back(d < dim ? vector[d] : 0.);
    return result;
  }

  /// The projection of a field of elements to continuous functions by lumped masses: at each node
  /// the mean of the elements around it, weighted by their measures.
  template <int dim>
  Field
  projected(const Field &field, const feib::LagrangianMesh<dim> &mesh)
  {
    const unsigned int n               = field.n_components;
    const std::vector<double> measures = mesh.node_measures();
    Field result{field.name + "_nodal", n, std::vector<double>(n * mesh.n_nodes(), 0.)};
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      for (unsigned int k = 0; k <= mesh.structure_dim(); ++k)
        {
          const unsigned int node = mesh.elements()[e].nodes[k];
          const double share =
            mesh.elements()[e].measure / (mesh.structure_dim() + 1) / measures[node];
          for (unsigned int c = 0; c < n; ++c)
            result.values[n * node + c] += share * field.values[n * e + c];
        }
    return result;
  }

  /// A structure at its present place, with its reference coordinates, materials and fields.
  /// Every element has corners of its own: reference coordinates jump across seams.
  template <int structure_dim, int dim>
  std::string
  structure_text(const feib::LagrangianMesh<dim> &mesh,
                 const feib::Positions<dim> &X,
                 const std::vector<Field> &element_fields,
                 const std::vector<Field> &nodal_fields,
                 const double time)
  {
    constexpr unsigned int n       = structure_dim + 1;
    constexpr std::uint8_t types[] = {0, 3, 5, 10}; // VTK_LINE, _TRIANGLE, _TETRA
    std::vector<double> points, reference;
    std::vector<std::int32_t> connectivity, offsets, materials;
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      {
        const typename feib::LagrangianMesh<dim>::Element &element = mesh.elements()[e];
        for (unsigned int k = 0; k < n; ++k)
          {
            append(points, X[element.nodes[k]]);
            append(reference, mesh.corner(element, k));
            materials.push_back(element.material_id);
            connectivity.push_back(n * e + k);
          }
        offsets.push_back(n * (e + 1));
      }
    using feib::data_array;
    std::ostringstream text;
    text << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
            "compressor=\"vtkZLibDataCompressor\" byte_order=\"LittleEndian\">\n"
            "<UnstructuredGrid>\n<FieldData>\n"
         << data_array("TIME", 1, std::vector<double>{time}) << "</FieldData>\n"
         << "<Piece NumberOfPoints=\"" << n * mesh.n_elements() << "\" NumberOfCells=\""
         << mesh.n_elements() << "\">\n<Points>\n"
         << data_array("", 3, points) << "</Points>\n<Cells>\n"
         << data_array("connectivity", 1, connectivity) << data_array("offsets", 1, offsets)
         << data_array("types",
                       1,
                       std::vector<std::uint8_t>(mesh.n_elements(), types[structure_dim]))
         << "</Cells>\n<PointData>\n"
         << data_array("reference", 3, reference) << data_array("material_id", 1, materials);
    const auto add_at_corners = [&](const Field &field, const auto &index) {
      std::vector<double> at_corners;
      for (unsigned int e = 0; e < mesh.n_elements(); ++e)
        for (unsigned int k = 0; k < n; ++k)
          {
            const auto first = field.values.begin() + index(e, k) * field.n_components;
            at_corners.insert(at_corners.end(), first, first + field.n_components);
          }
      text << data_array(field.name, field.n_components, at_corners);
    };
    for (const Field &field : element_fields)
      add_at_corners(field, [](const unsigned int e, unsigned int) { return e; });
    for (const Field &field : nodal_fields)
      add_at_corners(field, [&](const unsigned int e, const unsigned int k) {
        return mesh.elements()[e].nodes[k];
      });
    text << "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    return text.str();
  }

  /// deal.II writes all in single precision, which far from the origin does not tell the points of
  /// a cell apart: this puts others in their place. @p text: a vtu file.
  void
  replace_points(std::string &text, const std::vector<double> &points)
  {
    const std::string opening = "<Points>", closing = "</Points>";
    const std::size_t begin = text.find(opening) + opening.size(), end = text.find(closing);
    if (end == std::string::npos) // a rank without cells
      return;
    text.replace(begin, end - begin, "\n" + feib::data_array("", 3, points));
  }


  /// What the gradient of the velocity says, from each cell by itself: vorticity, the Q criterion
  /// (|W|^2 - |D|^2)/2 of its antisymmetric and symmetric parts, and the shear rate sqrt(2 D : D).
  template <int dim>
  class Derivatives : public DataPostprocessor<dim>
  {
  public:
    void
    evaluate_vector_field(const DataPostprocessorInputs::Vector<dim> &inputs,
                          std::vector<Vector<double>> &results) const override
    {
      for (unsigned int q = 0; q < results.size(); ++q)
        {
          const auto &gradient = inputs.solution_gradients[q]; // [a][b]: d_b u_a
          double symmetric = 0, antisymmetric = 0;
          for (unsigned int a = 0; a < dim; ++a)
            for (unsigned int b = 0; b < dim; ++b)
              {
                symmetric += std::pow((gradient[a][b] + gradient[b][a]) / 2, 2);
                antisymmetric += std::pow((gradient[a][b] - gradient[b][a]) / 2, 2);
              }
          results[q][0] = (antisymmetric - symmetric) / 2;
          results[q][1] = std::sqrt(2 * symmetric);
          if (dim == 2)
            results[q][2] = gradient[1][0] - gradient[0][1];
          else
            for (unsigned int a = 0; a < dim; ++a)
              {
                const unsigned int b = (a + 1) % dim, c = (a + 2) % dim;
                results[q][2 + a] = gradient[c][b] - gradient[b][c];
              }
        }
    }

    std::vector<std::string>
    get_names() const override
    {
      std::vector<std::string> names = {"q_criterion", "shear_rate"};
      names.resize(dim == 2 ? 3 : 5, "vorticity");
      return names;
    }

    std::vector<DataComponentInterpretation::DataComponentInterpretation>
    get_data_component_interpretation() const override
    {
      using namespace DataComponentInterpretation;
      std::vector<DataComponentInterpretation::DataComponentInterpretation> result(
        2, component_is_scalar);
      if (dim == 2)
        result.push_back(component_is_scalar);
      else
        result.resize(5, component_is_part_of_vector);
      return result;
    }

    UpdateFlags
    get_needed_update_flags() const override
    {
      return update_gradients;
    }
  };


  template <int dim>
  class Vtu : public feib::OutputWriter<dim>
  {
  public:
    using Snapshot = typename feib::OutputWriter<dim>::Snapshot;

    explicit Vtu(const feib::Parameters &parameters)
      : steps(parameters.integer("interval"))
      , derivatives(parameters.boolean("derivatives"))
      , projects(parameters.boolean("nodal"))
    {}

    unsigned int
    interval() const override
    {
      return steps;
    }

    void
    write(const Snapshot &snapshot) override
    {
      const MPI_Comm communicator = snapshot.space.communicator();
      feib::agree(communicator, [&] { write_fluid(snapshot); });
      for (const feib::ImmersedStructure<dim> &structure : snapshot.structures)
        feib::agree(communicator, [&] { write_structure(snapshot, *structure.model); });
    }

    void
    archive(feib::Archive &archive) override
    {
      archive("series", series);
    }

    void
    reopen(const std::string &directory, const MPI_Comm communicator) override
    {
      feib::agree(communicator, [&] {
        if (Utilities::MPI::this_mpi_process(communicator) == 0)
          for (auto &[name, record] : series)
            record.reopen(directory + "/" + name + ".pvd", series_end);
      });
    }

  private:
    void
    write_fluid(const Snapshot &snapshot)
    {
      const feib::EulerianSpace<dim> &space = snapshot.space;

      feib::VelocityVector velocity = space.velocity;
      velocity.update_ghost_values();
      feib::PressureVector pressure = space.pressure;
      pressure.update_ghost_values();
      Vector<float> level(space.triangulation().n_active_cells());
      Vector<float> subdomain(space.triangulation().n_active_cells());
      for (const auto &cell : space.triangulation().active_cell_iterators())
        if (cell->is_locally_owned())
          {
            level[cell->active_cell_index()]     = space.level(*cell);
            subdomain[cell->active_cell_index()] = cell->subdomain_id();
          }

      using namespace DataComponentInterpretation;
      DataOut<dim> out;
      out.attach_triangulation(space.triangulation());
      out.add_data_vector(space.velocity_handler(),
                          velocity,
                          std::vector<std::string>(dim, "velocity"),
                          std::vector<DataComponentInterpretation::DataComponentInterpretation>(
                            dim, component_is_part_of_vector));
      out.add_data_vector(space.pressure_handler(), pressure, "pressure");
      const Derivatives<dim> of_velocity;
      if (derivatives)
        out.add_data_vector(space.velocity_handler(), velocity, of_velocity);
      out.add_data_vector(level, "level", DataOut<dim>::type_cell_data);
      out.add_data_vector(subdomain, "subdomain", DataOut<dim>::type_cell_data);
      // Lagrange cells of degree 2 hold Q2 fields as they are.
      out.build_patches(space.mapping(), 2, DataOut<dim>::curved_inner_cells);
      DataOutBase::VtkFlags flags(snapshot.time,
                                  snapshot.step,
                                  false,
                                  DataOutBase::VtkFlags::best_speed);
      flags.write_higher_order_cells = true;
      out.set_flags(flags);

      const std::string name = "fluid_" + Utilities::int_to_string(snapshot.step, 6);
      const auto piece       = [&name](const unsigned int rank) {
        return name + "." + std::to_string(rank) + ".vtu";
      };
      std::ostringstream stream;
      out.write_vtu(stream);
      std::string text = stream.str();
      replace_points(text, fluid_points(space));
      const unsigned int rank = Utilities::MPI::this_mpi_process(space.communicator());
      write_file(snapshot.directory + "/" + piece(rank), text);
      if (rank == 0)
        {
          std::vector<std::string> pieces;
          for (unsigned int r = 0; r < Utilities::MPI::n_mpi_processes(space.communicator()); ++r)
            pieces.push_back(piece(r));
          std::ostringstream record;
          out.write_pvtu_record(record, pieces);
          const std::string with_double =
            std::regex_replace(record.str(),
                               std::regex("(<PPoints>\\s*<PDataArray type=)\"Float32\""),
                               "$1\"Float64\"");
          // deal.II notes when it was written: the same run would not give the same file.
          const std::string undated =
            std::regex_replace(with_double, std::regex("<!--[^>]*-->\\s*"), "");
          write_file(snapshot.directory + "/" + name + ".pvtu", undated);
          add_to_series(snapshot, "fluid", name + ".pvtu");
        }
    }

    void
    write_structure(const Snapshot &snapshot, const feib::StructureModel<dim> &model)
    {
      const auto &mesh               = model.mesh();
      const auto &X                  = model.positions;
      std::vector<Field> of_elements = {{"energy_density", 1, model.energy_density(X)},
                                        deformation_gradient(mesh, X),
                                        stretch(mesh, X)};
      for (Field &stress : stresses<dim>(model.cauchy_stress(X)))
        of_elements.push_back(std::move(stress));
      for (auto &[variable, values] : model.state())
        of_elements.push_back({variable, 1, std::move(values)});
      feib::NodalField<dim> displacement(X.begin(), X.end());
      for (unsigned int i = 0; i < displacement.size(); ++i)
        displacement[i] -= model.initial_positions[i];
      std::vector<Field> of_nodes = {nodal_field<dim>("displacement", displacement),
                                     nodal_field<dim>("velocity", model.velocities)};
      if (model.load_points().are_nodes(mesh.n_nodes()))
        {
          feib::NodalField<dim> load;
          model.load(X, load);
          const std::vector<double> measures = mesh.node_measures();
          for (unsigned int i = 0; i < load.size(); ++i)
            load[i] /= measures[i];
          of_nodes.push_back(nodal_field<dim>("force_density", load));
        }
      if (projects)
        for (const Field &field : of_elements)
          of_nodes.push_back(projected(field, mesh));
      if (Utilities::MPI::this_mpi_process(snapshot.space.communicator()) != 0)
        return;

      const std::string name =
        model.name() + "_" + Utilities::int_to_string(snapshot.step, 6) + ".vtu";
      const auto make = [&](const auto dimension) {
        return structure_text<decltype(dimension)::value, dim>(
          mesh, X, of_elements, of_nodes, snapshot.time);
      };
      const std::string text = mesh.structure_dim() == dim
                                 ? make(std::integral_constant<int, dim>())
                                 : make(std::integral_constant<int, dim - 1>());
      write_file(snapshot.directory + "/" + name, text);
      add_to_series(snapshot, model.name(), name);
    }

    /// The points of the patches, in deal.II's order: cell by cell, lexicographic.
    static std::vector<double>
    fluid_points(const feib::EulerianSpace<dim> &space)
    {
      std::vector<double> points;
      points.reserve(3 * feib::EulerianSpace<dim>::n_nodes * space.cells().size());
      for (const auto &cell : space.triangulation().active_cell_iterators())
        if (cell->is_locally_owned())
          for (unsigned int i = 0; i < feib::EulerianSpace<dim>::n_nodes; ++i)
            {
              Point<dim> x      = cell->vertex(0);
              unsigned int rest = i;
              for (unsigned int a = 0; a < dim; ++a, rest /= 3)
                x[a] += cell->extent_in_direction(a) * (rest % 3) / 2.;
              append(points, x);
            }
      return points;
    }

    /// Adds one more file to the time series of a name, at the same cost at every output.
    void
    add_to_series(const Snapshot &snapshot, const std::string &name, const std::string &file)
    {
      feib::AppendedFile &record = series[name];
      if (!record.is_open())
        record.open(snapshot.directory + "/" + name + ".pvd",
                    "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" "
                    "version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n");
      std::ostringstream entry;
      entry << std::setprecision(12) << "<DataSet timestep=\"" << snapshot.time
            << "\" group=\"\" part=\"0\" file=\"" << file << "\"/>\n";
      record.append(entry.str(), series_end);
    }

    static constexpr const char *series_end = "</Collection>\n</VTKFile>\n";

    const unsigned int steps;
    const bool derivatives;
    const bool projects;                              // fields of structures' elements to nodes
    std::map<std::string, feib::AppendedFile> series; // the .pvd files, on rank 0
  };
} // namespace


FEIB_PLUGIN("vtu", "1.0", registry)
{
  registry.add<feib::OutputWriter, Vtu>("vtu", vtu_schema);
}
