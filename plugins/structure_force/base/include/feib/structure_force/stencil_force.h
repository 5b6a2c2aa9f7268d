// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_force_stencil_force_h
#define feib_structure_force_stencil_force_h

#include <feib/dual.h>
#include <feib/energy_law.h>
#include <feib/structure_force.h>

#include <algorithm>
#include <array>
#include <vector>

namespace feib
{
  /// A force that is given by its energy alone, a sum over groups of n nodes, in numbers of any
  /// kind:
  ///
  ///   template <int dim>
  ///   class MyForce : public StencilForce<MyForce<dim>, 2, dim>
  ///   {
  ///   public:
  ///     template <typename Number>
  ///     Number
  ///     stencil_energy(const std::array<std::array<Number, dim>, 2> &X,
  ///                    const PointBatch &stencils) const;
  ///   };
  ///
  /// attach() fills `stencils`. Loads, their derivatives and entries follow by dual numbers, for
  /// several stencils at once. The energy is made of what EnergyLaw lists.
  template <class Force, int n_nodes, int dim>
  class StencilForce : public StructureForce<dim>
  {
  public:
    double
    energy(const Positions<dim> &X) const final
    {
      double sum = 0;
      for_each_batch(0, stencils.size(), [&](const PointBatch &batch, const unsigned int filled) {
        const Lanes value = force().stencil_energy(at<Lanes>(X, batch), batch);
        for (unsigned int lane = 0; lane < filled; ++lane)
          sum += value[lane];
      });
      return sum;
    }

    void
    load(const Positions<dim> &X, NodalField<dim> &load) const final
    {
      using Number = Dual<n, Lanes>;
      for_each_batch(0, stencils.size(), [&](const PointBatch &batch, const unsigned int filled) {
        auto places = at<Number>(X, batch);
        for (int k = 0; k < n_nodes; ++k)
          for (int a = 0; a < dim; ++a)
            places[k][a].slope[k * dim + a] = 1.;
        const Number value = force().stencil_energy(places, batch);
        for (unsigned int lane = 0; lane < filled; ++lane)
          for (int k = 0; k < n_nodes; ++k)
            for (int a = 0; a < dim; ++a)
              load[stencils[batch.index[lane]][k]][a] -= value.slope[k * dim + a][lane];
      });
    }

    void
    load_derivative(const Positions<dim> &X,
                    const NodalField<dim> &dX,
                    NodalField<dim> &dload) const final
    {
      for_each_batch(0, stencils.size(), [&](const PointBatch &batch, const unsigned int filled) {
        const auto direction = at<Lanes>(dX, batch);
        const auto value     = slopes_along(X, batch, direction);
        for (unsigned int lane = 0; lane < filled; ++lane)
          for (int k = 0; k < n_nodes; ++k)
            for (int a = 0; a < dim; ++a)
              dload[stencils[batch.index[lane]][k]][a] -= value.slope[k * dim + a].slope[0][lane];
      });
    }

    void
    tangent(const Positions<dim> &X, MatrixEntries &entries) const final
    {
      const auto [first, last] = part_of_this_rank();
      for_each_batch(first, last, [&](const PointBatch &batch, const unsigned int filled) {
        for (int j = 0; j < n_nodes; ++j)
          for (int b = 0; b < dim; ++b)
            {
              std::array<std::array<Lanes, dim>, n_nodes> direction;
              for (auto &vector : direction)
                vector.fill(Lanes(0.));
              direction[j][b]  = 1.;
              const auto value = slopes_along(X, batch, direction);
              for (unsigned int lane = 0; lane < filled; ++lane)
                {
                  const auto &nodes = stencils[batch.index[lane]];
                  for (int k = 0; k < n_nodes; ++k)
                    for (int a = 0; a < dim; ++a)
                      entries.push_back({std::uint64_t(nodes[k]) * dim + a,
                                         std::uint64_t(nodes[j]) * dim + b,
                                         value.slope[k * dim + a].slope[0][lane]});
                }
            }
      });
    }

  protected:
    using Stencil = std::array<unsigned int, n_nodes>;

    /// The groups of nodes, the same on all ranks. For now every rank has all nodes and goes over
    /// all stencils, so that sums do not depend on the number of ranks.
    std::vector<Stencil> stencils;

    MPI_Comm communicator = MPI_COMM_WORLD;

  private:
    static constexpr int n = n_nodes * dim;

    const Force &
    force() const
    {
      return static_cast<const Force &>(*this);
    }

    template <typename Number, typename Field>
    std::array<std::array<Number, dim>, n_nodes>
    at(const Field &field, const PointBatch &batch) const
    {
      std::array<std::array<Number, dim>, n_nodes> result;
      for (int k = 0; k < n_nodes; ++k)
        for (int a = 0; a < dim; ++a)
          {
            Lanes values;
            for (unsigned int lane = 0; lane < batch.index.size(); ++lane)
              values.set(lane, field[stencils[batch.index[lane]][k]][a]);
            result[k][a] = Number(values);
          }
      return result;
    }

    /// The derivatives of the energies by all coordinates, and along a direction.
    auto
    slopes_along(const Positions<dim> &X,
                 const PointBatch &batch,
                 const std::array<std::array<Lanes, dim>, n_nodes> &direction) const
    {
      using Along  = Dual<1, Lanes>;
      using Number = Dual<n, Along>;
      auto places  = at<Number>(X, batch);
      for (int k = 0; k < n_nodes; ++k)
        for (int a = 0; a < dim; ++a)
          {
            places[k][a].value.slope[0]     = direction[k][a];
            places[k][a].slope[k * dim + a] = Along(Lanes(1.));
          }
      return force().stencil_energy(places, batch);
    }

    std::pair<std::size_t, std::size_t>
    part_of_this_rank() const
    {
      const std::size_t n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator),
                        rank    = dealii::Utilities::MPI::this_mpi_process(communicator);
      return {stencils.size() * rank / n_ranks, stencils.size() * (rank + 1) / n_ranks};
    }

    /// The last batch repeats its last stencil.
    template <typename Action>
    static void
    for_each_batch(const std::size_t first, const std::size_t last, const Action &action)
    {
      constexpr unsigned int lanes = Lanes::n;
      for (std::size_t begin = first; begin < last; begin += lanes)
        {
          PointBatch batch;
          for (unsigned int lane = 0; lane < lanes; ++lane)
            batch.index[lane] = std::min(begin + lane, last - 1);
          action(batch, std::min<std::size_t>(lanes, last - begin));
        }
    }
  };
} // namespace feib

#endif
