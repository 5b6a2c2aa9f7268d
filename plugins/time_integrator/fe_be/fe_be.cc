// SPDX-License-Identifier: LGPL-2.1-or-later
#include "fe_be_schema.h"

#include <feib/plugin.h>
#include <feib/time_integrator.h>

#include <algorithm>
#include <cmath>

namespace feib
{
  /// Steps 1-3 of the FE/BE scheme, see the README.
  template <int dim>
  class ForwardEulerBackwardEuler : public TimeIntegrator<dim>
  {
  public:
    using Base   = TimeIntegrator<dim>;
    using System = typename Base::System;
    using Report = typename Base::Report;

    explicit ForwardEulerBackwardEuler(const Parameters &)
    {}

    Report step(System &system, double time, double dt) override;

    std::vector<std::pair<std::string, double>> diagnostics(const System &system,
                                                            double dt) const override;
  };


  template <int dim>
  typename ForwardEulerBackwardEuler<dim>::Report
  ForwardEulerBackwardEuler<dim>::step(System &system, const double time, const double dt)
  {
    EulerianSpace<dim> &space = system.space;
    VelocityVector load       = space.make_velocity();
    NodalField<dim> values;
    for (ImmersedStructure<dim> &structure : system.structures)
      {
        {
          const Timers::Section section(system.timers, "structure");
          structure.model->load(structure.model->positions, values);
        }
        const Timers::Section section(system.timers, "coupling");
        structure.set_geometry(space, structure.model->positions);
        structure.spreading().spread(space, values, load);
      }

    Report report;
    {
      const Timers::Section section(system.timers, "fluid");
      report = system.fluid.advance(space, {time + dt, dt, load});
    }

    const Timers::Section section(system.timers, "coupling");
    for (ImmersedStructure<dim> &structure : system.structures)
      {
        structure.motion->interpolate(space, space.velocity, values);
        for (unsigned int i = 0; i < values.size(); ++i)
          structure.model->positions[i] += dt * values[i];
      }
    return report;
  }


  template <int dim>
  std::vector<std::pair<std::string, double>>
  ForwardEulerBackwardEuler<dim>::diagnostics(const System &system, const double dt) const
  {
    // eta = kappa_max h_s^{m-2} dt L^n / h_x^{d-1}, the -mu_a of the energy estimate with C = 1.
    std::vector<std::pair<std::string, double>> result;
    const double h_x = system.space.smallest_edge();
    for (const ImmersedStructure<dim> &structure : system.structures)
      {
        const StructureModel<dim> &model = *structure.model;
        const LagrangianMesh<dim> &mesh  = model.mesh();
        const int m                      = mesh.structure_dim();
        double L                         = 0;
        for (const auto &element : mesh.elements())
          for (int j = 0; j <= m; ++j)
            for (int k = 0; k < j; ++k)
              L = std::max(
                L, model.positions[element.nodes[j]].distance(model.positions[element.nodes[k]]));
        result.emplace_back("eta_" + model.name(),
                            model.stiffness(model.positions) * std::pow(mesh.diameter(), m - 2) *
                              dt * L / std::pow(h_x, dim - 1));
      }
    return result;
  }
} // namespace feib


FEIB_PLUGIN("fe_be", "1.0", registry)
{
  registry.add<feib::TimeIntegrator, feib::ForwardEulerBackwardEuler>("fe_be", fe_be_schema);
}
