// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_model_h
#define feib_structure_model_h

#include <feib/archive.h>
#include <feib/lagrangian_points.h>
#include <feib/matrix_entry.h>
#include <feib/parameters.h>
#include <feib/structure_force.h>

#include <deal.II/base/symmetric_tensor.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// An elastic structure: holds the positions X of its nodes and turns them into energy and load.
  /// It never sees the fluid. Functions of X take it as an argument, because time schemes evaluate
  /// them at predicted positions. All functions are collective; results are the same on all ranks.
  template <int dim>
  class StructureModel
  {
  public:
    static constexpr const char *kind = "structure_model";

    virtual ~StructureModel() = default;

    /// The name given in the case.
    virtual const std::string &name() const = 0;

    virtual const LagrangianMesh<dim> &mesh() const = 0;

    /// The state: the position of every node. The constructor sets it to the initial map.
    Positions<dim> positions;

    /// Those at the start of a run, which the constructor sets.
    Positions<dim> initial_positions;

    /// The velocity of every node: with an excess density a part of the state, else a first guess.
    NodalField<dim> velocities;

    /// What the structure carries from step to step; a class that adds to it calls this one too.
    virtual void
    archive(Archive &archive)
    {
      const std::size_t n_nodes = positions.size();
      archive("positions", positions);
      archive("velocities", velocities);
      if (positions.size() != n_nodes)
        throw RunFailure("the structure \"" + name() + "\" has " + std::to_string(n_nodes) +
                         " nodes, its archived state has " + std::to_string(positions.size()));
    }

    /// The mass of each node (lumped) beyond that of the fluid the structure displaces; empty for a
    /// structure of the fluid's density.
    virtual const std::vector<double> &excess_mass() const = 0;

    /// What acts on the structure beside its laws, attached to it: from now on part of the
    /// functions below. Once, before the first step. Throws Error when it takes none.
    virtual void
    set_forces(std::vector<std::unique_ptr<StructureForce<dim>>> forces)
    {
      if (!forces.empty())
        throw Error("", "the structure \"" + name() + "\" takes no forces");
    }

    /// The names of the forces.
    virtual std::vector<std::string>
    force_names() const
    {
      return {};
    }

    /// The energy of each force at X.
    virtual std::vector<double>
    force_energies(const Positions<dim> &X) const
    {
      (void)X;
      return {};
    }

    /// What each force does to the nodes when its load is taken at X, and viscous and external
    /// loads at @p geometry, for velocities @p U.
    virtual std::vector<NodalField<dim>>
    force_loads(const Positions<dim> &X,
                const Positions<dim> &geometry,
                const NodalField<dim> &U) const
    {
      (void)X;
      (void)geometry;
      (void)U;
      return {};
    }

    /// The moment at which the functions of X below are taken, for laws and forces that depend on
    /// it; @p elapsed is the time since the beginning of the step, 0 between steps. Schemes call it
    /// at the beginning of a step with the time of their load, and at its end.
    virtual void
    set_moment(const double time, const double elapsed)
    {
      (void)time;
      (void)elapsed;
    }

    /// The end of a step at X: the state of laws and forces becomes what X makes it. Once for each
    /// step.
    virtual void
    update_state(const Positions<dim> &X)
    {
      (void)X;
    }

    /// State of the laws, for the output: names, and a value per element.
    virtual std::vector<std::pair<std::string, std::vector<double>>>
    state() const
    {
      return {};
    }

    /// E_h(X), the energy of laws and forces.
    virtual double energy(const Positions<dim> &X) const = 0;

    /// The points the load acts at: the nodes, or Gauss points of faces (and, where there are
    /// forces, the nodes after them).
    virtual const LagrangianPoints &load_points() const = 0;

    /// The load <F_h, v> = sum_q load[q] . v(x_q) at the load points. With the vertex rule
    /// load = -dE_h/dX. Made anew, ghosts up to date.
    virtual void load(const Positions<dim> &X, NodalField<dim> &load) const = 0;

    /// The derivative of the load in the direction dX.
    virtual void load_derivative(const Positions<dim> &X,
                                 const NodalField<dim> &dX,
                                 NodalField<dim> &dload) const = 0;

    /// - d load/dX as entries: row = load point * dim + component, column = node * dim + component.
    /// Every rank gives a part.
    virtual MatrixEntries tangent(const Positions<dim> &X) const = 0;

    /// Whether a part of the load depends on the velocities U of the nodes.
    virtual bool
    viscous() const
    {
      return false;
    }

    /// That part, linear in U, beside load().
    virtual void
    viscous_load(const Positions<dim> &X, const NodalField<dim> &U, NodalField<dim> &load) const
    {
      (void)X;
      (void)U;
      load = NodalField<dim>(load_points());
    }

    /// - d viscous_load/dU as entries, like tangent().
    virtual MatrixEntries
    viscous_tangent(const Positions<dim> &X) const
    {
      (void)X;
      return {};
    }

    /// Whether there is a load of forces that comes from no energy.
    virtual bool
    external() const
    {
      return false;
    }

    /// That load, at the load points.
    virtual void
    external_load(const Positions<dim> &X, NodalField<dim> &load) const
    {
      (void)X;
      load = NodalField<dim>(load_points());
    }

    /// Whether the load is linear in X, so that its derivative does not depend on X.
    virtual bool linear() const = 0;

    /// Whether the load is -dE_h/dX at the nodes, so that the tangent is symmetric.
    virtual bool conservative() const = 0;

    /// Largest eigenvalues over all elements, of energies per measure.
    struct Stiffness
    {
      double reference = 0; // of d2W/dF2: kappa_max of the stability analysis
      double spatial   = 0; // of J^-1 d2W/dH2 for gradients H at the present place, dF = H F
      typename StructureForce<dim>::Stiffness forces; // of all forces
    };

    virtual Stiffness stiffness(const Positions<dim> &X) const = 0;

    /// Area or volume of a body of dimension dim; what a closed curve or surface encloses (0 of one
    /// that crosses itself and encloses as much from one side as from the other, but for
    /// round-off); length or area of an open one.
    virtual double measure(const Positions<dim> &X) const = 0;

    /// The centroid of what measure() measures, the middle of all nodes' extent where that is 0.
    virtual dealii::Point<dim> centroid(const Positions<dim> &X) const = 0;

    /// The second moments, over the measure, of what measure() measures about its centroid: int (x
    /// - c)(x - c)^T / measure; 0 where that is 0. [length^2]
    virtual dealii::SymmetricTensor<2, dim> second_moments(const Positions<dim> &X) const = 0;

    /// The elastic stress per element, for output: P F^T / J, J the present measure over that of
    /// reference; for curves and surfaces the tension. Indexed by element.
    virtual std::vector<dealii::SymmetricTensor<2, dim>>
    cauchy_stress(const Positions<dim> &X) const = 0;

    /// Energy density W per element, for output. Indexed by element.
    virtual std::vector<double> energy_density(const Positions<dim> &X) const = 0;
  };
} // namespace feib

#endif
