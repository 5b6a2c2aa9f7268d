// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/stokes_multigrid.h"

#include <algorithm>
#include <sstream>

namespace feib
{
  template <int dim>
  StokesMultigrid<dim>::Mesh::Mesh(const EulerianSpace<dim> &space)
    : hierarchy(space)
    , map(space, hierarchy[0])
    , velocity(hierarchy)
    , pressure(hierarchy, space.domain().enclosed())
    , walls(false)
  {
    for (unsigned int a = 0; a < dim; ++a)
      walls = walls || !space.domain().periodic(a);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::prepare(const EulerianSpace<dim> &space,
                                const VelocityForm &wanted,
                                const bool augmented)
  {
    const bool new_mesh = revision != space.revision();
    if (new_mesh)
      {
        mesh.reset(); // frees the memory
        mesh = std::make_unique<Mesh>(space);
        corrections.clear();
        corrections.resize(mesh->hierarchy.size());
        revision = space.revision();
      }
    const VelocityForm seen = form_of_cycle(wanted, augmented);
    const bool new_form     = seen.alpha != cycled.alpha || seen.mu != cycled.mu ||
                          seen.nu != cycled.nu || seen.eta != cycled.eta;
    // What lumping the mass does to pressures counts only where inertia does.
    constexpr double dominated = .1;
    const double h             = mesh->hierarchy[0].smallest_size();
    inertia_counts             = wanted.mu < dominated * (wanted.alpha * h * h);
    form                       = wanted;
    cycled                     = seen;
    if (!new_mesh && !new_form)
      return;
    choose_corrections();
    mesh->velocity.set_form(cycled, coarser_first);
  }


  template <int dim>
  VelocityForm
  StokesMultigrid<dim>::form_of_cycle(const VelocityForm &wanted, const bool augmented) const
  {
    // (grad u^T, grad v) counts only where viscosity does. The larger eta, the better is S known,
    // and the worse is the condition of A: with these values both cost about as much. On long cells
    // the smoother bears less.
    constexpr double negligible = .005, inertial_eta = dim == 2 ? .1 : .05;
    const MultigridLevel<dim> &finest = mesh->hierarchy[0];
    const double h = finest.smallest_size(), inertia = wanted.alpha * h * h,
                 aspect = finest.aspect_ratio(), viscous_eta = (dim + 1) / (aspect * aspect);
    return {wanted.alpha,
            wanted.mu,
            wanted.mu > negligible * inertia ? wanted.nu : 0.,
            0.,
            augmented ? std::max(viscous_eta * wanted.mu, inertial_eta * inertia) : 0.};
  }


  template <int dim>
  void
  StokesMultigrid<dim>::choose_corrections()
  {
    const Hierarchy<dim> &hierarchy = mesh->hierarchy;
    coarser_first.assign(hierarchy.size(), false);
    for (unsigned int l = 0; l + 1 < hierarchy.size(); ++l)
      {
        const double size = hierarchy[l].smallest_size();
        coarser_first[l]  = mesh->walls && cycled.mu > cycled.alpha * size * size;
        if (coarser_first[l] && corrections[l].u.size() == 0)
          {
            hierarchy[l].reinit_velocity(corrections[l].u);
            hierarchy[l].reinit_pressure(corrections[l].p);
          }
      }
  }


  template <int dim>
  void
  StokesMultigrid<dim>::correct_first(const unsigned int l)
  {
    Hierarchy<dim> &hierarchy = mesh->hierarchy;
    auto &velocity = mesh->velocity[l], &coarse_velocity = mesh->velocity[l + 1];
    auto &pressure = mesh->pressure[l], &coarse_pressure = mesh->pressure[l + 1];
    LevelVector<float> &u = corrections[l].u, &p = corrections[l].p;
    hierarchy.transfer(l).restrict_velocity(velocity.f, coarse_velocity.f);
    hierarchy[l + 1].condense(coarse_velocity.f);
    hierarchy.transfer(l).restrict_pressure(pressure.g, coarse_pressure.g);
    apply(l + 1);
    u = 0;
    p = 0;
    hierarchy[l + 1].expand(coarse_velocity.u);
    hierarchy.transfer(l).prolongate_velocity(coarse_velocity.u, u);
    hierarchy.transfer(l).prolongate_pressure(coarse_pressure.p, p);
    mesh->velocity.multiply(l, u);
    velocity.f -= velocity.product;
    hierarchy[l].apply_gradient(p, pressure.flux);
    velocity.f += pressure.flux;
    hierarchy[l].apply_divergence(u, pressure.product);
    pressure.g -= pressure.product;
  }


  template <int dim>
  void
  StokesMultigrid<dim>::apply(const unsigned int l)
  {
    if (coarser_first[l])
      correct_first(l);

    // The inverse of the Schur complement: (alpha Lp^{-1} + (mu + nu + eta) Mp^{-1}) g. In it the
    // symmetric gradient is twice the other, as (grad u^T, grad v) and (div u, div v) are the same
    // away from walls.
    auto &velocity                   = mesh->velocity[l];
    auto &pressure                   = mesh->pressure[l];
    const MultigridLevel<dim> &level = mesh->hierarchy[l];
    if (cycled.alpha > 0)
      {
        mesh->pressure.apply(l, l == 0 && inertia_counts);
        pressure.p *= cycled.alpha;
      }
    else
      pressure.p = 0;
    level.add_inverse_pressure_mass(cycled.mu + cycled.nu + cycled.eta, pressure.g, pressure.p);
    level.apply_gradient(pressure.p, pressure.flux);
    velocity.f += pressure.flux;
    mesh->velocity.apply(l);

    if (coarser_first[l])
      {
        velocity.u += corrections[l].u;
        pressure.p += corrections[l].p;
      }
  }


  template <int dim>
  void
  StokesMultigrid<dim>::solve(const VelocityVector &f,
                              const PressureVector &g,
                              VelocityVector &u,
                              PressureVector &p)
  {
    auto &velocity = mesh->velocity[0];
    auto &pressure = mesh->pressure[0];
    mesh->map.import_velocity(f, velocity.f);
    mesh->map.import_pressure(g, -1, pressure.g);
    apply(0);
    mesh->map.export_velocity(velocity.u, u);

    // What the cycle's A lacks, or has in excess, as far as the pressures can tell: the pressure
    // changes by Mp^{-1} B u.
    const double lacking = form.nu - cycled.nu + form.gamma - cycled.eta;
    if (lacking != 0)
      {
        const MultigridLevel<dim> &finest = mesh->hierarchy[0];
        finest.expand(velocity.u);
        finest.apply_divergence(velocity.u, pressure.g);
        finest.add_inverse_pressure_mass(lacking, pressure.g, pressure.p);
      }
    mesh->map.export_pressure(pressure.p, p);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::solve_pressure(const PressureVector &g, PressureVector &p)
  {
    mesh->map.import_pressure(g, 1, mesh->pressure[0].g);
    mesh->pressure.apply(0, false);
    mesh->map.export_pressure(mesh->pressure[0].p, p);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::solve_velocity(const VelocityVector &f, VelocityVector &u)
  {
    mesh->map.import_velocity(f, mesh->velocity[0].f);
    mesh->velocity.apply(0);
    mesh->map.export_velocity(mesh->velocity[0].u, u);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::divide_by_mass(VelocityVector &v)
  {
    LevelVector<float> &u             = mesh->velocity[0].u;
    const LevelVector<float> &inverse = mesh->pressure[0].inverse_mass;
    mesh->map.import_velocity(v, u);
    for (unsigned int i = 0; i < u.locally_owned_size(); ++i)
      u.begin()[i] *= inverse.begin()[i];
    mesh->map.export_velocity(u, v);
  }


  template <int dim>
  std::string
  StokesMultigrid<dim>::describe() const
  {
    const unsigned int n = mesh->hierarchy.size();
    std::ostringstream text;
    text << n << (n == 1 ? " level" : " levels") << ", of velocity " << mesh->velocity.last() + 1
         << (mesh->velocity.ends_with_factor() ? "" : " (dominated by mass there)");
    return text.str();
  }


  template class StokesMultigrid<2>;
  template class StokesMultigrid<3>;
} // namespace feib
