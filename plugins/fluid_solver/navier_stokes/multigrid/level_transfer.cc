// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/level_transfer.h"

#include <deal.II/base/mpi.h>

#include <algorithm>

namespace feib
{
  namespace
  {
    /// Along direction @p a, from 3 to 5 values (or, transposed, back): the directions before have
    /// 5 already, those after still 3.
    template <int dim, unsigned int a, bool transpose, typename V>
    inline void
    interpolate_line(const V *in, V *out)
    {
      constexpr unsigned int below = power(5, a), above = power(3, dim - 1 - a);
      for (unsigned int high = 0; high < above; ++high)
        for (unsigned int low = 0; low < below; ++low)
          {
            if (!transpose)
              for (unsigned int q = 0; q < 5; ++q)
                {
                  V sum = {};
                  for (unsigned int i = 0; i < 3; ++i)
                    if (quarters[q][i] != 0)
                      sum += float(quarters[q][i]) * in[(high * 3 + i) * below + low];
                  out[(high * 5 + q) * below + low] = sum;
                }
            else
              for (unsigned int i = 0; i < 3; ++i)
                {
                  V sum = {};
                  for (unsigned int q = 0; q < 5; ++q)
                    if (quarters[q][i] != 0)
                      sum += float(quarters[q][i]) * in[(high * 5 + q) * below + low];
                  out[(high * 3 + i) * below + low] = sum;
                }
          }
    }

    template <int dim, bool transpose, typename V>
    inline void
    interpolate(const V *in, V *out)
    {
      constexpr unsigned int most = power(5, dim);
      if constexpr (dim == 2)
        {
          V between[most];
          interpolate_line<2, transpose ? 1 : 0, transpose>(in, between);
          interpolate_line<2, transpose ? 0 : 1, transpose>(between, out);
        }
      else
        {
          V between[most], more[most];
          interpolate_line<3, transpose ? 2 : 0, transpose>(in, between);
          interpolate_line<3, 1, transpose>(between, more);
          interpolate_line<3, transpose ? 0 : 2, transpose>(more, out);
        }
    }
  } // namespace


  template <int dim>
  LevelTransfer<dim>::LevelTransfer(const LevelSpace<dim> &fine,
                                    const LevelSpace<dim> &coarse,
                                    const LatticeCells<dim> &coarser,
                                    const std::vector<Family> &families,
                                    const MPI_Comm world)
    : sum_over(coarse.is_replicated() && !fine.is_replicated() ? world : MPI_COMM_NULL)
  {
    const unsigned int rank  = dealii::Utilities::MPI::this_mpi_process(world);
    const unsigned int begin = fine.is_replicated() ? 0 : coarser.first(rank);
    const unsigned int end =
      fine.is_replicated() ? coarser.cells().size() : coarser.first(rank + 1);
    for (const bool refined : {false, true})
      {
        std::vector<unsigned int> chosen;
        for (unsigned int c = begin; c < end; ++c)
          if (families[c].refined == refined)
            chosen.push_back(c);
        for (unsigned int first = 0; first < chosen.size(); first += lanes)
          {
            const auto last = std::min<std::size_t>(first + lanes, chosen.size());
            batches.push_back(make_batch(fine,
                                         coarse,
                                         coarser,
                                         families,
                                         {chosen.begin() + first, chosen.begin() + last},
                                         refined));
          }
      }
    fine.reinit_velocity(node_weights);
    fine.reinit_velocity(fine_velocity);
    fine.reinit_pressure(fine_pressure);
    find_node_weights(fine);
  }


  template <int dim>
  typename LevelTransfer<dim>::Batch
  LevelTransfer<dim>::make_batch(const LevelSpace<dim> &fine,
                                 const LevelSpace<dim> &coarse,
                                 const LatticeCells<dim> &coarser,
                                 const std::vector<Family> &families,
                                 const std::vector<unsigned int> &cells,
                                 const bool refined)
  {
    const unsigned int parts = refined ? 4 : 2, n_nodes = power(parts + 1, dim),
                       n_children = refined ? power(2, dim) : 1;
    Batch batch;
    batch.refined = refined;
    batch.filled  = cells.size();
    batch.coarse_nodes.resize(n * lanes);
    batch.coarse_pressures.resize(n_pressure * lanes);
    batch.fine_nodes.resize(n_nodes * lanes);
    batch.fine_pressures.resize(n_children * n_pressure * lanes);
    for (unsigned int l = 0; l < lanes; ++l)
      {
        const unsigned int c    = cells[std::min(l, batch.filled - 1)];
        const unsigned int slot = coarse.slot(c);
        for (unsigned int i = 0; i < n; ++i)
          batch.coarse_nodes[i * lanes + l] = coarse.node(slot, i);
        for (unsigned int k = 0; k < n_pressure; ++k)
          batch.coarse_pressures[k * lanes + l] = coarse.pressure(slot, k);
        for (unsigned int i = 0; i < n_nodes; ++i)
          batch.fine_nodes[i * lanes + l] =
            fine.node_at(coarser.cells()[c].place(i, parts), coarser.lattice());
        for (unsigned int child = 0; child < n_children; ++child)
          for (unsigned int k = 0; k < n_pressure; ++k)
            batch.fine_pressures[(child * n_pressure + k) * lanes + l] =
              fine.local_pressure(families[c].children[child], k);
      }
    return batch;
  }


  template <int dim>
  void
  LevelTransfer<dim>::find_node_weights(const LevelSpace<dim> &fine)
  {
    for (const Batch &batch : batches)
      for (unsigned int i = 0; i < batch.fine_nodes.size(); ++i)
        if (i % lanes < batch.filled)
          for (unsigned int a = 0; a < dim; ++a)
            node_weights.local_element(batch.fine_nodes[i] + a) += 1;
    node_weights.compress(dealii::VectorOperation::add);
    for (unsigned int i = 0; i < node_weights.locally_owned_size(); ++i)
      node_weights.local_element(i) = fine.inactive(i) || node_weights.local_element(i) == 0
                                        ? 0
                                        : 1 / node_weights.local_element(i);
    node_weights.update_ghost_values();
  }


  template <int dim>
  void
  LevelTransfer<dim>::prolongate_velocity(const LevelVector<float> &coarse,
                                          LevelVector<float> &fine)
  {
    using V             = feib::Batch<float>::Values;
    fine_velocity       = 0;
    const float *from   = coarse.begin();
    const float *weight = node_weights.begin();
    float *to           = fine_velocity.begin();
    for (const Batch &batch : batches)
      for (unsigned int a = 0; a < dim; ++a)
        {
          V in[n], out[n_fine];
          for (unsigned int i = 0; i < n; ++i)
            in[i] = gather(from + a, &batch.coarse_nodes[i * lanes]);
          if (batch.refined)
            interpolate<dim, false>(in, out);
          else
            std::copy_n(in, n, out);
          for (unsigned int i = 0; i < batch.n_fine_nodes(); ++i)
            for (unsigned int l = 0; l < batch.filled; ++l)
              {
                const unsigned int k = batch.fine_nodes[i * lanes + l] + a;
                to[k] += weight[k] * out[i][l];
              }
        }
    fine_velocity.compress(dealii::VectorOperation::add);
    for (unsigned int i = 0; i < fine.locally_owned_size(); ++i)
      fine.begin()[i] += to[i];
  }


  template <int dim>
  void
  LevelTransfer<dim>::restrict_velocity(LevelVector<float> &fine, LevelVector<float> &coarse) const
  {
    using V = feib::Batch<float>::Values;
    fine.update_ghost_values();
    coarse              = 0;
    const float *from   = fine.begin();
    const float *weight = node_weights.begin();
    float *to           = coarse.begin();
    for (const Batch &batch : batches)
      for (unsigned int a = 0; a < dim; ++a)
        {
          V in[n_fine], out[n];
          for (unsigned int i = 0; i < batch.n_fine_nodes(); ++i)
            in[i] = gather(from + a, &batch.fine_nodes[i * lanes]) *
                    gather(weight + a, &batch.fine_nodes[i * lanes]);
          if (batch.refined)
            interpolate<dim, true>(in, out);
          else
            std::copy_n(in, n, out);
          for (unsigned int i = 0; i < n; ++i)
            scatter_add(out[i], &batch.coarse_nodes[i * lanes], batch.filled, to + a);
        }
    if (sum_over != MPI_COMM_NULL)
      sum(coarse);
  }


  // A linear function of the parent in a child: with c = -1, 1 for the halves, the value at the
  // child's centre and half the slopes.
  template <int dim>
  void
  LevelTransfer<dim>::prolongate_pressure(const LevelVector<float> &coarse,
                                          LevelVector<float> &fine)
  {
    using V           = feib::Batch<float>::Values;
    fine_pressure     = 0;
    const float *from = coarse.begin();
    float *to         = fine_pressure.begin();
    for (const Batch &batch : batches)
      {
        V in[n_pressure];
        for (unsigned int k = 0; k < n_pressure; ++k)
          in[k] = gather(from, &batch.coarse_pressures[k * lanes]);
        for (unsigned int child = 0; child < batch.n_children(); ++child)
          {
            V out[n_pressure];
            std::copy_n(in, n_pressure, out);
            if (batch.refined)
              for (unsigned int a = 0; a < dim; ++a)
                {
                  out[0] += (child >> a & 1 ? 1.f : -1.f) * child_slope * in[a + 1];
                  out[a + 1] = .5f * in[a + 1];
                }
            for (unsigned int k = 0; k < n_pressure; ++k)
              scatter_add(out[k],
                          &batch.fine_pressures[(child * n_pressure + k) * lanes],
                          batch.filled,
                          to);
          }
      }
    fine_pressure.compress(dealii::VectorOperation::add);
    for (unsigned int i = 0; i < fine.locally_owned_size(); ++i)
      fine.begin()[i] += to[i];
  }


  template <int dim>
  void
  LevelTransfer<dim>::restrict_pressure(LevelVector<float> &fine, LevelVector<float> &coarse) const
  {
    using V = feib::Batch<float>::Values;
    fine.update_ghost_values();
    coarse            = 0;
    const float *from = fine.begin();
    float *to         = coarse.begin();
    for (const Batch &batch : batches)
      {
        V out[n_pressure] = {};
        for (unsigned int child = 0; child < batch.n_children(); ++child)
          {
            V in[n_pressure];
            for (unsigned int k = 0; k < n_pressure; ++k)
              in[k] = gather(from, &batch.fine_pressures[(child * n_pressure + k) * lanes]);
            if (batch.refined)
              for (unsigned int a = 0; a < dim; ++a)
                out[a + 1] += .5f * in[a + 1] + (child >> a & 1 ? 1.f : -1.f) * child_slope * in[0];
            else
              for (unsigned int a = 0; a < dim; ++a)
                out[a + 1] += in[a + 1];
            out[0] += in[0];
          }
        for (unsigned int k = 0; k < n_pressure; ++k)
          scatter_add(out[k], &batch.coarse_pressures[k * lanes], batch.filled, to);
      }
    if (sum_over != MPI_COMM_NULL)
      sum(coarse);
  }


  template <int dim>
  void
  LevelTransfer<dim>::sum(LevelVector<float> &v) const
  {
    MPI_Allreduce(MPI_IN_PLACE, v.begin(), v.locally_owned_size(), MPI_FLOAT, MPI_SUM, sum_over);
  }


  template class LevelTransfer<2>;
  template class LevelTransfer<3>;
} // namespace feib
