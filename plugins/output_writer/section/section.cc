// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/message.h>
#include <feib/plugin.h>
#include <feib/table_writer.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>

#include <algorithm>

#include "section_schema.h"

namespace
{
  const char *const axes[] = {"x", "y", "z"};

  /// See the schema.
  template <int dim>
  class Section : public feib::TableWriter<dim>
  {
  public:
    using Snapshot = typename feib::TableWriter<dim>::Snapshot;
    using Space    = feib::EulerianSpace<dim>;

    explicit Section(const feib::Parameters &parameters);

    void check(const feib::CheckContext<dim> &context) override;

    void write(const Snapshot &snapshot) override;

  private:
    /// Integrals of 1, velocity components and pressure, on all ranks.
    std::vector<double> integrals(const Space &space) const;

    /// What the section has in common with a cell, its edges along all directions but the normal;
    /// false: nothing.
    bool piece(const Space &space,
               const typename Space::Cell &cell,
               dealii::Point<dim> &from,
               dealii::Point<dim> &to) const;

    const std::string pointer;
    unsigned int normal = 0;
    const double at;
    std::vector<double> lower, upper; // empty: those of the box
  };


  template <int dim>
  Section<dim>::Section(const feib::Parameters &parameters)
    : feib::TableWriter<dim>("section_" + parameters.word("name") + ".csv",
                             parameters.integer("interval"))
    , pointer(parameters.pointer())
    , at(parameters.number("at"))
  {
    const std::string direction = parameters.string("normal");
    while (direction != axes[normal])
      ++normal;
    if (normal >= dim)
      parameters.fail("normal",
                      "found \"" + direction + "\", the dimension is " + std::to_string(dim));
    for (const auto &[key, corner] : {std::pair{"lower", &lower}, std::pair{"upper", &upper}})
      if (parameters.has(key))
        {
          *corner = parameters.numbers(key);
          if (corner->size() != dim)
            parameters.fail(key,
                            "found " + std::to_string(corner->size()) +
                              " coordinates, the dimension is " + std::to_string(dim));
        }
  }


  template <int dim>
  void
  Section<dim>::check(const feib::CheckContext<dim> &context)
  {
    const feib::Domain<dim> &box = context.space.domain();
    feib::Issues issues;
    if (!(at >= box.lower[normal] && at <= box.upper[normal]))
      issues.push_back({pointer + "/at",
                        std::string("is ") + axes[normal] + " = " + feib::readable(at) +
                          ", the box goes from " + feib::readable(box.lower[normal]) + " to " +
                          feib::readable(box.upper[normal])});
    for (unsigned int a = 0; a < dim; ++a)
      if (a != normal)
        {
          const double from = lower.empty() ? box.lower[a] : std::max(lower[a], box.lower[a]),
                       to   = upper.empty() ? box.upper[a] : std::min(upper[a], box.upper[a]);
          if (!(from < to))
            issues.push_back({pointer + (upper.empty() ? "/lower/" : "/upper/") + std::to_string(a),
                              std::string("leaves nothing of the box along ") + axes[a] +
                                ": from " + feib::readable(from) + " to " + feib::readable(to)});
        }
    if (!issues.empty())
      throw feib::Error(issues);
  }


  template <int dim>
  bool
  Section<dim>::piece(const Space &space,
                      const typename Space::Cell &cell,
                      dealii::Point<dim> &from,
                      dealii::Point<dim> &to) const
  {
    const feib::Domain<dim> &box = space.domain();
    from                         = cell.lower;
    to                           = cell.lower + cell.size;
    // Where cells meet, those beyond have the section; at the end of the box, the last ones.
    const double near = feib::round_off(box.lower[normal], box.upper[normal]);
    const bool last   = to[normal] >= box.upper[normal] - near;
    if (at < from[normal] - near || (at >= to[normal] - near && !(last && at <= to[normal] + near)))
      return false;
    from[normal] = to[normal] = at;
    for (unsigned int a = 0; a < dim; ++a)
      if (a != normal)
        {
          if (!lower.empty())
            from[a] = std::max(from[a], lower[a]);
          if (!upper.empty())
            to[a] = std::min(to[a], upper[a]);
          if (!(from[a] < to[a]))
            return false;
        }
    return true;
  }


  template <int dim>
  std::vector<double>
  Section<dim>::integrals(const Space &space) const
  {
    const dealii::QGauss<dim - 1> gauss(3);
    const auto &pressure_fe = space.pressure_handler().get_fe();
    std::vector<double> result(dim + 2);
    double shapes[Space::n_nodes];
    dealii::Point<dim> from, to;
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      if (const auto &cell = space.cells()[c]; piece(space, cell, from, to))
        for (unsigned int q = 0; q < gauss.size(); ++q)
          {
            double weight = gauss.weight(q);
            dealii::Point<dim> unit;
            for (unsigned int a = 0, k = 0; a < dim; ++a)
              {
                double x = at;
                if (a != normal)
                  {
                    x = from[a] + (to[a] - from[a]) * gauss.point(q)[k++];
                    weight *= to[a] - from[a];
                  }
                unit[a] = std::clamp((x - cell.lower[a]) / cell.size[a], 0., 1.);
              }
            result[0] += weight;
            Space::shape_values(unit, shapes);
            for (unsigned int a = 0; a < dim; ++a)
              for (unsigned int i = 0; i < Space::n_nodes; ++i)
                result[1 + a] +=
                  weight * shapes[i] *
                  space.velocity.local_element(space.velocity_dofs(c)[a * Space::n_nodes + i]);
            for (unsigned int i = 0; i < Space::n_pressure; ++i)
              result[1 + dim] += weight * pressure_fe.shape_value(i, unit) *
                                 space.pressure.local_element(space.pressure_dofs(c)[i]);
          }
    dealii::Utilities::MPI::sum(result, space.communicator(), result);
    return result;
  }


  template <int dim>
  void
  Section<dim>::write(const Snapshot &snapshot)
  {
    snapshot.space.velocity.update_ghost_values();
    const std::vector<double> sums   = integrals(snapshot.space);
    std::vector<std::string> columns = {"step", "time", "area", "flux"};
    for (unsigned int a = 0; a < dim; ++a)
      columns.push_back(std::string("velocity_") + axes[a]);
    columns.push_back("pressure");
    std::vector<double> row = {double(snapshot.step), snapshot.time, sums[0], sums[1 + normal]};
    for (unsigned int i = 1; i < sums.size(); ++i)
      row.push_back(sums[i] / sums[0]);
    this->append(snapshot, columns, {row});
  }
} // namespace


FEIB_PLUGIN("section", "1.0", registry)
{
  registry.add<feib::OutputWriter, Section>("section", section_schema);
}
