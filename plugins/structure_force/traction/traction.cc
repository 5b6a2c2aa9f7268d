// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/expression.h>
#include <feib/plugin.h>
#include <feib/registry.h>
#include <feib/structure_force.h>
#include <feib/structure_force/selection.h>
#include <feib/structure_force/try_times.h>

#include "traction_schema.h"

#include <memory>

namespace feib
{
  /// A dead load f(s, t) per reference measure, E = - sum_i w_i f(s_i, t) . (X_i - X_i(0)) with w_i
  /// the node's share of the selected elements or faces; and a pressure on the present faces, which
  /// in general comes from no energy: the nodes of a face get - p |face| n / (number of nodes)
  /// each.
  template <int dim>
  class Traction : public StructureForce<dim>
  {
  public:
    using Body = typename StructureForce<dim>::Body;

    explicit Traction(const Parameters &parameters)
      : parameters(parameters)
    {
      if (parameters.has("force"))
        force = parse_expressions<dim>(parameters, "force", dim, Variables::reference_time);
      if (parameters.has("pressure"))
        pressure = parse_expressions<dim>(parameters, "pressure", 1, Variables::reference_time);
      if (!force && !pressure)
        parameters.fail("", "has neither \"force\" nor \"pressure\"");
    }

    void
    attach(const Body &body) override
    {
      nodes = body.mesh.nodes();
      start = body.positions;
      faces = Selection<dim>(parameters, body.mesh).parts();
      if (faces.empty())
        parameters.fail("on", "selects no element or face with all its nodes");
      // Both loads act on whole faces: a node at the rim has its share of these, and no more.
      measures.assign(nodes.size(), 0.);
      for (const Part &face : faces)
        for (unsigned int j = 0; j < face.n_nodes; ++j)
          measures[face.nodes[j]] += face.measure / face.n_nodes;
      if (pressure && faces.front().n_nodes != dim)
        parameters.fail("pressure",
                        "acts on the elements of a curve or surface, or on the boundary faces of "
                        "a body (\"on\": {\"boundary\": true})");
      try_times<dim>([this](const double time) { take(time); },
                     body,
                     {force.get(), pressure.get()});
    }

    void
    set_moment(const double time, double) override
    {
      take_at<dim>([this](const double t) { take(t); }, time, {force.get(), pressure.get()});
    }

    double
    energy(const Positions<dim> &X) const override
    {
      return X.sum([&](const unsigned int i) { return -(dead[i] * (X[i] - start[i])); });
    }

    void
    load(const Positions<dim> &, NodalField<dim> &load) const override
    {
      for (unsigned int i = 0; i < load.size(); ++i)
        load[i] += dead[i];
    }

    bool
    linear() const override
    {
      return true;
    }

    bool
    external() const override
    {
      return pressure != nullptr;
    }

    /// Every rank has all faces.
    void
    external_load(const Positions<dim> &X, NodalField<dim> &load) const override
    {
      for (const auto &face : faces)
        {
          const dealii::Tensor<1, dim> normal = area(face, X) / dim;
          for (unsigned int j = 0; j < dim; ++j)
            load[face.nodes[j]] -= pressures[face.nodes[j]] * normal;
        }
    }

  private:
    /// The values of the expressions at a time.
    void
    take(const double time)
    {
      dead.assign(nodes.size(), {});
      pressures.assign(nodes.size(), 0.);
      for (Expressions<dim> *function : {force.get(), pressure.get()})
        if (function)
          function->set_time(time);
      for (unsigned int i = 0; i < nodes.size(); ++i)
        if (measures[i] > 0)
          {
            if (force)
              for (unsigned int a = 0; a < dim; ++a)
                dead[i][a] = measures[i] * force->value(nodes[i], a);
            if (pressure)
              pressures[i] = pressure->value(nodes[i]);
          }
    }

    using Part = typename Selection<dim>::Part;

    /// The normal of a face times its measure.
    static dealii::Tensor<1, dim>
    area(const Part &face, const Positions<dim> &X)
    {
      const dealii::Tensor<1, dim> first = X[face.nodes[1]] - X[face.nodes[0]];
      if constexpr (dim == 2)
        return cross_product_2d(first);
      else
        return cross_product_3d(first, X[face.nodes[2]] - X[face.nodes[0]]) / 2;
    }

    const Parameters parameters;
    std::unique_ptr<Expressions<dim>> force, pressure; // null: none
    std::vector<dealii::Point<dim>> nodes;             // reference places
    Positions<dim> start;
    std::vector<double> measures;
    std::vector<Part> faces;
    std::vector<dealii::Tensor<1, dim>> dead; // at the moment
    std::vector<double> pressures;
  };
} // namespace feib

FEIB_PLUGIN("traction", "1.0", registry)
{
  registry.add<feib::StructureForce, feib::Traction>("traction", traction_schema);
}
