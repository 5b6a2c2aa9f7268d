// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/table_writer.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "probe_schema.h"

namespace
{
  const char *const axes[] = {"x", "y", "z"};

  template <int dim>
  class Probe : public feib::TableWriter<dim>
  {
  public:
    using Snapshot = typename feib::TableWriter<dim>::Snapshot;

    explicit Probe(const feib::Parameters &parameters);

    void check(const feib::CheckContext<dim> &context) override;

    void write(const Snapshot &snapshot) override;

  private:
    /// Velocity components and pressure at each point, on all ranks.
    std::vector<double> values(const feib::EulerianSpace<dim> &space) const;

    /// Finds the structure and the elements that have the places.
    void find_places(const feib::CheckContext<dim> &context);

    std::vector<std::pair<std::string, dealii::Point<dim>>> given; // with their places in the case
    std::vector<dealii::Point<dim>> points;
    std::string structure;                  // that the points ride on; empty: none
    std::vector<dealii::Point<dim>> places; // reference places on it
    std::string pointer;                    // of their block
    unsigned int index = 0;                 // of the structure
    feib::LagrangianPoints material_points;
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
    : feib::TableWriter<dim>("probe_" + parameters.word("name") + ".csv",
                             parameters.integer("interval"))
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
    const std::vector<unsigned int> parts = mesh.parts();
    material_points                       = {mesh.structure_dim() + 1, {}, {}};
    for (unsigned int p = 0; p < places.size(); ++p)
      {
        // Of the elements that have the place, or nearly, the nearest: a surface is not flat.
        const typename feib::LagrangianMesh<dim>::Element *best = nullptr;
        std::vector<double> weights;
        std::set<unsigned int> parts_there;
        for (unsigned int e = 0; e < mesh.n_elements(); ++e)
          {
            const auto &element = mesh.elements()[e];
            const std::vector<double> values =
              shape_values<dim>(element, mesh.structure_dim(), places[p]);
            if (*std::min_element(values.begin(), values.end()) < -.01 ||
                places[p].distance(element.centroid) > element.diameter)
              continue;
            parts_there.insert(parts[e]);
            if (!best || places[p].distance(element.centroid) < places[p].distance(best->centroid))
              {
                best    = &element;
                weights = values;
              }
          }
        if (parts_there.size() != 1)
          {
            std::ostringstream message;
            message << "is (" << places[p] << "), where "
                    << (best ? "several parts of the structure \"" : "the structure \"")
                    << structure
                    << (best
                          ? "\" have a reference place: they can be told apart when their meshes "
                            "lie in different places"
                          : "\" has no reference place");
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
    std::vector<std::string> columns = {"step", "time", "point"};
    for (const std::string head : {"", "velocity_"})
      for (unsigned int a = 0; a < dim; ++a)
        columns.push_back(head + axes[a]);
    columns.push_back("pressure");

    const std::vector<double> found = values(snapshot.space);
    std::vector<std::vector<double>> rows;
    for (unsigned int p = 0; p < points.size(); ++p)
      {
        rows.push_back({double(snapshot.step), snapshot.time, double(p)});
        rows.back().insert(rows.back().end(), points[p].begin_raw(), points[p].end_raw());
        const auto first = found.begin() + (dim + 1) * p;
        rows.back().insert(rows.back().end(), first, first + dim + 1);
      }
    this->append(snapshot, columns, rows);
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
} // namespace


FEIB_PLUGIN("probe", "1.0", registry)
{
  registry.add<feib::OutputWriter, Probe>("probe", probe_schema);
}
