// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_regulated_pressures_h
#define feib_plugins_navier_stokes_regulated_pressures_h

#include "operators/boundary_terms.h"
#include "stokes_solver.h"

#include <feib/fluid_solver.h>

#include <vector>

namespace feib
{
  /// The pressures outside of the conditions where one number hangs on the flux Q: prescribed
  /// fluxes and windkessels.
  ///
  /// Each pressure is one more unknown with one more equation, Q = given or P = b Q + a with a
  /// and b of a backward Euler step of the circuit. A correction of the other unknowns is followed
  /// by what the fluid answers to changes of the pressures, such that these equations hold. The
  /// answers are kept while mesh and step stay, and for a fluid that is not linear within a step:
  /// where they have changed since, the next correction sees what is left.
  template <int dim>
  class RegulatedPressures
  {
  public:
    explicit RegulatedPressures(const BoundaryTerms<dim> &terms)
      : terms(terms)
    {}

    /// For the present mesh of the space.
    void reinit(const EulerianSpace<dim> &space);

    bool
    empty() const
    {
      return outlets.empty();
    }

    /// The equations of a step from the old velocity of the space. @p linear: whether what the
    /// fluid answers is the same in every state. Collective.
    void begin(const EulerianSpace<dim> &space,
               const typename FluidSolver<dim>::Step &step,
               bool linear);

    /// The pressures by the number of the condition, 0 where there is none.
    std::vector<double> pressures(const EulerianSpace<dim> &space) const;

    /// The fluxes through all conditions at the state of the space. Collective.
    std::vector<double>
    fluxes(const EulerianSpace<dim> &space) const
    {
      return terms.fluxes(space, space.velocity);
    }

    /// load += that of the pressures, not condensed.
    void add_load(VelocityVector &load) const;

    /// Adds to a correction of the state of the space what makes the equations hold. Returns the
    /// number of linear iterations. Collective.
    unsigned int correct(const EulerianSpace<dim> &space,
                         const StokesEquations<dim> &equations,
                         StokesSolver<dim> &solver,
                         VelocityVector &du,
                         PressureVector &dp);

    /// Takes a part of the changes of the pressures that belong to the last correction.
    void add(double part);

    /// What is left of the equations, relative to what is in them and to @p least_flux: a flux may
    /// be prescribed as zero.
    double residual(const std::vector<double> &fluxes, double least_flux) const;

    /// The step has been solved, with these fluxes.
    void finish(const std::vector<double> &fluxes);

    void commit();

    /// The fluxes through all conditions that a velocity put into the space should have where they
    /// are prescribed: before the first step those at time 0, later its own. Collective.
    std::vector<double> wanted_fluxes(const EulerianSpace<dim> &space) const;

    /// Of prescribed fluxes alone, for a velocity u that is to have those @p wanted: adds to u
    /// multiples of what the pressures do under the equations given. Collective.
    void adjust(const EulerianSpace<dim> &space,
                const std::vector<double> &wanted,
                const StokesEquations<dim> &equations,
                StokesSolver<dim> &solver,
                VelocityVector &u) const;

    /// Drops the answers, which the next correction finds anew.
    void
    forget()
    {
      answers.clear();
    }

    void
    archive(Archive &archive)
    {
      archive("states", states);
      archive("stepped", stepped);
    }

  private:
    /// The pressure p of a windkessel, linear in time.
    struct Way
    {
      double start_time = 0, start = 0, end_time = 0, end = 0;

      double
      at(const double time) const
      {
        return end_time > start_time
                 ? start + (end - start) * (time - start_time) / (end_time - start_time)
                 : start;
      }

      void
      archive(Archive &archive)
      {
        archive("start_time", start_time);
        archive("start", start);
        archive("end_time", end_time);
        archive("end", end);
      }
    };

    /// What goes on from step to step.
    struct State
    {
      Way past;            // of the last step accepted
      double pressure = 0; // P

      void
      archive(Archive &archive)
      {
        archive("past", past);
        archive("pressure", pressure);
      }
    };

    struct Outlet
    {
      unsigned int condition;
      bool is_flux;
      VelocityVector load; // of a pressure of 1
      // Of the present step: Q = flux, or P = b Q + a, with the part resistance Q of it.
      double flux = 0, a = 0, b = 0, resistance = 0;
      Way way;           // of a windkessel's p
      double change = 0; // of P, with the last correction
    };

    /// What the fluid does under a pressure of 1.
    struct Answer
    {
      VelocityVector velocity;
      PressureVector pressure;
      std::vector<double> fluxes;
    };

    Answer answer(const EulerianSpace<dim> &space,
                  const StokesEquations<dim> &equations,
                  StokesSolver<dim> &solver,
                  const Outlet &outlet,
                  double accuracy,
                  unsigned int &iterations) const;

    const BoundaryTerms<dim> &terms;
    std::vector<Outlet> outlets;
    std::vector<State> states;   // of the outlets
    std::vector<Answer> answers; // of the outlets
    double answers_rate = 0, answers_time = 0, answers_accuracy = 0;
    bool stepped = false; // whether there has been a step
  };
} // namespace feib

#endif
