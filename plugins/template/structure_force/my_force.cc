#include <feib/plugin.h>
#include <feib/registry.h>
#include <feib/structure_force/selection.h>
#include <feib/structure_force/stencil_force.h>

#include "my_force_schema.h"

namespace my_force_plugin
{
  /// A soft floor: nodes that are below a height are pushed up, E = sum_i w_i k/2 max(0, height -
  /// y_i)^2, y the last coordinate and w_i the reference measure that node i stands for. Groups of
  /// one node; force and tangent follow from the energy.
  template <int dim>
  class MyForce : public feib::StencilForce<MyForce<dim>, 1, dim>
  {
  public:
    using Body      = typename feib::StructureForce<dim>::Body;
    using Stiffness = typename feib::StructureForce<dim>::Stiffness;

    explicit MyForce(const feib::Parameters &parameters)
      : parameters(parameters)
      , k(parameters.number("stiffness"))
      , height(parameters.number("height"))
    {}

    void
    attach(const Body &body) override
    {
      this->communicator = body.mesh.communicator();
      measures           = feib::Selection<dim>(parameters, body.mesh).measures();
      for (unsigned int i = 0; i < measures.size(); ++i)
        this->stencils.push_back({i});
    }

    template <typename Number>
    Number
    stencil_energy(const std::array<std::array<Number, dim>, 1> &X,
                   const feib::PointBatch &nodes) const
    {
      const Number depth = positive_part(height - X[0][dim - 1]);
      return depth * depth * (.5 * k * nodes(measures));
    }

    /// For the forecast of the step of explicit schemes.
    Stiffness
    stiffness(const feib::Positions<dim> &) const override
    {
      return {k, 0.};
    }

  private:
    const feib::Parameters parameters;
    const double k, height;
    std::vector<double> measures;
  };
} // namespace my_force_plugin

FEIB_PLUGIN("my_force", "1.0", registry)
{
  registry.add<feib::StructureForce, my_force_plugin::MyForce>("my_force", my_force_schema);
}
