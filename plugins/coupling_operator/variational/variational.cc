// SPDX-License-Identifier: LGPL-2.1-or-later
#include "variational_schema.h"

#include <feib/coupling_operator.h>
#include <feib/failure.h>
#include <feib/plugin.h>

#include <sstream>

namespace feib
{
  /// J u at a point is the finite element velocity there: (J u)_q = u_h(x_q); in a wall that
  /// nothing can cross, what it is along the wall.
  template <int dim>
  class Variational : public CouplingOperator<dim>
  {
  public:
    explicit Variational(const Parameters &)
    {}

    void set_geometry(const EulerianSpace<dim> &space,
                      const LagrangianMesh<dim> &mesh,
                      const Positions<dim> &X,
                      const LagrangianPoints &points) override;

    void interpolate(const EulerianSpace<dim> &space,
                     const VelocityVector &u,
                     NodalField<dim> &U) const override;

    void spread(const EulerianSpace<dim> &space,
                const NodalField<dim> &f,
                VelocityVector &rhs) const override;

    MatrixEntries entries(const EulerianSpace<dim> &space) const override;

  private:
    static constexpr unsigned int n = EulerianSpace<dim>::n_nodes;

    // The points in this rank's cells, with the values of the shape functions of the cell there.
    struct Located
    {
      unsigned int point, cell;
      std::array<bool, dim> held; // components that are zero
      double values[n];
    };
    std::vector<Located> located;
    NodalField<dim> zero; // of the points
  };


  template <int dim>
  void
  Variational<dim>::set_geometry(const EulerianSpace<dim> &space,
                                 const LagrangianMesh<dim> &,
                                 const Positions<dim> &X,
                                 const LagrangianPoints &points)
  {
    const Positions<dim> x = points.positions(X);
    zero                   = NodalField<dim>(points);
    agree(space.communicator(), [&] {
      for (unsigned int q = 0; q < x.size(); ++q)
        if (!space.forest().inside(x[q]))
          {
            std::ostringstream message;
            message << "point " << q << " of a structure is at (" << x[q] << "), outside the box";
            throw RunFailure(message.str());
          }
    });
    located.clear();
    Located entry;
    dealii::Point<dim> unit;
    for (entry.point = 0; entry.point < x.size(); ++entry.point)
      {
        entry.cell = space.forest().locate(x[entry.point], unit);
        if (entry.cell == CartesianForest<dim>::not_here)
          continue;
        entry.held = space.domain().held(x[entry.point]);
        EulerianSpace<dim>::shape_values(unit, entry.values);
        located.push_back(entry);
      }
  }


  template <int dim>
  void
  Variational<dim>::interpolate(const EulerianSpace<dim> &space,
                                const VelocityVector &u,
                                NodalField<dim> &U) const
  {
    U = zero;
    for (const Located &entry : located)
      {
        const unsigned int *dofs = space.velocity_dofs(entry.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < n && !entry.held[a]; ++i)
            U[entry.point][a] += entry.values[i] * u.local_element(dofs[a * n + i]);
      }
    // Each point is in a cell of one rank.
    U.compress(space.communicator());
    U.update_ghosts();
  }


  template <int dim>
  void
  Variational<dim>::spread(const EulerianSpace<dim> &space,
                           const NodalField<dim> &f,
                           VelocityVector &rhs) const
  {
    rhs.zero_out_ghost_values();
    for (const Located &entry : located)
      {
        const unsigned int *dofs = space.velocity_dofs(entry.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < n && !entry.held[a]; ++i)
            rhs.local_element(dofs[a * n + i]) += entry.values[i] * f[entry.point][a];
      }
    rhs.compress(dealii::VectorOperation::add);
  }


  template <int dim>
  MatrixEntries
  Variational<dim>::entries(const EulerianSpace<dim> &space) const
  {
    MatrixEntries result;
    for (const Located &entry : located)
      {
        const unsigned int *dofs = space.velocity_dofs(entry.cell);
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int i = 0; i < n && !entry.held[a]; ++i)
            result.push_back({std::uint64_t(entry.point) * dim + a,
                              space.velocity.get_partitioner()->local_to_global(dofs[a * n + i]),
                              entry.values[i]});
      }
    return result;
  }
} // namespace feib


FEIB_PLUGIN("variational", "1.0", registry)
{
  registry.add<feib::CouplingOperator, feib::Variational>("variational", variational_schema);
}
