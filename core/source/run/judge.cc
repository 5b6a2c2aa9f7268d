// SPDX-License-Identifier: LGPL-2.1-or-later
#include "judge.h"

#include "resolution.h"
#include "structure_checks.h"

#include <feib/error.h>
#include <feib/message.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <iomanip>
#include <sstream>

namespace feib
{
  namespace
  {
    /// To two digits.
    double
    rounded_down(const double value)
    {
      const double digit = std::pow(10., std::floor(std::log10(value)) - 1);
      return std::floor(value / digit * (1 + 1e-12)) * digit;
    }
  } // namespace


  template <int dim>
  Judge<dim>::Judge(Components<dim> &components,
                    const Accounts<dim> &accounts,
                    const Parameters &time)
    : components(components)
    , accounts(accounts)
    , energy_growth(time.number("energy_growth"))
    , measure_tolerance(time.number("measure_tolerance"))
  {}


  template <int dim>
  void
  Judge<dim>::begin()
  {
    energies.emplace(components, energy_growth);
    for (const ImmersedStructure<dim> &structure : components.structures)
      initial_measures.push_back(structure.model->measure(structure.model->positions));
  }


  template <int dim>
  double
  Judge<dim>::start()
  {
    calm_limit = components.integrator->stability_limit(components.system()).dt;
    check_parts(0.);
    check_meshes(components, 0., verdict);
    check_structures(components, 0., verdict);
    check_overlap(components, 0., verdict);
    return calm_limit;
  }


  template <int dim>
  void
  Judge<dim>::check_state() const
  {
    // Everything here is the same on all ranks.
    for (const ImmersedStructure<dim> &structure : components.structures)
      for (unsigned int i = 0; i < structure.model->positions.size(); ++i)
        if (!components.space->forest().inside(structure.model->positions[i]))
          {
            std::ostringstream message;
            message << "the structure \"" << structure.model->name() << "\" leaves the box: node "
                    << structure.model->mesh().node_number(i) << " moves to ("
                    << structure.model->positions[i] << ")";
            throw RunFailure(message.str());
          }
    // A periodic box has no outside: there an unstable run shows in elements longer than the box.
    for (const ImmersedStructure<dim> &structure : components.structures)
      if (components.torn(*structure.model))
        throw RunFailure("the structure \"" + structure.model->name() +
                         "\" is torn: one of its elements is longer than the box");
    if (!std::isfinite(components.space->velocity.l2_norm()))
      throw RunFailure("the velocity is not finite");
  }


  template <int dim>
  void
  Judge<dim>::judge_energies(const double before, const double after, const Report &report)
  {
    energies->judge(before, after, report);
  }


  template <int dim>
  void
  Judge<dim>::forget_failure()
  {
    energies->grew = false;
  }


  template <int dim>
  bool
  Judge<dim>::grew() const
  {
    return energies->grew;
  }


  template <int dim>
  std::string
  Judge<dim>::stability_sentence(const double dt)
  {
    auto limit = components.integrator->stability_limit(components.system());
    // A state that has begun to go wrong has limits of its own.
    if (dt > calm_limit)
      limit.dt = std::max(limit.dt, calm_limit);
    std::ostringstream text;
    text << std::setprecision(2) << "dt = " << dt;
    if (dt > limit.dt)
      {
        text << " exceeds the estimated limit " << limit.dt << " of " << components.integrator_name
             << " for structure \"" << limit.structure << "\"; use " << limit.alternative
             << " or dt <= " << rounded_down(limit.dt);
      }
    else if (std::isfinite(limit.dt))
      text << " is below the estimated limit " << limit.dt << " of " << components.integrator_name
           << " for structure \"" << limit.structure << "\", yet the run is not stable; use "
           << limit.alternative << " or a smaller dt";
    else
      text << " is too large for " << components.integrator_name
           << ", which has no limit by itself; use a smaller dt";
    return text.str();
  }


  template <int dim>
  void
  Judge<dim>::check_limits(const double time, const double dt)
  {
    const double limit = accounts.smallest_limit();
    if (dt > limit * (1 + 1e-12))
      verdict.warn("step_limit", time, dt / limit, stability_sentence(dt));
  }


  template <int dim>
  void
  Judge<dim>::check_result(const double time)
  {
    if (energies->totals.growth == 0)
      calm_limit = accounts.smallest_limit();
    largest_velocity = std::max(largest_velocity, accounts.ledger.last("largest_velocity"));
    check_energies(time);
    check_kinetic_energy(time);
    check_measures(time);
    check_structures(components, time, verdict);
    check_resolution(time);
    check_forces(time);
    check_momentum(time);
  }


  template <int dim>
  void
  Judge<dim>::check_end(const double time)
  {
    check_overlap(components, time, verdict);
  }


  template <int dim>
  std::string
  Judge<dim>::driven_sentence(const double part, const std::string &structure)
  {
    return "of the work of the load of the structure \"" + structure + "\" " + percent(part) +
           " came from nowhere: at Gauss points of faces, or without boundary faces, a load is not "
           "the derivative of the energy; no shorter step helps, but face_quadrature vertex does, "
           "or finer meshes";
  }


  template <int dim>
  void
  Judge<dim>::check_energies(const double time)
  {
    if (const auto [part, name] = energies->unexplained(); part > .01)
      verdict.warn("unexplained_energy",
                   time,
                   part,
                   "nothing explains some of the energy of the structure \"" + name +
                     "\": the stress of its law is not the derivative of its energy");
    if (const auto [part, name] = energies->gained(); part > tolerated_gain)
      {
        std::ostringstream text;
        text << "the structure \"" << name << "\" has gained " << percent(part)
             << " of the work of its load from the time scheme: "
             << stability_sentence(accounts.ledger.last("dt"));
        verdict.warn("structure_growth", time, part, text.str());
      }
    if (const auto [part, name] = energies->driven(); part > tolerated_gain)
      verdict.warn("driven_structure", time, part, driven_sentence(part, name));
  }


  template <int dim>
  bool
  Judge<dim>::moves(const double time) const
  {
    const Domain<dim> &box = components.space->domain();
    return largest_velocity * time >= 1e-9 * box.lower.distance(box.upper);
  }


  template <int dim>
  void
  Judge<dim>::check_kinetic_energy(const double time)
  {
    const double kinetic = accounts.ledger.last("kinetic");
    largest_kinetic      = std::max(largest_kinetic, std::abs(kinetic));
    if (kinetic < -1e-6 * largest_kinetic && moves(time))
      verdict.warn("light_structure",
                   time,
                   -kinetic / largest_kinetic,
                   "the kinetic energy of fluid and structures together is negative: the elements "
                   "of a structure lighter than the fluid are too large for it, as its nodes "
                   "take away more mass than the cells about them have; smaller elements (the mesh "
                   "\"refined\"), or an excess_density nearer to 0");
  }


  template <int dim>
  void
  Judge<dim>::check_parts(const double time)
  {
    const EulerianSpace<dim> &space = *components.space;
    const Domain<dim> &box          = space.domain();
    // Whether a face of the box that the place lies on lets nothing through face @p f there.
    const auto is_tight = [&](const dealii::Point<dim> &x, const unsigned int f) {
      for (unsigned int g = 0; g < 2 * dim; ++g)
        if (const unsigned int b = g / 2;
            !box.periodic(b) && std::abs(x[b] - (g % 2 == 0 ? box.lower : box.upper)[b]) <=
                                  round_off(box.lower[b], box.upper[b]))
          if (const auto &condition = box.conditions[box.condition_at_node(g, x)];
              condition.prescribes(f / 2) && (condition.tight || b != f / 2))
            return true;
      return false;
    };
    unsigned int n = 0;
    for (const auto &face : space.boundary_faces())
      if (box.conditions[face.condition].tight)
        {
          const auto &cell = space.cells()[face.cell];
          bool all_tight   = true;
          for (unsigned int node = 0; node < EulerianSpace<dim>::n_nodes; ++node)
            {
              dealii::Point<dim> x;
              bool on_face = true;
              for (unsigned int a = 0, rest = node; a < dim; ++a, rest /= 3)
                {
                  x[a] = cell.lower[a] + cell.size[a] * (rest % 3) / 2.;
                  if (a == face.face / 2)
                    on_face = rest % 3 == face.face % 2 * 2;
                }
              all_tight = all_tight && (!on_face || is_tight(x, face.face));
            }
          n += !all_tight;
        }
    n = dealii::Utilities::MPI::sum(n, space.communicator());
    if (n > 0)
      verdict.warn("parts",
                   time,
                   n,
                   "parts of faces of the box end within cells, so that fluid passes through the "
                   "wall beside them, beyond the flux there: let them end between cells, or make "
                   "the cells there smaller");
  }


  template <int dim>
  void
  Judge<dim>::check_measures(const double time)
  {
    const auto &totals = accounts.totals;
    for (unsigned int s = 0; s < components.structures.size(); ++s)
      {
        if (initial_measures[s] == 0)
          continue; // there is nothing that a change could be compared with
        const double error = std::abs(totals.leak[s] + totals.time_error[s]) / initial_measures[s];
        if (error > measure_tolerance)
          {
            std::ostringstream text;
            text << "the structure \"" << components.structures[s].model->name()
                 << "\" has changed its measure by " << percent(error) << ", "
                 << percent(totals.leak[s] / initial_measures[s]) << " by flux through it and "
                 << percent(totals.time_error[s] / initial_measures[s]) << " by the time scheme";
            verdict.warn("measure", time, error, text.str());
          }
      }
  }


  template <int dim>
  void
  Judge<dim>::check_resolution(const double time)
  {
    const double cell_reynolds = components.fluid->density() *
                                 accounts.ledger.last("largest_velocity") *
                                 components.space->smallest_edge() / components.fluid->viscosity();
    // Where viscosity rules, what is rough decays, and what structures push is rough beside them.
    constexpr double inertial = 30, rough = .26;
    if (cell_reynolds < inertial)
      return;
    const double part = roughness(*components.space);
    if (part < rough)
      return;
    std::ostringstream text;
    text << std::setprecision(2) << percent(part)
         << " of what the velocity varies within cells is rougher than they resolve, at a cell "
            "Reynolds number of "
         << cell_reynolds << ": the mesh is too coarse for the flow";
    verdict.warn("resolution", time, part, text.str());
  }


  template <int dim>
  void
  Judge<dim>::check_forces(const double time)
  {
    const Ledger &ledger   = accounts.ledger;
    const Domain<dim> &box = components.space->domain();
    const auto size        = box.upper - box.lower;
    // Where nothing has ever moved, forces are round-off.
    if (!moves(time))
      return;
    // Of the momentum of the fluid a solver leaves some, and of the forces that cancel, round-off.
    const double momentum = components.fluid->density() * box.volume() * largest_velocity,
                 energy   = std::abs(ledger.last("kinetic")) + std::abs(ledger.last("elastic")) +
                          std::abs(ledger.last("potential"));
    swings.add(ledger, std::max(1e-8 * momentum / ledger.last("dt"), 1e-10 * energy / size.norm()));
    const auto [part, name] = swings.worst();
    if (part == 0)
      return;
    std::ostringstream text;
    text
      << std::setprecision(2) << "the force of \"" << name << "\" swings within a few steps by "
      << percent(part) << " of what it is, which steps of " << ledger.last("dt")
      << " do not follow: its means over time hold, its values do not. Springs, a law or "
         "boundary values ask for too much: shorter steps may follow; targets and boundary "
         "values that change smoothly, dampers of half a step times the stiffness, or the scheme "
         "lagged_be let it rest";
    verdict.warn("unresolved_swing", time, part, text.str());
  }


  template <int dim>
  void
  Judge<dim>::check_momentum(const double time)
  {
    const Domain<dim> &box = components.space->domain();
    for (unsigned int a = 0; a < dim; ++a)
      if (!box.periodic(a))
        return;
    if (accounts.totals.body_work != 0)
      return;
    const Ledger &ledger          = accounts.ledger;
    dealii::Tensor<1, dim> change = -accounts.totals.impulse;
    for (unsigned int a = 0; a < dim; ++a)
      {
        const std::string name = std::string("momentum_") + "xyz"[a];
        change[a] += ledger.last(name) - ledger.first(name);
      }
    // That of the energy there was, if all moved together.
    const double scale =
      std::max(accounts.totals.impulse.norm(),
               std::sqrt(2 * components.fluid->density() * box.volume() *
                         std::max(ledger.first("total_energy"), ledger.last("kinetic"))));
    const double drift = change.norm();
    // Flows on meshes much too coarse for them lose their momentum while their energy falls as it
    // should.
    constexpr double tolerated = 1e-2;
    if (drift > tolerated * scale)
      {
        std::ostringstream text;
        text << "momentum has changed by " << percent(drift / scale)
             << " of what the energy could carry, though nothing acts on this periodic box"
             << (accounts.totals.impulse.norm() > 0 ? " but what the forces on structures gave it"
                                                    : "")
             << ": the mesh is too coarse for the flow";
        verdict.warn("momentum", time, drift / scale, text.str());
      }
  }


  template <int dim>
  std::string
  Judge<dim>::cause(const double time, const double dt)
  {
    check_limits(time, dt);
    if (const auto [part, name] = energies->driven(); part > tolerated_gain)
      return ": " + driven_sentence(part, name);
    if (energies->grew || dt > accounts.smallest_limit())
      return ": " + stability_sentence(dt);
    const auto &totals = accounts.totals;
    if (!components.space->domain().enclosed() &&
        -totals.convected > std::abs(totals.boundary_work) + std::abs(totals.body_work))
      return ": with the fluid that comes in at a static pressure more kinetic energy has come in "
             "than all pressures and forces have worked, and nothing bounds such an inflow; with "
             "\"inflow\": \"total\" none comes in";
    return "";
  }


  template class Judge<2>;
  template class Judge<3>;
} // namespace feib
