// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/refinement_strategy.h>
#include <feib/refinement_strategy/cell_tree.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_interface_values.h>

#include <cmath>
#include <optional>

#include "error_indicator_schema.h"

namespace
{
  using namespace dealii;

  /// What the face between two cells adds to their indicators.
  struct FaceTerm
  {
    double jump = 0; ///< h_F times the integral of the squared jump
    double size = 0; ///< the same of the field itself, in the unit of the jump
  };

  /// The squared indicators of the active cells this rank knows, right on the locally owned ones.
  /// All are zero when the jumps are no more than what solvers and round-off leave of a smooth
  /// solution. @p term integrates over a face, or over a half of it beside two smaller cells; faces
  /// of periodic boundaries are faces between cells.
  template <int dim, class Term>
  std::vector<double>
  sum_over_faces(const feib::EulerianSpace<dim> &space,
                 const DoFHandler<dim> &handler,
                 const UpdateFlags flags,
                 const Term &term)
  {
    // Relative to the field: well above the tolerance of the fluid's solver.
    constexpr double smallest_jump = 1e-8;

    // Not MeshWorker::mesh_loop: where the box is periodic and refined, deal.II 9.4.1 asserts there
    // about a neighbour that does not exist.
    FEInterfaceValues<dim> values(space.mapping(),
                                  handler.get_fe(),
                                  QGauss<dim - 1>(3),
                                  flags | update_JxW_values);
    constexpr unsigned int whole = numbers::invalid_unsigned_int;
    std::vector<double> indicators(space.triangulation().n_active_cells(), 0.);
    FaceTerm total;
    for (const auto &cell : handler.active_cell_iterators())
      for (unsigned int face = 0; face < 2 * dim && !cell->is_artificial(); ++face)
        {
          const bool seam = cell->has_periodic_neighbor(face);
          if (cell->at_boundary(face) && !seam)
            continue;
          const auto neighbor = cell->neighbor_or_periodic_neighbor(face);
          // Smaller cells come to the face themselves, and a cell of the same size does it once.
          if (neighbor->has_children() || neighbor->is_artificial() ||
              !(cell->is_locally_owned() || neighbor->is_locally_owned()))
            continue;
          if (seam ? cell->periodic_neighbor_is_coarser(face) : cell->neighbor_is_coarser(face))
            {
              const auto [neighbor_face, subface] =
                seam ? cell->periodic_neighbor_of_coarser_periodic_neighbor(face)
                     : cell->neighbor_of_coarser_neighbor(face);
              values.reinit(cell, face, whole, neighbor, neighbor_face, subface);
            }
          else if (neighbor < cell)
            continue;
          else
            values.reinit(cell,
                          face,
                          whole,
                          neighbor,
                          seam ? cell->periodic_neighbor_face_no(face)
                               : cell->neighbor_of_neighbor(face),
                          whole);
          const FaceTerm added = term(values, cell->face(face)->diameter());
          indicators[cell->active_cell_index()] += added.jump;
          indicators[neighbor->active_cell_index()] += added.jump;
          total.jump += added.jump;
          total.size += added.size;
        }

    if (Utilities::MPI::sum(total.jump, space.communicator()) <=
        smallest_jump * smallest_jump * Utilities::MPI::sum(total.size, space.communicator()))
      std::fill(indicators.begin(), indicators.end(), 0.);
    return indicators;
  }

  /// h_F |[p]|^2.
  template <int dim>
  std::vector<double>
  pressure_jumps(const feib::EulerianSpace<dim> &space)
  {
    feib::PressureVector pressure = space.pressure;
    pressure.update_ghost_values();
    const FEValuesExtractors::Scalar p(0);
    return sum_over_faces(space,
                          space.pressure_handler(),
                          update_values,
                          [&](const FEInterfaceValues<dim> &face, const double h) {
                            std::vector<double> here(face.n_quadrature_points),
                              there(face.n_quadrature_points);
                            face.get_fe_face_values(0)[p].get_function_values(pressure, here);
                            face.get_fe_face_values(1)[p].get_function_values(pressure, there);
                            FaceTerm result;
                            for (unsigned int q = 0; q < here.size(); ++q)
                              {
                                const double jump = here[q] - there[q];
                                result.jump += h * jump * jump * face.JxW(q);
                                result.size += h * here[q] * here[q] * face.JxW(q);
                              }
                            return result;
                          });
  }

  /// h_F |[du/dn]|^2. deal.II's KellyErrorEstimator leaves out the faces of periodic boundaries.
  template <int dim>
  std::vector<double>
  gradient_jumps(const feib::EulerianSpace<dim> &space)
  {
    feib::VelocityVector velocity = space.velocity;
    velocity.update_ghost_values();
    const FEValuesExtractors::Vector u(0);
    return sum_over_faces(space,
                          space.velocity_handler(),
                          update_values | update_gradients | update_normal_vectors,
                          [&](const FEInterfaceValues<dim> &face, const double h) {
                            std::vector<Tensor<1, dim>> values(face.n_quadrature_points);
                            std::vector<Tensor<2, dim>> here(face.n_quadrature_points),
                              there(face.n_quadrature_points);
                            face.get_fe_face_values(0)[u].get_function_values(velocity, values);
                            face.get_fe_face_values(0)[u].get_function_gradients(velocity, here);
                            face.get_fe_face_values(1)[u].get_function_gradients(velocity, there);
                            FaceTerm result;
                            for (unsigned int q = 0; q < here.size(); ++q)
                              {
                                result.jump +=
                                  h * ((here[q] - there[q]) * face.normal(q)).norm_square() *
                                  face.JxW(q);
                                result.size += values[q].norm_square() / h * face.JxW(q);
                              }
                            return result;
                          });
  }


  /// An active cell of the mesh, on whatever rank it is.
  template <int dim>
  struct Leaf
  {
    int level;
    feib::Place<dim> place;
    double indicator;        // squared
    unsigned int class_ = 0; // the smaller, the larger the indicator

    template <class Archive>
    void
    serialize(Archive &archive, const unsigned int)
    {
      archive &level &place &indicator &class_;
    }
  };


  template <int dim>
  class ErrorIndicator : public feib::RefinementStrategy<dim>
  {
  public:
    explicit ErrorIndicator(const feib::Parameters &parameters)
      : kelly(parameters.string("indicator") == "kelly")
      , by_number(parameters.string("marking") == "fixed_fraction")
      , refine_fraction(parameters.number("refine_fraction"))
      , coarsen_fraction(parameters.number("coarsen_fraction"))
      , minimum_level(parameters.integer("minimum_level"))
      , maximum_level(parameters.integer("maximum_level"))
      , structure_level(parameters.has("structure_level") ? parameters.integer("structure_level")
                                                          : minimum_level)
      , maximum_cells(parameters.has("maximum_cells") ? parameters.integer("maximum_cells")
                                                      : feib::Domain<dim>::most_cells)
      , steps(parameters.integer("interval"))
    {
      for (const std::string key : {"minimum_level", "structure_level"})
        if (parameters.has(key) && parameters.integer(key) > maximum_level)
          parameters.fail(key,
                          "is " + std::to_string(parameters.integer(key)) +
                            ", must be at most the maximum_level, " +
                            std::to_string(maximum_level));
      if (refine_fraction + coarsen_fraction > 1)
        parameters.fail("coarsen_fraction", "must be at most 1 together with refine_fraction");
    }

    void
    plan(const feib::EulerianSpace<dim> &space,
         const std::vector<feib::ImmersedStructure<dim>> &structures) override
    {
      std::vector<Leaf<dim>> leaves = gather(space);
      const Classes classes         = classify(leaves);

      const feib::CellTree<dim> required = required_tree(space, structures);

      // As many classes as there is room for.
      unsigned int n_refined = classes.n_refined;
      tree                   = make_tree(required, leaves, n_refined, classes.first_coarsened);
      if (tree->n_cells() > maximum_cells)
        {
          unsigned int too_many = n_refined;
          n_refined             = 0;
          while (too_many > n_refined + 1)
            {
              const unsigned int middle = (n_refined + too_many) / 2;
              (make_tree(required, leaves, middle, classes.first_coarsened).n_cells() >
                   maximum_cells
                 ? too_many
                 : n_refined)           = middle;
            }
          tree = make_tree(required, leaves, n_refined, classes.first_coarsened);
        }
    }

    void
    mark(parallel::distributed::Triangulation<dim> &triangulation,
         const feib::EulerianSpace<dim> &space,
         const std::vector<feib::ImmersedStructure<dim>> &) const override
    {
      Assert(tree, ExcMessage("plan() comes first"));
      tree->mark(triangulation, space);
    }

    /// At the start only what is required counts.
    double
    forecast_cells(const feib::EulerianSpace<dim> &space,
                   const std::vector<feib::ImmersedStructure<dim>> &structures) const override
    {
      using Lattice = feib::Lattice<dim>;
      double least  = Lattice(space.domain(), minimum_level).n_units();
      if (structure_level > minimum_level)
        least =
          std::max(least,
                   feib::least_touched_cells(Lattice(space.domain(), structure_level), structures));
      if (feib::CellTree<dim>::too_large(least))
        return least;
      feib::CellTree<dim> required = required_tree(space, structures);
      required.balance();
      return required.n_cells();
    }

    unsigned int
    finest_level() const override
    {
      return maximum_level;
    }

    unsigned int
    interval() const override
    {
      return steps;
    }

  private:
    /// Classes 0, 1, ..., n_refined - 1 are to be split, first_coarsened and above to be merged.
    struct Classes
    {
      unsigned int n_refined, first_coarsened;
    };

    /// What the state of the fluid does not decide.
    feib::CellTree<dim>
    required_tree(const feib::EulerianSpace<dim> &space,
                  const std::vector<feib::ImmersedStructure<dim>> &structures) const
    {
      feib::CellTree<dim> required(space.domain(), minimum_level, maximum_level);
      if (structure_level > minimum_level)
        for (const feib::Place<dim> &place :
             feib::touched_cells(required.lattice(structure_level), structures))
          required.ask_for(structure_level, place);
      return required;
    }

    /// All cells of all ranks.
    std::vector<Leaf<dim>>
    gather(const feib::EulerianSpace<dim> &space) const
    {
      const std::vector<double> indicators = kelly ? gradient_jumps(space) : pressure_jumps(space);
      std::vector<Leaf<dim>> leaves;
      for (const auto &cell : space.triangulation().active_cell_iterators())
        if (cell->is_locally_owned())
          {
            const int level = space.level(*cell);
            leaves.push_back({level,
                              feib::Lattice<dim>(space.domain(), level).unit_around(cell->center()),
                              indicators[cell->active_cell_index()]});
          }
      std::vector<Leaf<dim>> result;
      for (const auto &part : Utilities::MPI::all_gather(space.communicator(), leaves))
        result.insert(result.end(), part.begin(), part.end());
      return result;
    }

    /// Sorts the cells into classes of indicators that differ by 1 % at most. A class is treated as
    /// a whole: the cells of a symmetric solution are, and round-off, which depends on the number
    /// of ranks, decides nothing.
    Classes
    classify(std::vector<Leaf<dim>> &leaves) const
    {
      constexpr double width = .01, smallest = 1e-12, round_off = 1e-9;
      // The last class is of the cells that hold nothing.
      const unsigned int last = std::lround(-std::log(smallest) / width);

      double largest = 0;
      for (const Leaf<dim> &leaf : leaves)
        largest = std::max(largest, leaf.indicator);
      std::vector<double> weights(last + 1, 0.);
      double total = 0;
      for (Leaf<dim> &leaf : leaves)
        {
          // Largest indicators, equal up to round-off, are in the middle of the first class.
          leaf.class_ =
            leaf.indicator > smallest * largest
              ? std::min<long>(std::lround(std::log(largest / leaf.indicator) / width), last - 1)
              : last;
          const double weight = by_number ? 1. : leaf.indicator;
          weights[leaf.class_] += weight;
          total += weight;
        }

      Classes result{0, last};
      double sum = 0;
      while (result.n_refined < last && sum < (refine_fraction - round_off) * total)
        sum += weights[result.n_refined++];
      sum = weights[last];
      while (result.first_coarsened > result.n_refined &&
             sum + weights[result.first_coarsened - 1] <= (coarsen_fraction + round_off) * total)
        sum += weights[--result.first_coarsened];
      return result;
    }

    /// The balanced tree of the cells that are required and those that are left when the classes
    /// below @p n_refined are split and those from @p first_coarsened on are merged.
    feib::CellTree<dim>
    make_tree(const feib::CellTree<dim> &required,
              const std::vector<Leaf<dim>> &leaves,
              const unsigned int n_refined,
              const unsigned int first_coarsened) const
    {
      feib::CellTree<dim> result = required;
      for (const Leaf<dim> &leaf : leaves)
        {
          // The level that cells around here have at least. The children of a cell are merged when
          // none of them asks to exist.
          const int change = leaf.class_ < n_refined ? 1 : leaf.class_ >= first_coarsened ? -1 : 0;
          const int level  = std::min(leaf.level + change, maximum_level);
          feib::Place<dim> place = leaf.place;
          for (std::int64_t &coordinate : place)
            coordinate = level > leaf.level ? 2 * coordinate : coordinate >> (leaf.level - level);
          result.ask_for(level, place);
        }
      result.balance();
      return result;
    }

    const bool kelly, by_number;
    const double refine_fraction, coarsen_fraction;
    const int minimum_level, maximum_level, structure_level;
    const std::uint64_t maximum_cells;
    const unsigned int steps;
    std::optional<feib::CellTree<dim>> tree;
  };
} // namespace


FEIB_PLUGIN("error_indicator", "1.0", registry)
{
  registry.add<feib::RefinementStrategy, ErrorIndicator>("error_indicator", error_indicator_schema);
}
