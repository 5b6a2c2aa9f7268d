// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/appended_file.h>
#include <feib/failure.h>
#include <feib/output_writer.h>
#include <feib/plugin.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "probe_schema.h"

namespace
{
  const char *const axes[] = {"x", "y", "z"};

  template <int dim>
  class Probe : public feib::OutputWriter<dim>
  {
  public:
    using Snapshot = typename feib::OutputWriter<dim>::Snapshot;

    explicit Probe(const feib::Parameters &parameters);

    unsigned int
    interval() const override
    {
      return steps;
    }

    void check(const feib::CheckContext<dim> &context) override;

    void write(const Snapshot &snapshot) override;

    void
    archive(feib::Archive &archive) override
    {
      archive("file", file);
    }

    void
    reopen(const std::string &directory) override
    {
      feib::agree(MPI_COMM_WORLD, [&] {
        if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
          file.reopen(directory + "/" + file_name());
      });
    }

  private:
    /// Velocity components and pressure at each point, on all ranks.
    std::vector<double> values(const feib::EulerianSpace<dim> &space) const;

    /// Finds the structure and the elements that have the places.
    void find_places(const feib::CheckContext<dim> &context);

    void write_rows(const Snapshot &snapshot, const std::vector<double> &values);

    std::string
    file_name() const
    {
      return "probe_" + name + ".csv";
    }

    const std::string name;
    const unsigned int steps;
    std::vector<std::pair<std::string, dealii::Point<dim>>> given; // with their places in the case
    std::vector<dealii::Point<dim>> points;
    std::string structure;                  // that the points ride on; empty: none
    std::vector<dealii::Point<dim>> places; // reference places on it
    std::string pointer;                    // of their block
    unsigned int index = 0;                 // of the structure
    feib::LagrangianPoints material_points;
    feib::AppendedFile file;
  };


  template <int dim>
  dealii::Point<dim>
  read_point(const feib::Parameters &parameters, const std::string &key)
  {
    const std::vector<double> numbers = parameters.numbers(key);
    if (numbers.size() != dim)
      parameters.fail(key,
                      "found " + std::to_string(numbers.size()) +
                        " coordinates, the dimension is " + std::to_string(dim));
    dealii::Point<dim> point;
    std::copy(numbers.begin(), numbers.end(), point.begin_raw());
    return point;
  }


  template <int dim>
  Probe<dim>::Probe(const feib::Parameters &parameters)
    : name(parameters.word("name"))
    , steps(parameters.integer("interval"))
  {
    const auto [kind, place] = parameters.child("at").choice();
    if (kind == "structure")
      {
        structure = place.string("name");
        pointer   = place.pointer();
        for (unsigned int i = 0; place.has("places/" + std::to_string(i)); ++i)
          places.push_back(read_point<dim>(place, "places/" + std::to_string(i)));
      }
    else if (kind == "points")
      for (unsigned int i = 0; place.has("places/" + std::to_string(i)); ++i)
        {
          points.push_back(read_point<dim>(place, "places/" + std::to_string(i)));
          given.emplace_back(place.pointer() + "/places/" + std::to_string(i), points.back());
        }
    else
      {
        const auto from = read_point<dim>(place, "from"), to = read_point<dim>(place, "to");
        given                = {{place.pointer() + "/from", from}, {place.pointer() + "/to", to}};
        const unsigned int n = place.integer("points");
        // A coordinate that both ends share stays what it is.
        for (unsigned int i = 0; i + 1 < n; ++i)
          points.push_back(from + double(i) / (n - 1) * (to - from));
        points.push_back(to);
      }
  }


  template <int dim>
  void
  Probe<dim>::check(const feib::CheckContext<dim> &context)
  {
    if (!structure.empty())
      find_places(context);
    feib::Issues issues;
    for (const auto &[pointer, point] : given)
      if (!context.space.forest().inside(point))
        {
          std::ostringstream message;
          message << "is at (" << point << "), the box goes from (" << context.space.domain().lower
                  << ") to (" << context.space.domain().upper << ')';
          issues.push_back({pointer, message.str()});
        }
    if (!issues.empty())
      throw feib::Error(issues);
  }


  /// The values of an element's shape functions at a reference place.
  template <int dim>
  std::vector<double>
  shape_values(const typename feib::LagrangianMesh<dim>::Element &element,
               const unsigned int structure_dim,
               const dealii::Point<dim> &place)
  {
    const dealii::Tensor<1, dim> distance = place - element.centroid;
    std::vector<double> values(structure_dim + 1, 1. / (structure_dim + 1));
    for (unsigned int k = 0; k <= structure_dim; ++k)
      for (unsigned int l = 0; l < structure_dim; ++l)
        values[k] += element.shape_gradients[k][l] * (distance * element.frame[l]);
    return values;
  }


  template <int dim>
  void
  Probe<dim>::find_places(const feib::CheckContext<dim> &context)
  {
    std::string names;
    for (index = 0; index < context.structures.size(); ++index)
      {
        const std::string &other = context.structures[index].model->name();
        if (other == structure)
          break;
        names += (names.empty() ? "" : ", ") + other;
      }
    if (index == context.structures.size())
      throw feib::Error(pointer + "/name",
                        "found \"" + structure + "\"; the structures are " +
                          (names.empty() ? "none" : names));
    const feib::LagrangianMesh<dim> &mesh = context.structures[index].model->mesh();
    material_points                       = {mesh.structure_dim() + 1, {}, {}};
    for (unsigned int p = 0; p < places.size(); ++p)
      {
        // Of the elements that have the place, or nearly, the nearest: a surface is not flat.
        const typename feib::LagrangianMesh<dim>::Element *best = nullptr;
        std::vector<double> weights;
        for (const auto &element : mesh.elements())
          {
            const std::vector<double> values =
              shape_values<dim>(element, mesh.structure_dim(), places[p]);
            if (*std::min_element(values.begin(), values.end()) < -.01 ||
                places[p].distance(element.centroid) > element.diameter)
              continue;
            if (!best || places[p].distance(element.centroid) < places[p].distance(best->centroid))
              {
                best    = &element;
                weights = values;
              }
          }
        if (!best)
          {
            std::ostringstream message;
            message << "is (" << places[p] << "), where the structure \"" << structure
                    << "\" has no reference place";
            throw feib::Error(pointer + "/places/" + std::to_string(p), message.str());
          }
        for (unsigned int k = 0; k <= mesh.structure_dim(); ++k)
          {
            material_points.node.push_back(best->nodes[k]);
            material_points.weight.push_back(weights[k]);
          }
      }
  }


  template <int dim>
  void
  Probe<dim>::write(const Snapshot &snapshot)
  {
    if (!structure.empty())
      {
        const auto x = material_points.positions(snapshot.structures[index].model->positions);
        points.assign(x.begin(), x.end());
      }
    const std::vector<double> found = values(snapshot.space);
    feib::agree(snapshot.space.communicator(), [&] {
      if (dealii::Utilities::MPI::this_mpi_process(snapshot.space.communicator()) == 0)
        write_rows(snapshot, found);
    });
  }


  template <int dim>
  std::vector<double>
  Probe<dim>::values(const feib::EulerianSpace<dim> &space) const
  {
    using Space                   = feib::EulerianSpace<dim>;
    feib::VelocityVector velocity = space.velocity;
    const auto &pressure_fe       = space.pressure_handler().get_fe();
    std::vector<double> result((dim + 1) * points.size());
    double shapes[Space::n_nodes];
    velocity.update_ghost_values();
    for (unsigned int p = 0; p < points.size(); ++p)
      {
        // One cell of one rank has the point: the sum over ranks is its value.
        dealii::Point<dim> unit;
        const unsigned int cell = space.forest().locate(points[p], unit);
        if (cell == feib::CartesianForest<dim>::not_here)
          continue;
        double *const found = &result[(dim + 1) * p];
        Space::shape_values(unit, shapes);
        const unsigned int *const dofs = space.velocity_dofs(cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < Space::n_nodes; ++i)
            found[a] += shapes[i] * velocity.local_element(dofs[a * Space::n_nodes + i]);
        const unsigned int *const pressure_dofs = space.pressure_dofs(cell);
        for (unsigned int i = 0; i < Space::n_pressure; ++i)
          found[dim] +=
            pressure_fe.shape_value(i, unit) * space.pressure.local_element(pressure_dofs[i]);
      }
    dealii::Utilities::MPI::sum(result, space.communicator(), result);
    return result;
  }


  template <int dim>
  void
  Probe<dim>::write_rows(const Snapshot &snapshot, const std::vector<double> &values)
  {
    std::ostringstream text;
    text << std::setprecision(17);
    if (!file.is_open())
      {
        text << "step,time,point";
        for (unsigned int a = 0; a < dim; ++a)
          text << ',' << axes[a];
        for (unsigned int a = 0; a < dim; ++a)
          text << ",velocity_" << axes[a];
        text << ",pressure\n";
        file.open(snapshot.directory + "/" + file_name(), "");
      }
    for (unsigned int p = 0; p < points.size(); ++p)
      {
        text << snapshot.step << ',' << snapshot.time << ',' << p;
        for (unsigned int a = 0; a < dim; ++a)
          text << ',' << points[p][a];
        for (unsigned int i = 0; i <= dim; ++i)
          text << ',' << values[(dim + 1) * p + i];
        text << '\n';
      }
    file.append(text.str());
  }
} // namespace


FEIB_PLUGIN("probe", "1.0", registry)
{
  registry.add<feib::OutputWriter, Probe>("probe", probe_schema);
}
