// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_immersed_structure_h
#define feib_immersed_structure_h

#include <feib/coupling_operator.h>
#include <feib/structure_model.h>

#include <memory>

namespace feib
{
  /// A structure and what ties it to the fluid.
  template <int dim>
  struct ImmersedStructure
  {
    std::unique_ptr<StructureModel<dim>> model;
    LagrangianPoints nodes;                        // the points that move
    std::unique_ptr<CouplingOperator<dim>> motion; // J at the nodes
    std::unique_ptr<CouplingOperator<dim>>
      loading; // J at the load points; null when those are the nodes

    /// The operator whose transpose spreads the load.
    CouplingOperator<dim> &
    spreading() const
    {
      return loading ? *loading : *motion;
    }

    /// Fixes the geometry of both operators at X.
    void
    set_geometry(const EulerianSpace<dim> &space, const Positions<dim> &X) const
    {
      motion->set_geometry(space, model->mesh(), X, nodes);
      if (loading)
        loading->set_geometry(space, model->mesh(), X, model->load_points());
    }
  };
} // namespace feib

#endif
