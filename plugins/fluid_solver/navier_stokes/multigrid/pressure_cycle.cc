// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/pressure_cycle.h"

#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparse_matrix.h>

#include <algorithm>
#include <cstdint>

namespace feib
{
  namespace
  {
    constexpr unsigned int smoother_degree = 3;
    constexpr double smoother_range        = 4;

    // M^{-1} ~ (1 + sharpness) Ml^{-1} - sharpness Ml^{-1} M Ml^{-1}: of B M^{-1} B^T, in a
    // periodic box, B Ml^{-1} B^T has 1/3.1 to 1 (1/3.9 to 1 in 3D), this 1/1.5 to 1.04 (1/1.9
    // to 1.04). The largest eigenvalue with the blocks is 1.75 (1.9) times as large on cubes, and
    // less on longer cells.
    constexpr double sharpness = 1.5, sharp_bound = 1.9;


    /// A pseudo-random pressure, which does not depend on the number of ranks.
    template <int dim>
    void
    fill(const LevelSpace<dim> &space, LevelVector<float> &p)
    {
      constexpr unsigned int lanes = LevelSpace<dim>::lanes;
      space.reinit_pressure(p);
      for (unsigned int b = 0; b < space.n_batches(); ++b)
        for (unsigned int l = 0; l < space.n_filled(b); ++l)
          for (unsigned int k = 0; k < LevelSpace<dim>::n_pressure; ++k)
            {
              const unsigned int slot = b * lanes + l;
              std::uint64_t x         = (space.cell_key(slot) + 1) * 0x9e3779b97f4a7c15 + k;
              x                       = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
              x                       = (x ^ (x >> 27)) * 0x94d049bb133111eb;
              p.begin()[space.pressure(slot, k)] = double(x >> 11) / (1ull << 52) - 1.;
            }
    }
  } // namespace


  template <int dim>
  PressureCycle<dim>::PressureCycle(Hierarchy<dim> &hierarchy, const bool enclosed)
    : hierarchy(hierarchy)
    , enclosed(enclosed)
    , levels(hierarchy.size())
  {
    for (unsigned int l = 0; l < levels.size(); ++l)
      {
        Level &level = levels[l];
        for (auto *p : {&level.p, &level.g, &level.product, &level.step})
          hierarchy[l].reinit_pressure(*p);
        hierarchy[l].reinit_velocity(level.flux);
        hierarchy[l].inverse_diagonal({1., 0.}, true, level.inverse_mass);
        hierarchy[l].invert_blocks(level.inverse_mass, level.inverse_blocks);
      }
    hierarchy[0].reinit_velocity(mass_product);
    find_smoothers();
    factorize();
  }


  template <int dim>
  void
  PressureCycle<dim>::find_smoothers()
  {
    // The upper end of the spectrum is the same on all levels, to 4 % on uniform and locally
    // refined meshes: large ones are not asked.
    constexpr unsigned int many = 1000;
    double largest              = 0;
    for (unsigned int l = levels.size(); l-- > 0;)
      {
        const bool asked   = l + 1 == levels.size() || hierarchy.n_cells(l) <= many;
        const double here  = asked ? 1.15 * largest_eigenvalue(l) : largest;
        levels[l].smoother = {here / smoother_range, here, smoother_degree};
        largest            = std::max(largest, here);
      }
  }


  template <int dim>
  double
  PressureCycle<dim>::largest_eigenvalue(const unsigned int l)
  {
    // By the power method.
    Level &level = levels[l];
    fill(hierarchy[l], level.p);
    double largest = 1;
    for (unsigned int i = 0; i < 12; ++i)
      {
        const double norm = level.p.l2_norm();
        if (i > 0)
          largest = norm;
        level.p /= norm;
        multiply(l, level.p, false);
        level.g.swap(level.product);
        level.p    = 0;
        level.step = 0;
        step(level, l, 0, 1, nullptr);
      }
    return largest;
  }


  template <int dim>
  void
  PressureCycle<dim>::factorize()
  {
    constexpr unsigned int n = MultigridLevel<dim>::n, n_pressure = MultigridLevel<dim>::n_pressure,
                           lanes    = MultigridLevel<dim>::lanes;
    const Level &level              = levels.back();
    const MultigridLevel<dim> &mesh = hierarchy[levels.size() - 1];
    // Of each velocity unknown, what the pressures do to it.
    std::vector<std::vector<std::pair<unsigned int, double>>> columns(
      level.flux.locally_owned_size());
    for (unsigned int b = 0; b < mesh.n_batches(); ++b)
      {
        const auto size     = mesh.cell_size(b);
        const double volume = cell_volume(size);
        for (unsigned int l = 0; l < mesh.n_filled(b); ++l)
          for (unsigned int i = 0; i < n; ++i)
            for (unsigned int a = 0; a < dim; ++a)
              for (unsigned int k = 0; k < n_pressure; ++k)
                columns[mesh.nodes(b)[i * lanes + l] + a].emplace_back(
                  mesh.pressure(b * lanes + l, k),
                  volume / size[a] * divergence_table<dim>.entry[a][k][i]);
      }
    const unsigned int n_unknowns = level.p.locally_owned_size();
    dealii::DynamicSparsityPattern dynamic(n_unknowns);
    for (unsigned int i = 0; i < n_unknowns; ++i)
      dynamic.add(i, i);
    for (const auto &column : columns)
      for (const auto &[row, unused] : column)
        for (const auto &[other, unused_too] : column)
          dynamic.add(row, other);
    dealii::SparsityPattern pattern;
    pattern.copy_from(dynamic);
    dealii::SparseMatrix<double> matrix(pattern);
    for (unsigned int v = 0; v < columns.size(); ++v)
      for (const auto &[row, value] : columns[v])
        for (const auto &[other, other_value] : columns[v])
          matrix.add(row, other, level.inverse_mass.local_element(v) * value * other_value);
    // In an enclosed flow constants are in the kernel, on very coarse meshes more; and there are
    // places without cells.
    double largest = 0;
    for (unsigned int i = 0; i < n_unknowns; ++i)
      largest = std::max(largest, matrix(i, i));
    for (unsigned int i = 0; i < n_unknowns; ++i)
      matrix.add(i, i, matrix(i, i) > 0 ? 1e-9 * largest : largest);
    factor = std::make_unique<dealii::SparseDirectUMFPACK>();
    factor->initialize(matrix);
  }


  template <int dim>
  void
  PressureCycle<dim>::multiply(const unsigned int l, const LevelVector<float> &p, const bool sharp)
  {
    Level &level                     = levels[l];
    const MultigridLevel<dim> &space = hierarchy[l];
    space.apply_gradient(p, level.flux);
    const unsigned int n = level.flux.locally_owned_size();
    float *flux          = level.flux.begin();
    const float *weight  = level.inverse_mass.begin();
    for (unsigned int i = 0; i < n; ++i)
      flux[i] *= weight[i];
    space.expand(level.flux);
    if (sharp)
      {
        space.apply_velocity_form({1., 0.}, level.flux, mass_product);
        const float *product = mass_product.begin();
        for (unsigned int i = 0; i < n; ++i)
          flux[i] += float(sharpness) * (flux[i] - weight[i] * product[i]);
        space.expand(level.flux);
      }
    space.apply_divergence(level.flux, level.product);
  }


  template <int dim>
  void
  PressureCycle<dim>::step(Level &level,
                           const unsigned int l,
                           const double c,
                           const double s,
                           const float *product) const
  {
    step_with_blocks<dim>(hierarchy[l].n_batches(),
                          c,
                          s,
                          level.inverse_blocks.begin(),
                          level.g.begin(),
                          product,
                          level.step.begin(),
                          level.p.begin());
  }


  template <int dim>
  void
  PressureCycle<dim>::smooth(const unsigned int l,
                             const Chebyshev &smoother,
                             const bool from_zero,
                             const bool sharp)
  {
    Level &level    = levels[l];
    const auto next = [&](const double c, const double s) {
      multiply(l, level.p, sharp);
      step(level, l, c, s, level.product.begin());
    };
    const auto first = [&](const double s) {
      if (!from_zero)
        return next(0, s);
      level.p    = 0;
      level.step = 0;
      step(level, l, 0, s, nullptr);
    };
    smoother.iterate(first, next);
  }


  template <int dim>
  void
  PressureCycle<dim>::solve_coarsest()
  {
    Level &level                     = levels.back();
    const MultigridLevel<dim> &space = hierarchy[levels.size() - 1];
    dealii::Vector<double> values(level.g.locally_owned_size());
    std::copy_n(level.g.begin(), values.size(), values.begin());
    if (enclosed)
      {
        // The sum over all cells vanishes up to round-off.
        const auto for_constants = [&](const auto &action) {
          for (unsigned int b = 0; b < space.n_batches(); ++b)
            for (unsigned int l = 0; l < space.n_filled(b); ++l)
              action(values[space.pressure(b * space.lanes + l, 0)]);
        };
        double sum = 0, n_cells = 0;
        for_constants([&](const double value) {
          sum += value;
          n_cells += 1;
        });
        for_constants([&](double &value) { value -= sum / n_cells; });
      }
    factor->solve(values);
    std::copy_n(values.begin(), values.size(), level.p.begin());
  }


  template <int dim>
  void
  PressureCycle<dim>::apply(const unsigned int l, const bool sharp)
  {
    if (l + 1 == levels.size())
      return solve_coarsest();
    Level &level = levels[l];
    smooth(l, level.smoother, true, false);
    Level &coarse = levels[l + 1];
    multiply(l, level.p, false);
    const unsigned int n = level.p.locally_owned_size();
    for (unsigned int i = 0; i < n; ++i)
      level.product.begin()[i] = level.g.begin()[i] - level.product.begin()[i];
    hierarchy.transfer(l).restrict_pressure(level.product, coarse.g);
    apply(l + 1, false);
    hierarchy.transfer(l).prolongate_pressure(coarse.p, level.p);
    Chebyshev last_smoother = level.smoother;
    if (sharp)
      {
        last_smoother.lower *= sharp_bound;
        last_smoother.upper *= sharp_bound;
      }
    smooth(l, last_smoother, false, sharp);
  }


  template class PressureCycle<2>;
  template class PressureCycle<3>;
} // namespace feib
