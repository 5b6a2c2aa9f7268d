// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/multigrid_level.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace feib
{
  namespace
  {
    template <typename Number>
    inline const typename Batch<Number>::Values *
    aligned(const Number *values)
    {
      return reinterpret_cast<const typename Batch<Number>::Values *>(values);
    }

    template <typename Number>
    inline typename Batch<Number>::Values *
    aligned(Number *values)
    {
      return reinterpret_cast<typename Batch<Number>::Values *>(values);
    }


    /// The inverse of a symmetric positive definite matrix, by Gauss and Jordan; of what a constant
    /// leaves singular, something finite.
    template <unsigned int n>
    void
    invert(const double (&matrix)[n][n], double (&inverse)[n][n])
    {
      double block[n][2 * n] = {};
      for (unsigned int k = 0; k < n; ++k)
        {
          std::copy_n(matrix[k], n, block[k]);
          block[k][n + k] = 1;
        }
      for (unsigned int k = 0; k < n; ++k)
        {
          const double pivot = block[k][k];
          for (unsigned int j = 0; j < 2 * n; ++j)
            block[k][j] = pivot > 0 ? block[k][j] / pivot : 0.;
          for (unsigned int i = 0; i < n; ++i)
            if (i != k)
              {
                const double factor = block[i][k];
                for (unsigned int j = 0; j < 2 * n; ++j)
                  block[i][j] -= factor * block[k][j];
              }
        }
      for (unsigned int k = 0; k < n; ++k)
        std::copy_n(block[k] + n, n, inverse[k]);
    }
  } // namespace


  template <int dim>
  template <typename Number>
  void
  MultigridLevel<dim>::apply_velocity_form(const VelocityForm &form,
                                           const LevelVector<Number> &u,
                                           LevelVector<Number> &result) const
  {
    using V                      = typename Batch<Number>::Values;
    constexpr unsigned int width = Batch<Number>::lanes;
    result                       = 0;
    const Number *from           = u.begin();
    Number *to                   = result.begin();
    for (unsigned int b = 0; b < n_batches(); ++b)
      for (unsigned int part = 0; part < n_filled(b); part += width)
        {
          const unsigned int filled   = std::min(width, n_filled(b) - part);
          const unsigned int *indices = nodes(b) + part;
          const auto gather_component = [&](const unsigned int a, V *local) {
            for (unsigned int i = 0; i < n; ++i)
              local[i] = gather(from + a, indices + i * lanes);
          };
          const auto scatter_component = [&](const unsigned int a, const V *product) {
            for (unsigned int i = 0; i < n; ++i)
              scatter_add(product[i], indices + i * lanes, filled, to + a);
          };
          if (form.couples())
            {
              V local[dim * n], product[dim * n];
              for (unsigned int a = 0; a < dim; ++a)
                gather_component(a, local + a * n);
              feib::apply_velocity_form<dim, Number>(form, cell_size(b), local, product);
              for (unsigned int a = 0; a < dim; ++a)
                scatter_component(a, product + a * n);
            }
          else
            {
              // All components are alike, and one at a time stays in the registers.
              const CellFactors<dim, Number> factors(form, cell_size(b), 0);
              V local[n], product[n];
              for (unsigned int a = 0; a < dim; ++a)
                {
                  gather_component(a, local);
                  apply_helmholtz<dim>(factors, local, product);
                  scatter_component(a, product);
                }
            }
        }
    this->condense(result);
  }


  template <int dim>
  void
  MultigridLevel<dim>::apply_gradient(const LevelVector<float> &p, LevelVector<float> &result) const
  {
    using V           = Batch<float>::Values;
    result            = 0;
    const V *pressure = aligned(p.begin());
    float *to         = result.begin();
    for (unsigned int b = 0; b < n_batches(); ++b)
      {
        const Size size = cell_size(b);
        for_directions<dim>([&](const auto a) {
          V product[n];
          feib::apply_gradient<dim, a>(float(cell_volume(size) / size[a.value]),
                                       pressure + b * n_pressure,
                                       product);
          for (unsigned int i = 0; i < n; ++i)
            scatter_add(product[i], nodes(b) + i * lanes, n_filled(b), to + a);
        });
      }
    this->condense(result);
  }


  template <int dim>
  void
  MultigridLevel<dim>::apply_divergence(const LevelVector<float> &u,
                                        LevelVector<float> &result) const
  {
    using V           = Batch<float>::Values;
    const float *from = u.begin();
    V *to             = aligned(result.begin());
    for (unsigned int b = 0; b < n_batches(); ++b)
      {
        const Size size   = cell_size(b);
        V sum[n_pressure] = {};
        for_directions<dim>([&](const auto a) {
          V local[n];
          for (unsigned int i = 0; i < n; ++i)
            local[i] = gather(from + a, nodes(b) + i * lanes);
          feib::add_divergence<dim, a>(float(cell_volume(size) / size[a.value]), local, sum);
        });
        for (unsigned int k = 0; k < n_pressure; ++k)
          to[b * n_pressure + k] = sum[k];
      }
  }


  template <int dim>
  void
  MultigridLevel<dim>::add_inverse_pressure_mass(const float factor,
                                                 const LevelVector<float> &g,
                                                 LevelVector<float> &result) const
  {
    for (unsigned int b = 0; b < n_batches(); ++b)
      {
        const float scale = factor / cell_volume(cell_size(b));
        for (unsigned int i = b * n_pressure * lanes; i < (b + 1) * n_pressure * lanes; ++i)
          result.begin()[i] += scale * g.begin()[i];
      }
  }


  template <int dim>
  void
  MultigridLevel<dim>::inverse_diagonal(const VelocityForm &form,
                                        const bool row_sums,
                                        LevelVector<float> &result) const
  {
    this->reinit_velocity(result);
    double diagonal[dim][n];
    std::optional<VelocityFormMatrix<dim>> matrix;
    for (unsigned int b = 0; b < n_batches(); ++b)
      {
        // Cells of one size are neighbours.
        if (b == 0 || cell_size(b) != cell_size(b - 1))
          {
            matrix.emplace(form, cell_size(b));
            for (unsigned int a = 0; a < dim; ++a)
              for (unsigned int j = 0; j < n; ++j)
                {
                  const double *row = matrix->entry[a * n + j];
                  diagonal[a][j] =
                    row_sums ? std::accumulate(row + a * n, row + (a + 1) * n, 0.) : row[a * n + j];
                }
          }
        for (unsigned int l = 0; l < n_filled(b); ++l)
          if (row_sums || !this->has_hanging_nodes(b * lanes + l))
            for (unsigned int i = 0; i < n; ++i)
              for (unsigned int a = 0; a < dim; ++a)
                result.begin()[nodes(b)[i * lanes + l] + a] += diagonal[a][i];
          else
            for (const auto &[source, column] : this->sources(b * lanes + l))
              for (unsigned int a = 0; a < dim; ++a)
                {
                  double sum = 0;
                  for (unsigned int i = 0; i < n; ++i)
                    if (column[i] != 0)
                      for (unsigned int j = 0; j < n; ++j)
                        sum += column[i] * matrix->entry[a * n + i][a * n + j] * column[j];
                  result.begin()[source + a] += sum;
                }
      }
    if (row_sums)
      this->condense_here(result);
    result.compress(dealii::VectorOperation::add);
    // Where there is nothing, the inverse is not used.
    for (unsigned int i = 0; i < result.locally_owned_size(); ++i)
      result.begin()[i] = this->inactive(i) ? 0.f : 1 / result.begin()[i];
  }


  template <int dim>
  void
  MultigridLevel<dim>::invert_blocks(LevelVector<float> &weights,
                                     dealii::AlignedVector<float> &blocks) const
  {
    weights.update_ghost_values();
    blocks.resize_fast(n_batches() * n_pressure * n_pressure * lanes);
    const auto &table = divergence_table<dim>.entry;
    for (unsigned int b = 0; b < n_batches(); ++b)
      {
        const Size size     = cell_size(b);
        const double volume = cell_volume(size);
        for (unsigned int l = 0; l < lanes; ++l)
          {
            const unsigned int slot              = b * lanes + l;
            double block[n_pressure][n_pressure] = {}, inverse[n_pressure][n_pressure];
            const auto add = [&](const double(&column)[n_pressure], const double weight) {
              for (unsigned int k = 0; k < n_pressure; ++k)
                for (unsigned int m = 0; m < n_pressure; ++m)
                  block[k][m] += weight * column[k] * column[m];
            };
            typename LevelSpace<dim>::Sources sources;
            if (this->has_hanging_nodes(slot))
              sources = this->sources(slot);
            for (unsigned int a = 0; a < dim; ++a)
              if (!this->has_hanging_nodes(slot))
                for (unsigned int i = 0; i < n; ++i)
                  {
                    double column[n_pressure];
                    for (unsigned int k = 0; k < n_pressure; ++k)
                      column[k] = volume / size[a] * table[a][k][i];
                    add(column, weights.begin()[nodes(b)[i * lanes + l] + a]);
                  }
              else
                for (const auto &[source, of_node] : sources)
                  {
                    double column[n_pressure] = {};
                    for (unsigned int i = 0; i < n; ++i)
                      if (of_node[i] != 0)
                        for (unsigned int k = 0; k < n_pressure; ++k)
                          column[k] += of_node[i] * volume / size[a] * table[a][k][i];
                    add(column, weights.begin()[source + a]);
                  }
            invert(block, inverse);
            for (unsigned int k = 0; k < n_pressure; ++k)
              for (unsigned int m = 0; m < n_pressure; ++m)
                blocks[((b * n_pressure + k) * n_pressure + m) * lanes + l] = inverse[k][m];
          }
      }
  }


#define FEIB_INSTANTIATE(dim, Number)                                                 \
  template void MultigridLevel<dim>::apply_velocity_form(const VelocityForm &,        \
                                                         const LevelVector<Number> &, \
                                                         LevelVector<Number> &) const;

  template class MultigridLevel<2>;
  template class MultigridLevel<3>;
  FEIB_INSTANTIATE(2, float)
  FEIB_INSTANTIATE(2, double)
  FEIB_INSTANTIATE(3, float)
  FEIB_INSTANTIATE(3, double)
} // namespace feib
