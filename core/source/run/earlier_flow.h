// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_earlier_flow_h
#define feib_source_earlier_flow_h

#include <feib/eulerian_space.h>

namespace feib
{
  /// The flow that an earlier run left in its newest checkpoint, on a mesh of its own that every
  /// rank holds.
  template <int dim>
  class EarlierFlow
  {
  public:
    /// From the block "initial_state" of a case whose box is @p box. Throws Error when there is no
    /// such run, or its box does not hold this one. Collective.
    EarlierFlow(const Parameters &parameters, const Domain<dim> &box);

    /// Sets the velocity of the space at its nodes, without constraints. Collective. Throws
    /// RunFailure when the checkpoint cannot be read.
    void interpolate(EulerianSpace<dim> &space) const;

  private:
    std::string folder; // of the checkpoint
    dealii::Point<dim> lower, upper;
    std::array<unsigned int, dim> cells;
  };
} // namespace feib

#endif
