// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/output_writer.h>
#include <feib/plugin.h>

#include <deal.II/base/data_out_base.h>
#include <deal.II/base/mpi.h>
#include <deal.II/numerics/data_out.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

#include "vtu_schema.h"

namespace
{
  using namespace dealii;

  /// Writes the file. Returns what went wrong, in words; nothing when all is well.
  std::string
  write_file(const std::string &name, const std::string &text)
  {
    errno = 0;
    std::ofstream file(name, std::ios::binary);
    file << text;
    file.close();
    if (file)
      return "";
    return "cannot write " + name + (errno ? std::string(": ") + std::strerror(errno) : "");
  }

  /// Throws on all ranks when there was trouble on any.
  void
  agree(const std::string &trouble, const MPI_Comm communicator)
  {
    for (const std::string &text : Utilities::MPI::all_gather(communicator, trouble))
      if (!text.empty())
        throw feib::RunFailure(text);
  }

  /// The corners of an element in the reference body. They follow from the shape functions,
  /// N_i = 1/(m+1) + g_i . y in the element's own frame about its centroid; the node's own place
  /// would be wrong across a seam.
  template <int structure_dim, int dim>
  std::array<Point<dim>, structure_dim + 1>
  reference_corners(const typename feib::LagrangianMesh<dim>::Element &element)
  {
    Tensor<2, structure_dim> gradients;
    for (unsigned int i = 0; i < structure_dim; ++i)
      for (unsigned int d = 0; d < structure_dim; ++d)
        gradients[i][d] = element.shape_gradients[i][d];
    const Tensor<2, structure_dim> inverse = invert(gradients);

    std::array<Point<dim>, structure_dim + 1> corners;
    for (unsigned int k = 0; k <= structure_dim; ++k)
      {
        Tensor<1, structure_dim> values;
        for (unsigned int i = 0; i < structure_dim; ++i)
          values[i] = (i == k) - 1. / (structure_dim + 1);
        const Tensor<1, structure_dim> y = inverse * values;
        corners[k]                       = element.centroid;
        for (unsigned int d = 0; d < structure_dim; ++d)
          corners[k] += y[d] * element.frame[d];
      }
    return corners;
  }

  /// A structure at its present place, with its reference coordinates, energy density and
  /// materials.
  template <int structure_dim, int dim>
  class StructureOutput : public DataOutInterface<structure_dim, dim>
  {
  public:
    StructureOutput(const feib::LagrangianMesh<dim> &mesh,
                    const feib::Positions<dim> &X,
                    const std::vector<double> &energy_density)
      : patches(mesh.n_elements())
    {
      for (unsigned int e = 0; e < mesh.n_elements(); ++e)
        {
          const typename feib::LagrangianMesh<dim>::Element &element = mesh.elements()[e];
          const auto corners   = reference_corners<structure_dim, dim>(element);
          auto &patch          = patches[e];
          patch.reference_cell = ReferenceCells::get_simplex<structure_dim>();
          patch.patch_index    = e;
          patch.data.reinit(dim + 2, structure_dim + 1);
          for (unsigned int k = 0; k <= structure_dim; ++k)
            {
              patch.vertices[k] = X[element.nodes[k]];
              for (unsigned int d = 0; d < dim; ++d)
                patch.data(d, k) = corners[k][d];
              patch.data(dim, k)     = energy_density[e];
              patch.data(dim + 1, k) = element.material_id;
            }
        }
    }

  private:
    using Range = std::tuple<unsigned int,
                             unsigned int,
                             std::string,
                             DataComponentInterpretation::DataComponentInterpretation>;

    const std::vector<DataOutBase::Patch<structure_dim, dim>> &
    get_patches() const override
    {
      return patches;
    }

    std::vector<std::string>
    get_dataset_names() const override
    {
      std::vector<std::string> names(dim, "reference");
      names.push_back("energy_density");
      names.push_back("material_id");
      return names;
    }

    std::vector<Range>
    get_nonscalar_data_ranges() const override
    {
      return {
        Range(0, dim - 1, "reference", DataComponentInterpretation::component_is_part_of_vector)};
    }

    std::vector<DataOutBase::Patch<structure_dim, dim>> patches;
  };


  template <int dim>
  class Vtu : public feib::OutputWriter<dim>
  {
  public:
    using Snapshot = typename feib::OutputWriter<dim>::Snapshot;

    explicit Vtu(const feib::Parameters &parameters)
      : steps(parameters.integer("interval"))
    {}

    unsigned int
    interval() const override
    {
      return steps;
    }

    void
    write(const Snapshot &snapshot) override
    {
      agree(write_fluid(snapshot), snapshot.space.communicator());
      for (const feib::ImmersedStructure<dim> &structure : snapshot.structures)
        agree(write_structure(snapshot, *structure.model), snapshot.space.communicator());
    }

  private:
    std::string
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
      out.add_data_vector(level, "level", DataOut<dim>::type_cell_data);
      out.add_data_vector(subdomain, "subdomain", DataOut<dim>::type_cell_data);
      // Lagrange cells of degree 2 hold Q2 fields as they are.
      out.build_patches(space.mapping(), 2, DataOut<dim>::curved_inner_cells);
      out.set_flags(flags(snapshot, true));

      const std::string name = "fluid_" + Utilities::int_to_string(snapshot.step, 6);
      const auto piece       = [&name](const unsigned int rank) {
        return name + "." + std::to_string(rank) + ".vtu";
      };
      std::ostringstream text;
      out.write_vtu(text);
      const unsigned int rank = Utilities::MPI::this_mpi_process(space.communicator());
      std::string trouble     = write_file(snapshot.directory + "/" + piece(rank), text.str());
      if (rank == 0 && trouble.empty())
        {
          std::vector<std::string> pieces;
          for (unsigned int r = 0; r < Utilities::MPI::n_mpi_processes(space.communicator()); ++r)
            pieces.push_back(piece(r));
          std::ostringstream record;
          out.write_pvtu_record(record, pieces);
          trouble = write_file(snapshot.directory + "/" + name + ".pvtu", record.str());
          if (trouble.empty())
            trouble = add_to_series(snapshot, "fluid", name + ".pvtu");
        }
      return trouble;
    }

    std::string
    write_structure(const Snapshot &snapshot, const feib::StructureModel<dim> &model)
    {
      const std::vector<double> energy_density = model.energy_density(model.positions);
      if (Utilities::MPI::this_mpi_process(snapshot.space.communicator()) != 0)
        return "";

      const std::string name =
        model.name() + "_" + Utilities::int_to_string(snapshot.step, 6) + ".vtu";
      const std::string text    = model.mesh().structure_dim() == dim
                                    ? structure_text<dim>(snapshot, model, energy_density)
                                    : structure_text<dim - 1>(snapshot, model, energy_density);
      const std::string trouble = write_file(snapshot.directory + "/" + name, text);
      return trouble.empty() ? add_to_series(snapshot, model.name(), name) : trouble;
    }

    template <int structure_dim>
    static std::string
    structure_text(const Snapshot &snapshot,
                   const feib::StructureModel<dim> &model,
                   const std::vector<double> &energy_density)
    {
      StructureOutput<structure_dim, dim> out(model.mesh(), model.positions, energy_density);
      out.set_flags(flags(snapshot, false));
      std::ostringstream text;
      out.write_vtu(text);
      return text.str();
    }

    /// Rewrites the time series of a name with one more file in it. A reader never sees half a
    /// file.
    std::string
    add_to_series(const Snapshot &snapshot, const std::string &name, const std::string &file)
    {
      auto &entries = series[name];
      entries.emplace_back(snapshot.time, file);
      std::ostringstream text;
      DataOutBase::write_pvd_record(text, entries);
      const std::string final_name     = snapshot.directory + "/" + name + ".pvd";
      const std::string temporary_name = final_name + ".new";
      const std::string trouble        = write_file(temporary_name, text.str());
      if (!trouble.empty())
        return trouble;
      if (std::rename(temporary_name.c_str(), final_name.c_str()) != 0)
        return "cannot write " + final_name + ": " + std::strerror(errno);
      return "";
    }

    static DataOutBase::VtkFlags
    flags(const Snapshot &snapshot, const bool higher_order)
    {
      DataOutBase::VtkFlags flags(snapshot.time,
                                  snapshot.step,
                                  false,
                                  DataOutBase::VtkFlags::best_speed);
      flags.write_higher_order_cells = higher_order;
      return flags;
    }

    const unsigned int steps;
    std::map<std::string, std::vector<std::pair<double, std::string>>> series;
  };
} // namespace


FEIB_PLUGIN("vtu", "1.0", registry)
{
  registry.add<feib::OutputWriter, Vtu>("vtu", vtu_schema);
}
