// SPDX-License-Identifier: LGPL-2.1-or-later
#include "structure_step.h"

#include <feib/cross_product.h>

#include <cmath>

namespace feib
{
  namespace
  {
    template <int dim>
    Positions<dim>
    displaced(Positions<dim> X, const double factor, const NodalField<dim> &U)
    {
      for (unsigned int i = 0; i < U.size(); ++i)
        X[i] += factor * U[i];
      return X;
    }
  } // namespace


  template <int dim>
  StructureStep<dim>::StructureStep(const EulerianSpace<dim> &space,
                                    const ImmersedStructure<dim> &structure,
                                    const Motion &motion,
                                    const double time,
                                    const double dt,
                                    const bool midpoint)
    : space(space)
    , structure(structure)
    , model(*structure.model)
    , motion(motion)
    , U(motion.U)
    , time(time)
    , dt(dt)
    , midpoint(midpoint)
  {}


  template <int dim>
  typename StructureStep<dim>::Exchange
  StructureStep<dim>::take(const double energy)
  {
    add_elastic(energy);
    add_inertial();
    if (model.mesh().structure_dim() == dim || model.mesh().closed())
      exchange.leak = leak();
    return exchange;
  }


  template <int dim>
  typename StructureStep<dim>::Impulse
  StructureStep<dim>::impulse(const NodalField<dim> &forces,
                              const Positions<dim> &x,
                              const NodalField<dim> &velocities)
  {
    Impulse result;
    result.power = forces * velocities;
    result.force = forces.sum([&](const unsigned int q) { return forces[q]; });
    result.torque =
      forces.sum([&](const unsigned int q) { return cross_product<dim>(x[q], forces[q]); });
    return result;
  }


  template <int dim>
  void
  StructureStep<dim>::add_forces(const NodalField<dim> &forces,
                                 const Positions<dim> &x,
                                 const NodalField<dim> &velocities)
  {
    const Impulse added = impulse(forces, x, velocities);
    exchange.power += added.power;
    exchange.force += added.force;
    exchange.torque += added.torque;
  }


  template <int dim>
  double
  StructureStep<dim>::work_along_the_way(const Positions<dim> &old,
                                         const NodalField<dim> &velocity) const
  {
    // By two Gauss points, exact where the energy is a polynomial of degree 4.
    double work = 0;
    NodalField<dim> load;
    for (const double theta : {.5 - std::sqrt(1. / 12), .5 + std::sqrt(1. / 12)})
      {
        model.load(displaced(old, theta * dt, U), load);
        work += dt / 2 * (load * velocity);
      }
    return work;
  }


  template <int dim>
  void
  StructureStep<dim>::add_elastic(const double energy)
  {
    const Positions<dim> old = model.positions;
    NodalField<dim> velocity = U; // at the load points
    if (structure.loading)
      structure.loading->interpolate(space, space.velocity, velocity);
    const Positions<dim> points = model.load_points().positions(motion.geometry);
    add_forces(motion.force, points, velocity);
    const double elastic_power = exchange.power;
    if (!motion.other_force.empty())
      add_forces(motion.other_force, points, velocity);
    for (const NodalField<dim> &load : model.force_loads(motion.loaded, motion.geometry, U))
      exchange.forces.push_back(impulse(load, motion.geometry, U));

    // Within the step the moment is that of the load and the energy is one: what it loses is work.
    const double before = model.energy(old);
    model.positions     = displaced(old, dt, U);
    const double after = model.energy(model.positions), way = before - after;
    const double work     = work_along_the_way(old, velocity);
    exchange.numerical    = work - dt * elastic_power;
    exchange.unexplained  = way - work;
    exchange.elastic_work = std::abs(work);

    model.set_moment(time + dt, dt);
    model.update_state(model.positions);
    model.set_moment(time + dt, 0.);
    exchange.elastic_energy = model.energy(model.positions);
    exchange.inelastic =
      (energy - before) + (after - exchange.elastic_energy) - dt * (exchange.power - elastic_power);
  }


  template <int dim>
  void
  StructureStep<dim>::add_inertial()
  {
    const std::vector<double> &mass = model.excess_mass();
    const double tau                = midpoint ? dt / 2 : dt; // of the fluid's step
    NodalField<dim> change          = U;
    for (unsigned int i = 0; i < U.size(); ++i)
      change[i] -= model.velocities[i];
    for (unsigned int i = 0; i < U.size(); ++i)
      model.velocities[i] += (midpoint ? 2. : 1.) * change[i];
    if (mass.empty())
      return;
    NodalField<dim> inertia = change;
    for (unsigned int i = 0; i < U.size(); ++i)
      inertia[i] *= -mass[i] / tau;
    add_forces(inertia, motion.geometry, U);
    if (!midpoint)
      exchange.numerical -= tau / 2 * (inertia * change);
  }


  template <int dim>
  double
  StructureStep<dim>::leak() const
  {
    // A is a polynomial of degree dim in the positions.
    const auto A = [&](const double factor) {
      return model.measure(displaced(motion.geometry, factor, U));
    };
    return dim == 2 ? (A(dt) - A(-dt)) / 2 : (8 * (A(dt) - A(-dt)) - (A(2 * dt) - A(-2 * dt))) / 12;
  }


  template class StructureStep<2>;
  template class StructureStep<3>;
} // namespace feib
