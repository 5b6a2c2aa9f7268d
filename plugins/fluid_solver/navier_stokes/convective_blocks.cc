// SPDX-License-Identifier: LGPL-2.1-or-later
#include "convective_blocks.h"

#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>

namespace feib
{
  namespace
  {
    /// The velocity's cycle as a preconditioner.
    template <int dim>
    struct Cycle
    {
      StokesMultigrid<dim> &multigrid;

      void
      vmult(VelocityVector &dst, const VelocityVector &src) const
      {
        multigrid.solve_velocity(src, dst);
      }
    };
  } // namespace


  template <int dim>
  void
  ConvectiveBlocks<dim>::vmult(VelocityVector &dst, const VelocityVector &src) const
  {
    VelocityVector v = equations.space.make_velocity();
    v.copy_locally_owned_data_from(src);
    equations.space.distribute(v, true);
    dst = 0.;
    equations.operators.add_velocity_form(equations.rate, 1., v, dst);
    equations.add_convection(1., v, dst);
    dst.compress(dealii::VectorOperation::add);
    equations.space.condense(dst);
  }


  template <int dim>
  void
  ConvectiveBlocks<dim>::apply_gradient(const PressureVector &p, VelocityVector &r) const
  {
    r = 0.;
    equations.operators.add_gradient(p, r);
    r.compress(dealii::VectorOperation::add);
    equations.space.condense(r);
  }


  template <int dim>
  void
  ConvectiveBlocks<dim>::solve(const VelocityVector &f,
                               const PressureVector &g,
                               VelocityVector &u,
                               PressureVector &p)
  {
    const EulerianSpace<dim> &space = equations.space;
    VelocityVector v = space.make_velocity(), w = space.make_velocity();
    PressureVector q = space.make_pressure();
    multigrid.solve_pressure(g, p);
    apply_gradient(p, v);
    multigrid.divide_by_mass(v);
    vmult(w, v);
    multigrid.divide_by_mass(w);
    space.distribute(w, true);
    equations.operators.add_divergence(w, q);
    q.compress(dealii::VectorOperation::add);
    multigrid.solve_pressure(q, p);
    p *= -1.;

    apply_gradient(p, v);
    v += f;
    constexpr unsigned int most = 30;
    dealii::IterationNumberControl control(most, .1 * v.l2_norm(), false, false);
    dealii::SolverFGMRES<VelocityVector> gmres(
      control, dealii::SolverFGMRES<VelocityVector>::AdditionalData(most));
    u = 0.;
    gmres.solve(*this, u, v, Cycle<dim>{multigrid});
  }


  template class ConvectiveBlocks<2>;
  template class ConvectiveBlocks<3>;
} // namespace feib
