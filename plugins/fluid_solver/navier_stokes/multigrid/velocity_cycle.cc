// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/velocity_cycle.h"

#include "multigrid/spectrum.h"

#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparse_matrix.h>

#include <cmath>

namespace feib
{
  namespace
  {
    // Higher degrees save an iteration at most, and no time.
    template <int dim>
    constexpr unsigned int smoother_degree = 2 * dim;
    template <int dim>
    constexpr double smoother_range = 4 * dim - 2;

    // Where the spectrum of D^{-1} A is within this, Chebyshev's iteration brings errors down to
    // the accuracy for no more than a cycle takes.
    constexpr double well_conditioned = 25, accuracy = .02;
  } // namespace


  template <int dim>
  VelocityCycle<dim>::VelocityCycle(Hierarchy<dim> &hierarchy)
    : hierarchy(hierarchy)
    , levels(hierarchy.size())
  {
    for (unsigned int l = 0; l < levels.size(); ++l)
      for (auto *v : {&levels[l].u, &levels[l].f, &levels[l].product, &levels[l].step})
        hierarchy[l].reinit_velocity(*v);
  }


  template <int dim>
  void
  VelocityCycle<dim>::set_form(const VelocityForm &wanted, const std::vector<bool> &coarser_first)
  {
    form = wanted;
    factor.reset();
    for (last_level = 0; true; ++last_level)
      {
        Level &level              = levels[last_level];
        const auto [lower, upper] = spectrum(hierarchy[last_level], form);
        const double largest      = 1.1 * upper;
        level.smoother            = {largest / smoother_range<dim>, largest, smoother_degree<dim>};
        hierarchy[last_level].inverse_diagonal(form, false, level.inverse_diagonal);
        level.smoother_solves = largest <= well_conditioned * lower;
        if (level.smoother_solves)
          {
            const double root    = std::sqrt(largest / lower);
            level.smoother.lower = lower;
            level.smoother.degree =
              std::ceil(std::log(2 / accuracy) / std::log((root + 1) / (root - 1)));
            if (!coarser_first[last_level])
              return;
          }
        if (last_level + 1 == levels.size())
          {
            if (!level.smoother_solves)
              factorize();
            return;
          }
      }
  }


  template <int dim>
  void
  VelocityCycle<dim>::factorize()
  {
    constexpr unsigned int n = MultigridLevel<dim>::n, n_velocity = dim * n,
                           lanes    = MultigridLevel<dim>::lanes;
    const MultigridLevel<dim> &mesh = hierarchy[last_level];
    const unsigned int n_unknowns   = levels[last_level].u.locally_owned_size();
    dealii::DynamicSparsityPattern dynamic(n_unknowns);
    for (unsigned int i = 0; i < n_unknowns; ++i)
      dynamic.add(i, i);
    const auto for_entries = [&](const auto &action) {
      for (unsigned int b = 0; b < mesh.n_batches(); ++b)
        {
          const VelocityFormMatrix<dim> matrix(form, mesh.cell_size(b));
          for (unsigned int l = 0; l < mesh.n_filled(b); ++l)
            for (unsigned int i = 0; i < n_velocity; ++i)
              for (unsigned int j = 0; j < n_velocity; ++j)
                {
                  const unsigned int row    = mesh.nodes(b)[i % n * lanes + l] + i / n,
                                     column = mesh.nodes(b)[j % n * lanes + l] + j / n;
                  if (matrix.entry[i][j] != 0 && !mesh.inactive(row) && !mesh.inactive(column))
                    action(row, column, matrix.entry[i][j]);
                }
        }
    };
    for_entries([&](const auto row, const auto column, double) { dynamic.add(row, column); });
    dealii::SparsityPattern pattern;
    pattern.copy_from(dynamic);
    dealii::SparseMatrix<double> matrix(pattern);
    for_entries([&](const auto row, const auto column, const double value) {
      matrix.add(row, column, value);
    });
    for (unsigned int i = 0; i < n_unknowns; ++i)
      if (mesh.inactive(i))
        matrix.set(i, i, 1.);
    factor = std::make_unique<dealii::SparseDirectUMFPACK>();
    factor->initialize(matrix);
  }


  template <int dim>
  void
  VelocityCycle<dim>::multiply(const unsigned int l, LevelVector<float> &u)
  {
    hierarchy[l].expand(u);
    hierarchy[l].apply_velocity_form(form, u, levels[l].product);
  }


  template <int dim>
  void
  VelocityCycle<dim>::smooth(const unsigned int l, const bool from_zero)
  {
    Level &level         = levels[l];
    const unsigned int n = level.u.locally_owned_size();
    const auto next      = [&](const double c, const double s) {
      multiply(l, level.u);
      step_with_diagonal(n,
                         c,
                         s,
                         level.inverse_diagonal.begin(),
                         level.f.begin(),
                         level.product.begin(),
                         level.step.begin(),
                         level.u.begin());
    };
    const auto first = [&](const double s) {
      if (!from_zero)
        return next(0, s);
      const float *inverse = level.inverse_diagonal.begin(), *f = level.f.begin();
      float *d = level.step.begin(), *u = level.u.begin();
      for (unsigned int i = 0; i < n; ++i)
        u[i] = d[i] = float(s) * inverse[i] * f[i];
    };
    level.smoother.iterate(first, next);
  }


  template <int dim>
  void
  VelocityCycle<dim>::apply(const unsigned int l)
  {
    Level &level = levels[l];
    if (factor && l + 1 == levels.size())
      {
        dealii::Vector<double> values(level.f.locally_owned_size());
        std::copy_n(level.f.begin(), values.size(), values.begin());
        factor->solve(values);
        std::copy_n(values.begin(), values.size(), level.u.begin());
        return;
      }
    smooth(l, true);
    if (level.smoother_solves)
      return;
    Level &coarse = levels[l + 1];
    multiply(l, level.u);
    const unsigned int n = level.u.locally_owned_size();
    for (unsigned int i = 0; i < n; ++i)
      level.product.begin()[i] = level.f.begin()[i] - level.product.begin()[i];
    hierarchy.transfer(l).restrict_velocity(level.product, coarse.f);
    hierarchy[l + 1].condense(coarse.f);
    apply(l + 1);
    hierarchy[l + 1].expand(coarse.u);
    hierarchy.transfer(l).prolongate_velocity(coarse.u, level.u);
    smooth(l, false);
  }


  template class VelocityCycle<2>;
  template class VelocityCycle<3>;
} // namespace feib
