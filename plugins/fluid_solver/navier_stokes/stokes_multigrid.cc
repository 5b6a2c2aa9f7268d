// SPDX-License-Identifier: LGPL-2.1-or-later
#include "stokes_multigrid.h"

#include <feib/log.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparse_matrix.h>

#include <cmath>
#include <sstream>

namespace feib
{
  namespace
  {
    constexpr unsigned int none = static_cast<unsigned int>(-1);

    // Higher degrees save an iteration at most, and no time.
    template <int dim>
    constexpr unsigned int velocity_degree = 2 * dim;
    template <int dim>
    constexpr double velocity_range        = 4 * dim - 2;
    constexpr unsigned int pressure_degree = 3;
    constexpr double pressure_range        = 4;

    // Where the spectrum of D^{-1} A is within this, Chebyshev's iteration brings errors down to
    // the accuracy for no more than a cycle takes.
    constexpr double well_conditioned = 25, accuracy = .02;

    // M^{-1} ~ (1 + sharpness) Ml^{-1} - sharpness Ml^{-1} M Ml^{-1}: of B M^{-1} B^T, in a
    // periodic box, B Ml^{-1} B^T has 1/3.1 to 1 (1/3.9 to 1 in 3D), this 1/1.5 to 1.04 (1/1.9
    // to 1.04). The largest eigenvalue with the blocks is 1.75 (1.9) times as large on cubes, and
    // less on longer cells.
    constexpr double sharpness = 1.5, sharp_bound = 1.9;

    /// Levels with at most this many cells are held by every rank: there a message costs more than
    /// the work it saves.
    constexpr unsigned int replicate_below = 600;

    /// x += and d = of one step of Chebyshev's iteration with diagonal D: d = c d + s D^{-1} r.
    void
    update(const unsigned int n,
           const float c,
           const float s,
           const float *__restrict inverse_diagonal,
           const float *__restrict f,
           const float *__restrict product,
           float *__restrict d,
           float *__restrict x)
    {
      for (unsigned int i = 0; i < n; ++i)
        {
          d[i] = c * d[i] + s * inverse_diagonal[i] * (f[i] - product[i]);
          x[i] += d[i];
        }
    }

    /// The same with inverse blocks of the cells of a batch.
    template <int dim>
    void
    update_blocks(const unsigned int n_batches,
                  const float c,
                  const float s,
                  const float *blocks,
                  const float *f,
                  const float *product,
                  float *d,
                  float *x)
    {
      constexpr unsigned int n_pressure = dim + 1, lanes = Batch<float>::lanes;
      for (unsigned int b = 0; b < n_batches; ++b)
        {
          const float *block = blocks + b * n_pressure * n_pressure * lanes;
          float r[n_pressure][lanes];
          for (unsigned int k = 0; k < n_pressure; ++k)
            for (unsigned int l = 0; l < lanes; ++l)
              r[k][l] = f[(b * n_pressure + k) * lanes + l] -
                        (product ? product[(b * n_pressure + k) * lanes + l] : 0.f);
          for (unsigned int k = 0; k < n_pressure; ++k)
            {
              float sum[lanes] = {};
              for (unsigned int m = 0; m < n_pressure; ++m)
                for (unsigned int l = 0; l < lanes; ++l)
                  sum[l] += block[(k * n_pressure + m) * lanes + l] * r[m][l];
              for (unsigned int l = 0; l < lanes; ++l)
                {
                  const unsigned int i = (b * n_pressure + k) * lanes + l;
                  d[i]                 = c * d[i] + s * sum[l];
                  x[i] += d[i];
                }
            }
        }
    }

    /// Calls first(1 / theta) and then next(c, s) of Chebyshev's iteration.
    template <class First, class Next>
    void
    iterate(const double lower,
            const double upper,
            const unsigned int degree,
            const First &first,
            const Next &next)
    {
      const double theta = (upper + lower) / 2, delta = (upper - lower) / 2;
      double rho = delta / theta;
      first(1 / theta);
      for (unsigned int k = 1; k < degree; ++k)
        {
          const double rho_next = 1 / (2 * theta / delta - rho);
          next(rho_next * rho, 2 * rho_next / delta);
          rho = rho_next;
        }
    }
  } // namespace


  template <int dim>
  void
  StokesMultigrid<dim>::prepare(const EulerianSpace<dim> &space,
                                const VelocityForm &wanted,
                                const bool augmented)
  {
    const bool new_mesh = revision != space.revision();
    if (new_mesh)
      {
        build_levels(space);
        map_unknowns(space);
        revision = space.revision();
      }
    // (grad u^T, grad v) counts only where viscosity does. The larger eta, the better is S known,
    // and the worse is the condition of A: with these values both cost about as much. On long cells
    // the smoother bears less.
    constexpr double negligible = .005, inertial_eta = dim == 2 ? .1 : .05;
    const double h = levels[0].mesh->smallest_size(), inertia = wanted.alpha * h * h,
                 aspect      = levels[0].mesh->aspect_ratio(),
                 viscous_eta = (dim + 1) / (aspect * aspect);
    const VelocityForm seen{wanted.alpha,
                            wanted.mu,
                            wanted.mu > negligible * inertia ? wanted.nu : 0.,
                            0.,
                            augmented ? std::max(viscous_eta * wanted.mu, inertial_eta * inertia)
                                      : 0.};
    // What lumping the mass does to pressures counts only where inertia does.
    constexpr double dominated = .1;
    inertia_counts             = wanted.mu < dominated * inertia;
    const bool new_form        = seen.alpha != cycled.alpha || seen.mu != cycled.mu ||
                          seen.nu != cycled.nu || seen.eta != cycled.eta;
    form   = wanted;
    cycled = seen;
    if (!new_mesh && !new_form)
      return;

    // Where the spectrum is short, the smoother alone is a solver. Beside walls the Schur
    // complement of a viscous flow has more than S^{-1} knows of.
    direct_velocity = false;
    for (last_velocity = 0; true; ++last_velocity)
      {
        Level &level              = levels[last_velocity];
        const bool last           = last_velocity + 1 == levels.size();
        const double size         = level.mesh->smallest_size();
        const auto [lower, upper] = level.mesh->spectrum(cycled);
        const double largest      = 1.1 * upper;
        level.velocity_smoother   = {largest / velocity_range<dim>, largest, velocity_degree<dim>};
        level.mesh->inverse_diagonal(cycled, false, level.inverse_diagonal);
        level.smoother_solves = largest <= well_conditioned * lower;
        level.coarser_first   = walls && !last && cycled.mu > cycled.alpha * size * size;
        if (level.smoother_solves)
          {
            const double root             = std::sqrt(largest / lower);
            level.velocity_smoother.lower = lower;
            level.velocity_smoother.degree =
              std::ceil(std::log(2 / accuracy) / std::log((root + 1) / (root - 1)));
            if (!level.coarser_first)
              break;
          }
        else if (last)
          {
            direct_velocity = true;
            factorize_velocity();
          }
        if (last)
          break;
        if (level.coarser_first && level.first_u.size() == 0)
          {
            level.mesh->reinit_velocity(level.first_u);
            level.mesh->reinit_pressure(level.first_p);
          }
      }
  }


  template <int dim>
  void
  StokesMultigrid<dim>::build_levels(const EulerianSpace<dim> &space)
  {
    const MPI_Comm communicator = space.communicator();
    const bool parallel         = dealii::Utilities::MPI::n_mpi_processes(communicator) > 1;
    enclosed                    = space.domain().enclosed();
    walls                       = false;
    for (unsigned int a = 0; a < dim; ++a)
      walls = walls || !space.domain().periodic(a);

    std::vector<Lattice<dim>> lattices{Lattice<dim>(space)};
    std::vector<std::vector<typename Lattice<dim>::Family>> families;
    while (lattices.back().coarsens())
      {
        std::vector<typename Lattice<dim>::Family> next_families;
        lattices.push_back(lattices.back().coarsened(next_families));
        families.push_back(std::move(next_families));
      }
    if (parallel && lattices.size() == 1)
      {
        // The coarsest level is solved by every rank alone.
        families.emplace_back(lattices[0].cells().size());
        for (unsigned int c = 0; c < families[0].size(); ++c)
          families[0][c].children[0] = c;
        lattices.push_back(lattices[0]);
      }

    constexpr unsigned int large = dim == 2 ? 10000 : 1000;
    if (lattices.back().cells().size() > large)
      log::warning(
        "the fluid's multigrid ends with " + std::to_string(lattices.back().cells().size()) +
        " cells, which are solved for directly: numbers of cells with more factors of two "
        "are faster");

    levels.clear();
    levels.resize(lattices.size());
    bool replicated = false;
    for (unsigned int l = 0; l < levels.size(); ++l)
      {
        const bool last = l + 1 == levels.size();
        replicated      = replicated ||
                     (parallel && l > 0 && lattices[l].cells().size() <= replicate_below) ||
                     (last && parallel);
        levels[l].mesh = std::make_unique<MultigridLevel<dim>>(lattices[l],
                                                               space.domain(),
                                                               communicator,
                                                               replicated,
                                                               last ? nullptr : &lattices[l + 1],
                                                               last ? nullptr : &families[l]);
        Level &level = levels[l];
        for (auto *v :
             {&level.u, &level.f, &level.velocity_product, &level.velocity_step, &level.flux})
          level.mesh->reinit_velocity(*v);
        for (auto *p : {&level.p, &level.g, &level.pressure_product, &level.pressure_step})
          level.mesh->reinit_pressure(*p);
        level.mesh->inverse_diagonal({1., 0.}, true, level.inverse_mass);
        level.mesh->invert_blocks(level.inverse_mass, level.inverse_blocks);

        if (l > 0)
          levels[l - 1].mesh->connect(*level.mesh, lattices[l], families[l - 1], communicator);
      }
    // The upper end of the spectrum is the same on all levels, to 4 % on uniform and locally
    // refined meshes: large ones are not asked.
    constexpr unsigned int many = 1000;
    Chebyshev largest{0, 0, pressure_degree};
    for (unsigned int l = levels.size(); l-- > 0;)
      {
        Level &level = levels[l];
        if (l + 1 < levels.size() && lattices[l].cells().size() > many)
          level.pressure_smoother = largest;
        else
          set_pressure_smoother(level);
        if (level.pressure_smoother.upper > largest.upper)
          largest = level.pressure_smoother;
      }
    factorize_pressure();
  }


  template <int dim>
  void
  StokesMultigrid<dim>::set_pressure_smoother(Level &level) const
  {
    // The largest eigenvalue of Lp with its blocks, by the power method.
    level.mesh->fill_pressure(level.p);
    double largest = 1;
    for (unsigned int i = 0; i < 12; ++i)
      {
        const double norm = level.p.l2_norm();
        if (i > 0)
          largest = norm;
        level.p /= norm;
        apply_pressure_operator(level, level.p, level.g, false);
        level.p             = 0;
        level.pressure_step = 0;
        update_blocks<dim>(level.mesh->n_batches(),
                           0,
                           1,
                           level.inverse_blocks.begin(),
                           level.g.begin(),
                           nullptr,
                           level.pressure_step.begin(),
                           level.p.begin());
      }
    largest *= 1.15;
    level.pressure_smoother = {largest / pressure_range, largest, pressure_degree};
  }


  template <int dim>
  void
  StokesMultigrid<dim>::map_unknowns(const EulerianSpace<dim> &space)
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes, n_pressure = dim + 1;
    constexpr unsigned int lanes = MultigridLevel<dim>::lanes;
    const Level &finest          = levels[0];
    const auto &partitioner      = *space.velocity.get_partitioner();
    const auto &constraints      = space.constraints();
    space_velocity.assign(finest.u.locally_owned_size(), none);
    level_velocity.assign(space.velocity.locally_owned_size(), none);
    space_pressure.assign(finest.p.locally_owned_size(), none);
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      {
        const unsigned int slot   = finest.mesh->slots()[c];
        const unsigned int *nodes = finest.mesh->nodes(slot / lanes);
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int a = 0; a < dim; ++a)
            {
              const unsigned int unknown = nodes[i * lanes + slot % lanes] + a;
              const unsigned int dof     = space.velocity_dofs(c)[a * n + i];
              if (dof < level_velocity.size() && !finest.mesh->inactive(unknown))
                level_velocity[dof] = unknown;
              if (unknown >= space_velocity.size() || finest.mesh->inactive(unknown) ||
                  space_velocity[unknown] != none)
                continue;
              // Across a periodic boundary, two unknowns of the space are one here.
              unsigned int master = dof;
              const auto global   = partitioner.local_to_global(dof);
              if (constraints.is_constrained(global))
                master = partitioner.global_to_local(
                  constraints.get_constraint_entries(global)->front().first);
              space_velocity[unknown] = master;
            }
        for (unsigned int k = 0; k < n_pressure; ++k)
          space_pressure[(slot / lanes * n_pressure + k) * lanes + slot % lanes] =
            space.pressure_dofs(c)[k];
      }
    for (unsigned int dof = 0; dof < level_velocity.size(); ++dof)
      if (constraints.is_constrained(partitioner.local_to_global(dof)))
        level_velocity[dof] = none;
  }


  // --- the coarsest level

  template <int dim>
  void
  StokesMultigrid<dim>::factorize_pressure()
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes, n_pressure = dim + 1;
    constexpr unsigned int lanes    = MultigridLevel<dim>::lanes;
    const Level &level              = levels.back();
    const MultigridLevel<dim> &mesh = *level.mesh;
    // Of each velocity unknown, what the pressures do to it.
    std::vector<std::vector<std::pair<unsigned int, double>>> columns(level.u.locally_owned_size());
    for (unsigned int b = 0; b < mesh.n_batches(); ++b)
      {
        const auto size     = mesh.cell_size(b);
        const double volume = cell_volume(size);
        for (unsigned int l = 0; l < mesh.n_filled(b); ++l)
          for (unsigned int i = 0; i < n; ++i)
            for (unsigned int a = 0; a < dim; ++a)
              for (unsigned int k = 0; k < n_pressure; ++k)
                columns[mesh.nodes(b)[i * lanes + l] + a].emplace_back(
                  (b * n_pressure + k) * lanes + l,
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
    pressure_factor = std::make_unique<dealii::SparseDirectUMFPACK>();
    pressure_factor->initialize(matrix);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::factorize_velocity()
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes, n_velocity = dim * n;
    constexpr unsigned int lanes    = MultigridLevel<dim>::lanes;
    const Level &level              = levels.back();
    const MultigridLevel<dim> &mesh = *level.mesh;
    const unsigned int n_unknowns   = level.u.locally_owned_size();
    dealii::DynamicSparsityPattern dynamic(n_unknowns);
    for (unsigned int i = 0; i < n_unknowns; ++i)
      dynamic.add(i, i);
    const auto for_entries = [&](const auto &action) {
      for (unsigned int b = 0; b < mesh.n_batches(); ++b)
        {
          double matrix[n_velocity][n_velocity];
          for (unsigned int j = 0; j < n_velocity; ++j)
            {
              double unit_vector[n_velocity] = {};
              unit_vector[j]                 = 1;
              apply_velocity_form<dim, double>(cycled, mesh.cell_size(b), unit_vector, matrix[j]);
            }
          for (unsigned int l = 0; l < mesh.n_filled(b); ++l)
            for (unsigned int i = 0; i < n_velocity; ++i)
              for (unsigned int j = 0; j < n_velocity; ++j)
                {
                  const unsigned int row    = mesh.nodes(b)[i % n * lanes + l] + i / n,
                                     column = mesh.nodes(b)[j % n * lanes + l] + j / n;
                  if (matrix[i][j] != 0 && !mesh.inactive(row) && !mesh.inactive(column))
                    action(row, column, matrix[i][j]);
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
    velocity_factor = std::make_unique<dealii::SparseDirectUMFPACK>();
    velocity_factor->initialize(matrix);
  }


  // --- cycles

  template <int dim>
  void
  StokesMultigrid<dim>::apply_pressure_operator(Level &level,
                                                const LevelVector<float> &p,
                                                LevelVector<float> &result,
                                                const bool sharp) const
  {
    level.mesh->apply_gradient(p, level.flux);
    const unsigned int n = level.flux.locally_owned_size();
    float *flux          = level.flux.begin();
    const float *weight  = level.inverse_mass.begin();
    for (unsigned int i = 0; i < n; ++i)
      flux[i] *= weight[i];
    level.mesh->expand(level.flux);
    if (sharp)
      {
        level.mesh->apply_velocity_form({1., 0.}, level.flux, level.velocity_product);
        const float *product = level.velocity_product.begin();
        for (unsigned int i = 0; i < n; ++i)
          flux[i] += float(sharpness) * (flux[i] - weight[i] * product[i]);
        level.mesh->expand(level.flux);
      }
    level.mesh->apply_divergence(level.flux, result);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::smooth_velocity(Level &level,
                                        const Chebyshev &smoother,
                                        const bool from_zero) const
  {
    const unsigned int n = level.u.locally_owned_size();
    const auto step      = [&](const double c, const double s) {
      level.mesh->expand(level.u);
      level.mesh->apply_velocity_form(cycled, level.u, level.velocity_product);
      update(n,
             c,
             s,
             level.inverse_diagonal.begin(),
             level.f.begin(),
             level.velocity_product.begin(),
             level.velocity_step.begin(),
             level.u.begin());
    };
    iterate(
      smoother.lower,
      smoother.upper,
      smoother.degree,
      [&](const double s) {
        if (!from_zero)
          return step(0, s);
        const float *inverse = level.inverse_diagonal.begin(), *f = level.f.begin();
        float *d = level.velocity_step.begin(), *u = level.u.begin();
        for (unsigned int i = 0; i < n; ++i)
          u[i] = d[i] = float(s) * inverse[i] * f[i];
      },
      step);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::smooth_pressure(Level &level,
                                        const Chebyshev &smoother,
                                        const bool from_zero,
                                        const bool sharp) const
  {
    const auto update = [&](const double c, const double s, const float *product) {
      update_blocks<dim>(level.mesh->n_batches(),
                         c,
                         s,
                         level.inverse_blocks.begin(),
                         level.g.begin(),
                         product,
                         level.pressure_step.begin(),
                         level.p.begin());
    };
    const auto step = [&](const double c, const double s) {
      apply_pressure_operator(level, level.p, level.pressure_product, sharp);
      update(c, s, level.pressure_product.begin());
    };
    iterate(
      smoother.lower,
      smoother.upper,
      smoother.degree,
      [&](const double s) {
        if (!from_zero)
          return step(0, s);
        level.p             = 0;
        level.pressure_step = 0;
        update(0, s, nullptr);
      },
      step);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::velocity_cycle(const unsigned int l)
  {
    Level &level = levels[l];
    if (l + 1 == levels.size() && direct_velocity)
      {
        dealii::Vector<double> values(level.f.locally_owned_size());
        std::copy_n(level.f.begin(), values.size(), values.begin());
        velocity_factor->solve(values);
        std::copy_n(values.begin(), values.size(), level.u.begin());
        return;
      }
    smooth_velocity(level, level.velocity_smoother, true);
    if (level.smoother_solves)
      return;
    Level &coarse = levels[l + 1];
    level.mesh->expand(level.u);
    level.mesh->apply_velocity_form(cycled, level.u, level.velocity_product);
    const unsigned int n = level.u.locally_owned_size();
    for (unsigned int i = 0; i < n; ++i)
      level.velocity_product.begin()[i] = level.f.begin()[i] - level.velocity_product.begin()[i];
    level.mesh->restrict_velocity(level.velocity_product, coarse.f);
    coarse.mesh->condense(coarse.f);
    velocity_cycle(l + 1);
    coarse.mesh->expand(coarse.u);
    level.mesh->prolongate_velocity(coarse.u, level.u);
    smooth_velocity(level, level.velocity_smoother, false);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::pressure_cycle(const unsigned int l, const bool sharp)
  {
    constexpr unsigned int n_pressure = dim + 1, lanes = MultigridLevel<dim>::lanes;
    Level &level = levels[l];
    if (l + 1 == levels.size())
      {
        dealii::Vector<double> values(level.g.locally_owned_size());
        std::copy_n(level.g.begin(), values.size(), values.begin());
        if (enclosed)
          {
            // The sum over all cells vanishes up to round-off.
            const auto for_constants = [&](const auto &action) {
              for (unsigned int b = 0; b < level.mesh->n_batches(); ++b)
                for (unsigned int l = 0; l < level.mesh->n_filled(b); ++l)
                  action(values[b * n_pressure * lanes + l]);
            };
            double sum = 0, n_cells = 0;
            for_constants([&](const double value) {
              sum += value;
              n_cells += 1;
            });
            for_constants([&](double &value) { value -= sum / n_cells; });
          }
        pressure_factor->solve(values);
        std::copy_n(values.begin(), values.size(), level.p.begin());
        return;
      }
    smooth_pressure(level, level.pressure_smoother, true, false);
    Level &coarse = levels[l + 1];
    apply_pressure_operator(level, level.p, level.pressure_product, false);
    const unsigned int n = level.p.locally_owned_size();
    for (unsigned int i = 0; i < n; ++i)
      level.pressure_product.begin()[i] = level.g.begin()[i] - level.pressure_product.begin()[i];
    level.mesh->restrict_pressure(level.pressure_product, coarse.g);
    pressure_cycle(l + 1, false);
    level.mesh->prolongate_pressure(coarse.p, level.p);
    Chebyshev last_smoother = level.pressure_smoother;
    if (sharp)
      {
        last_smoother.lower *= sharp_bound;
        last_smoother.upper *= sharp_bound;
      }
    smooth_pressure(level, last_smoother, false, sharp);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::stokes_cycle(const unsigned int l)
  {
    Level &level = levels[l];
    if (level.coarser_first)
      {
        Level &coarse = levels[l + 1];
        level.mesh->restrict_velocity(level.f, coarse.f);
        coarse.mesh->condense(coarse.f);
        level.mesh->restrict_pressure(level.g, coarse.g);
        stokes_cycle(l + 1);
        level.first_u = 0;
        level.first_p = 0;
        coarse.mesh->expand(coarse.u);
        level.mesh->prolongate_velocity(coarse.u, level.first_u);
        level.mesh->prolongate_pressure(coarse.p, level.first_p);
        // What is left of the equations.
        level.mesh->expand(level.first_u);
        level.mesh->apply_velocity_form(cycled, level.first_u, level.velocity_product);
        level.f -= level.velocity_product;
        level.mesh->apply_gradient(level.first_p, level.flux);
        level.f += level.flux;
        level.mesh->apply_divergence(level.first_u, level.pressure_product);
        level.g -= level.pressure_product;
      }

    // The inverse of the Schur complement: (alpha Lp^{-1} + (mu + nu + eta) Mp^{-1}) g. In it the
    // symmetric gradient is twice the other, as (grad u^T, grad v) and (div u, div v) are the same
    // away from walls.
    if (cycled.alpha > 0)
      {
        pressure_cycle(l, l == 0 && inertia_counts);
        level.p *= cycled.alpha;
      }
    else
      level.p = 0;
    level.mesh->add_inverse_pressure_mass(cycled.mu + cycled.nu + cycled.eta, level.g, level.p);
    level.mesh->apply_gradient(level.p, level.flux);
    level.f += level.flux;
    velocity_cycle(l);

    if (level.coarser_first)
      {
        level.u += level.first_u;
        level.p += level.first_p;
      }
  }


  // --- vectors of the space

  template <int dim>
  void
  StokesMultigrid<dim>::import_velocity(const VelocityVector &from, LevelVector<float> &to) const
  {
    from.update_ghost_values();
    for (unsigned int i = 0; i < space_velocity.size(); ++i)
      to.begin()[i] = space_velocity[i] == none ? 0. : from.begin()[space_velocity[i]];
    from.zero_out_ghost_values();
  }


  template <int dim>
  void
  StokesMultigrid<dim>::export_velocity(const LevelVector<float> &from, VelocityVector &to) const
  {
    from.update_ghost_values();
    to.zero_out_ghost_values();
    for (unsigned int i = 0; i < level_velocity.size(); ++i)
      to.begin()[i] = level_velocity[i] == none ? 0. : from.begin()[level_velocity[i]];
  }


  template <int dim>
  void
  StokesMultigrid<dim>::import_pressure(const PressureVector &from,
                                        const float factor,
                                        LevelVector<float> &to) const
  {
    for (unsigned int i = 0; i < space_pressure.size(); ++i)
      to.begin()[i] = space_pressure[i] == none ? 0. : factor * from.begin()[space_pressure[i]];
  }


  template <int dim>
  void
  StokesMultigrid<dim>::export_pressure(const LevelVector<float> &from, PressureVector &to) const
  {
    to.zero_out_ghost_values();
    for (unsigned int i = 0; i < space_pressure.size(); ++i)
      if (space_pressure[i] != none)
        to.begin()[space_pressure[i]] = from.begin()[i];
  }


  template <int dim>
  void
  StokesMultigrid<dim>::solve(const VelocityVector &f,
                              const PressureVector &g,
                              VelocityVector &u,
                              PressureVector &p)
  {
    Level &finest = levels[0];
    import_velocity(f, finest.f);
    import_pressure(g, -1, finest.g);
    stokes_cycle(0);
    export_velocity(finest.u, u);

    // What the cycle's A lacks, or has in excess, as far as the pressures can tell: the pressure
    // changes by Mp^{-1} B u.
    const double lacking = form.nu - cycled.nu + form.gamma - cycled.eta;
    if (lacking != 0)
      {
        finest.mesh->expand(finest.u);
        finest.mesh->apply_divergence(finest.u, finest.g);
        finest.mesh->add_inverse_pressure_mass(lacking, finest.g, finest.p);
      }
    export_pressure(finest.p, p);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::solve_pressure(const PressureVector &g, PressureVector &p)
  {
    import_pressure(g, 1, levels[0].g);
    pressure_cycle(0, false);
    export_pressure(levels[0].p, p);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::solve_velocity(const VelocityVector &f, VelocityVector &u)
  {
    import_velocity(f, levels[0].f);
    velocity_cycle(0);
    export_velocity(levels[0].u, u);
  }


  template <int dim>
  void
  StokesMultigrid<dim>::divide_by_mass(VelocityVector &v)
  {
    Level &finest = levels[0];
    import_velocity(v, finest.u);
    for (unsigned int i = 0; i < finest.u.locally_owned_size(); ++i)
      finest.u.begin()[i] *= finest.inverse_mass.begin()[i];
    export_velocity(finest.u, v);
  }


  template <int dim>
  std::string
  StokesMultigrid<dim>::describe() const
  {
    std::ostringstream text;
    text << levels.size() << (levels.size() == 1 ? " level" : " levels") << ", of velocity "
         << last_velocity + 1 << (direct_velocity ? "" : " (dominated by mass there)");
    return text.str();
  }


  template class StokesMultigrid<2>;
  template class StokesMultigrid<3>;
} // namespace feib
