// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/appended_file.h>
#include <feib/failure.h>
#include <feib/output_writer.h>
#include <feib/plugin.h>

#include <deal.II/base/mpi.h>

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
    if (kind == "points")
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


  template <int dim>
  void
  Probe<dim>::write(const Snapshot &snapshot)
  {
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
