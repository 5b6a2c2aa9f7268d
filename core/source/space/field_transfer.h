// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_field_transfer_h
#define feib_source_field_transfer_h

#include <feib/eulerian_space.h>

#include <deal.II/distributed/solution_transfer.h>

#include <vector>

namespace feib
{
  /// Carries the fields of a space, but for older_velocity, to the mesh that follows: made when the
  /// flags of the old one are set.
  template <int dim>
  class FieldTransfer
  {
  public:
    explicit FieldTransfer(EulerianSpace<dim> &space);

    /// Once the new mesh has its unknowns. Velocities do not keep constraints yet.
    void finish();

  private:
    using Transfer = dealii::parallel::distributed::SolutionTransfer<dim, VelocityVector>;

    EulerianSpace<dim> &space;
    Transfer velocity_transfer, pressure_transfer;
    std::vector<PressureVector *> pressures;
  };
} // namespace feib

#endif
