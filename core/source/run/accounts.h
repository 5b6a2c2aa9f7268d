// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_accounts_h
#define feib_accounts_h

#include "components.h"

#include <limits>
#include <map>

namespace feib
{
  /// The accounts of a run: energies and other sums over time, and the ledger's rows.
  template <int dim>
  class Accounts
  {
  public:
    using Impulse = typename TimeIntegrator<dim>::Impulse;
    using Report  = typename TimeIntegrator<dim>::Report;

    explicit Accounts(Components<dim> &components);

    /// Sums over time: a part of the state, to be undone with a step.
    struct Totals
    {
      double dissipated = 0, convected = 0, numerical = 0, unexplained = 0;
      double inelastic     = 0;
      double boundary_work = 0, body_work = 0;
      double energy            = 0; // now, on the mesh the next step is taken on
      double remeshing         = 0; // kinetic energy gained by moving u to another mesh
      double linear_iterations = 0, nonlinear_iterations = 0, geometry_iterations = 0;
      double largest_increase          = -std::numeric_limits<double>::infinity();
      double largest_relative_increase = -std::numeric_limits<double>::infinity();
      double largest_closure           = 0;
      double smallest_dt               = std::numeric_limits<double>::infinity();
      double largest_dt                = 0;
      std::vector<double> leak, time_error; // per structure, of its measure
      dealii::Tensor<1, dim> impulse;       // of the forces on structures
      double first_linear_iterations = 0;   // of the first step

      void archive(Archive &archive);
    };

    Totals totals;
    Ledger ledger;

    /// Adds a step to the totals and gives its row for the ledger, of the state the components
    /// hold. @p before: the positions before the step. Throws RunFailure when a value is not
    /// finite. Collective.
    Ledger::Row add(unsigned int step,
                    double time,
                    double dt,
                    const Report &report,
                    const std::vector<Positions<dim>> &before);

    /// The kinetic energy changed by moving to another mesh.
    void add_remeshing(double gained);

    void
    archive(Archive &archive)
    {
      archive("totals", totals);
      archive("ledger", ledger);
      archive("seconds_at_last_row", seconds_at_last_row);
    }

    /// The smallest limit of the step at the present state; infinite without limits.
    double smallest_limit() const;

  private:
    /// The state of fluid and structures together.
    struct State
    {
      typename FluidSolver<dim>::Balance fluid;
      double kinetic, elastic, potential; // potential: of the forces on structures
      dealii::Tensor<1, dim> momentum;
      dealii::Tensor<1, 3> angular_momentum;
    };

    /// After a step of that report, or without steps.
    State state(const Report &report) const;

    void sum_up(unsigned int step, double dt, const Report &report, double total);

    /// The columns of what the fluid gets from something.
    static void add_impulse(Ledger::Row &row,
                            const std::string &name,
                            double power,
                            const dealii::Tensor<1, dim> &force,
                            const dealii::Tensor<1, 3> &torque);

    /// The columns of the faces of the box.
    void add_boundary(Ledger::Row &row, const Report &report) const;

    /// The columns of structure @p s.
    void add_structure(Ledger::Row &row, unsigned int s, const Report &report) const;

    /// The half axes of the ellipse or ellipsoid with the same second moments, and these.
    static void add_axes(Ledger::Row &row, const StructureModel<dim> &model);

    Components<dim> &components;
    std::map<std::string, double> seconds_at_last_row;
  };
} // namespace feib

#endif
