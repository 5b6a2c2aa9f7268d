// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/eulerian_space.h>

#include "boundary_flux.h"
#include "cell_order.h"
#include "field_transfer.h"
#include "velocity_constraints.h"

#include <feib/failure.h>

#include <deal.II/base/mpi.h>
#include <deal.II/dofs/dof_renumbering.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_tools.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace feib
{
  namespace
  {
    /// A number that tells meshes apart, the same on all ranks and for any division between them.
    /// The checksum of p4est is not enough: meshes that differ by symmetric changes share it.
    template <class Cell>
    std::uint64_t
    fingerprint_of(const std::vector<Cell> &cells, const MPI_Comm communicator)
    {
      std::uint64_t sum = 0;
      for (const Cell &cell : cells)
        {
          std::uint64_t hash = cell.level;
          for (unsigned int a = 0; a < cell.size.dimension; ++a)
            {
              std::uint64_t bits;
              std::memcpy(&bits, &cell.lower[a], sizeof(bits));
              // The finaliser of splitmix64.
              hash += bits + 0x9e3779b97f4a7c15;
              hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9;
              hash = (hash ^ (hash >> 27)) * 0x94d049bb133111eb;
              hash ^= hash >> 31;
            }
          sum += hash;
        }
      return dealii::Utilities::MPI::sum(sum, communicator);
    }
  } // namespace


  template <int dim>
  EulerianSpace<dim>::EulerianSpace(Domain<dim> domain, const MPI_Comm communicator)
    : box(std::move(domain))
    , mpi_communicator(communicator)
    , mesh(communicator)
    , velocity_fe(dealii::FE_Q<dim>(2), dim)
    , pressure_fe(1)
    , velocity_dof_handler(mesh)
    , pressure_dof_handler(mesh)
  {
    // A change of the forest takes time for every tree: few large ones, of which a periodic
    // direction needs two. p4est has 29 levels in 2D and 18 in 3D, of which cases may use 15.
    constexpr unsigned int most = dim == 2 ? 14 : 3;
    std::vector<unsigned int> trees(box.cells.begin(), box.cells.end());
    while (base_level < most && std::all_of(trees.begin(), trees.end(), [](const unsigned int n) {
             return n % 2 == 0 && n >= 4;
           }))
      {
        for (unsigned int &n : trees)
          n /= 2;
        ++base_level;
      }
    dealii::GridGenerator::subdivided_hyper_rectangle(mesh, trees, box.lower, box.upper, true);

    std::vector<dealii::GridTools::PeriodicFacePair<
      typename dealii::parallel::distributed::Triangulation<dim>::cell_iterator>>
      pairs;
    for (unsigned int a = 0; a < dim; ++a)
      if (box.periodic(a))
        dealii::GridTools::collect_periodic_faces(mesh, 2 * a, 2 * a + 1, a, pairs);
    if (!pairs.empty())
      mesh.add_periodicity(pairs);
    mesh.refine_global(base_level);

    distribute_dofs();
    velocity       = make_velocity();
    old_velocity   = make_velocity();
    older_velocity = make_velocity();
    pressure       = make_pressure();
  }


  template <int dim>
  Lattice<dim>
  EulerianSpace<dim>::make_lattice(const bool refined) const
  {
    int finest = 0;
    for (const auto &cell : mesh.active_cell_iterators())
      if (cell->is_locally_owned())
        finest = std::max(finest, level(*cell) + (refined && cell->refine_flag_set() ? 1 : 0));
    return Lattice<dim>(box, dealii::Utilities::MPI::max(finest, mpi_communicator) + 1);
  }


  template <int dim>
  void
  EulerianSpace<dim>::distribute_dofs()
  {
    node_lattice = make_lattice(false);
    velocity_dof_handler.distribute_dofs(velocity_fe);
    pressure_dof_handler.distribute_dofs(pressure_fe);
    // In the order of the forest, whatever the history of the mesh and the number of ranks.
    dealii::DoFRenumbering::hierarchical(velocity_dof_handler);
    dealii::DoFRenumbering::hierarchical(pressure_dof_handler);
    make_constraints(present_time);

    // Ghosts: what the cells around need, and what constraints of those lead to.
    velocity_partitioner = std::make_shared<dealii::Utilities::MPI::Partitioner>(
      velocity_dof_handler.locally_owned_dofs(),
      FlatConstraints::with_masters(relevant_velocity, velocity_constraints),
      mpi_communicator);
    dealii::IndexSet relevant_pressure;
    dealii::DoFTools::extract_locally_relevant_dofs(pressure_dof_handler, relevant_pressure);
    pressure_partitioner = std::make_shared<dealii::Utilities::MPI::Partitioner>(
      pressure_dof_handler.locally_owned_dofs(), relevant_pressure, mpi_communicator);
    flatten_constraints();
    continuity.reset();

    const auto ordered = cells_in_order(mesh);
    locator.rebuild(mesh, ordered, base_level, box);

    cell_list.clear();
    velocity_dof_table.clear();
    pressure_dof_table.clear();
    const std::vector<unsigned int> lexicographic =
      dealii::FETools::hierarchic_to_lexicographic_numbering<dim>(2);
    std::vector<dealii::types::global_dof_index> indices(n_velocity), pressure_indices(n_pressure);
    smallest_edge_length = std::numeric_limits<double>::max();
    for (const auto &cell : ordered)
      {
        Cell flat;
        flat.lower = cell->vertex(0);
        flat.size  = cell->vertex((1 << dim) - 1) - cell->vertex(0);
        flat.level = level(*cell);
        cell_list.push_back(flat);
        for (unsigned int a = 0; a < dim; ++a)
          smallest_edge_length = std::min(smallest_edge_length, flat.size[a]);

        in_handler(cell, velocity_dof_handler)->get_dof_indices(indices);
        const unsigned int offset = velocity_dof_table.size();
        velocity_dof_table.resize(offset + n_velocity);
        for (unsigned int i = 0; i < n_velocity; ++i)
          {
            const auto [component, node] = velocity_fe.system_to_component_index(i);
            velocity_dof_table[offset + component * n_nodes + lexicographic[node]] =
              velocity_partitioner->global_to_local(indices[i]);
          }

        in_handler(cell, pressure_dof_handler)->get_dof_indices(pressure_indices);
        for (const auto i : pressure_indices)
          pressure_dof_table.push_back(pressure_partitioner->global_to_local(i));
      }
    smallest_edge_length = dealii::Utilities::MPI::min(smallest_edge_length, mpi_communicator);
    fingerprint          = fingerprint_of(cell_list, mpi_communicator);
    find_boundary_faces();
    ++revision_number;
  }


  template <int dim>
  void
  EulerianSpace<dim>::make_constraints(const double t)
  {
    constraints_time = t;
    dealii::DoFTools::extract_locally_relevant_dofs(velocity_dof_handler, relevant_velocity);
    const auto with = [&](const double share) {
      return make_velocity_constraints(
        velocity_dof_handler, box, node_lattice, relevant_velocity, t, share);
    };
    velocity_constraints = with(0.);
    spread_share         = 0;
    boundary_issues.clear();
    for (const auto &condition : box.conditions)
      if (condition.velocity)
        for (const Issue &issue : condition.velocity->not_finite(mpi_communicator))
          boundary_issues.push_back(issue);
    if (!boundary_issues.empty() || !box.enclosed())
      return;

    constexpr double round_off = 1e-13;
    const BoundaryFlux flux    = interpolated_flux(velocity_dof_handler, box, velocity_constraints);
    if (std::abs(flux.net) <= round_off * flux.gross)
      return;
    boundary_issues = unbalanced_flux(box, flux, t, mpi_communicator);
    if (!boundary_issues.empty())
      return;
    // The net flux is linear in the share that is spread; where no node hangs, the first is right.
    spread_share         = flux.net / flux.gross;
    velocity_constraints = with(spread_share);
    const double left    = interpolated_flux(velocity_dof_handler, box, velocity_constraints).net;
    if (std::abs(left) > round_off * flux.gross)
      {
        spread_share *= flux.net / (flux.net - left);
        velocity_constraints = with(spread_share);
      }
  }


  template <int dim>
  void
  EulerianSpace<dim>::flatten_constraints()
  {
    flat_constraints = {velocity_constraints, relevant_velocity, *velocity_partitioner};
  }


  template <int dim>
  void
  EulerianSpace<dim>::set_time(const double t)
  {
    if (box.time_dependent() && (t != constraints_time || on_the_way))
      {
        if (t != constraints_time)
          make_constraints(t);
        flatten_constraints();
      }
    on_the_way   = false;
    present_time = t;
    if (!boundary_issues.empty())
      throw Incurable(Error(boundary_issues).what());
  }


  template <int dim>
  void
  EulerianSpace<dim>::set_time(const double t, const double share, const double end)
  {
    if (!box.time_dependent() || share == 1)
      {
        set_time(t);
        return;
      }
    set_time(end);
    flat_constraints.approach(old_velocity, share);
    on_the_way   = true;
    present_time = t;
  }


  template <int dim>
  Issues
  EulerianSpace<dim>::check_boundary(const std::vector<double> &times)
  {
    Issues issues = boundary_issues;
    for (const double t : times)
      if (issues.empty() && box.time_dependent())
        {
          make_constraints(t);
          issues = boundary_issues;
        }
    if (box.time_dependent())
      {
        make_constraints(present_time);
        flatten_constraints();
      }
    const Issues absent = absent_parts();
    issues.insert(issues.end(), absent.begin(), absent.end());
    return issues;
  }


  template <int dim>
  void
  EulerianSpace<dim>::find_boundary_faces()
  {
    boundary_face_list.clear();
    for (unsigned int c = 0; c < cell_list.size(); ++c)
      {
        // Centres are places of the lattice, whose unit is half an edge of the smallest cell.
        const auto lower = node_lattice.nearest(cell_list[c].lower),
                   upper = node_lattice.nearest(cell_list[c].lower + cell_list[c].size);
        for (unsigned int f = 0; f < 2 * dim; ++f)
          {
            const unsigned int a    = f / 2;
            const std::int64_t side = f % 2 == 0 ? lower[a] : upper[a];
            if (box.periodic(a) || side != (f % 2 == 0 ? 0 : node_lattice.extent(a)))
              continue;
            auto centre = lower;
            for (unsigned int b = 0; b < dim; ++b)
              centre[b] = b == a ? side : (lower[b] + upper[b]) / 2;
            boundary_face_list.push_back(
              {c, f, box.condition_at(f, box.place(node_lattice.share(centre)))});
          }
      }
  }


  template <int dim>
  Issues
  EulerianSpace<dim>::absent_parts() const
  {
    std::vector<unsigned int> n_faces(box.conditions.size(), 0);
    for (const BoundaryFace &face : boundary_face_list)
      ++n_faces[face.condition];
    dealii::Utilities::MPI::sum(n_faces, mpi_communicator, n_faces);
    Issues issues;
    for (unsigned int i = 0; i < n_faces.size(); ++i)
      if (const auto &condition = box.conditions[i]; condition.where)
        {
          const Issues undefined = condition.where->not_finite(mpi_communicator);
          issues.insert(issues.end(), undefined.begin(), undefined.end());
          if (undefined.empty() && n_faces[i] == 0)
            issues.push_back({condition.pointer,
                              "holds nowhere: the centre of no cell's face is in this part, or "
                              "earlier parts cover it"});
        }
    return issues;
  }


  template <int dim>
  double
  EulerianSpace<dim>::spread_flux() const
  {
    return spread_share;
  }


  template <int dim>
  bool
  EulerianSpace<dim>::adapt(const Mark &mark, const bool repeat)
  {
    // A strategy may ask for ever what the 2:1 balance of the forest undoes: stop at an unchanged
    // mesh.
    constexpr unsigned int most_rounds = 30;

    const auto flagged = [&]() {
      int any = 0;
      for (const auto &cell : mesh.active_cell_iterators())
        if (cell->is_locally_owned() && (cell->refine_flag_set() || cell->coarsen_flag_set()))
          any = 1;
      return dealii::Utilities::MPI::max(any, mpi_communicator) == 1;
    };
    bool changed = false;
    for (unsigned int round = 0; round < (repeat ? most_rounds : 1); ++round)
      {
        for (const auto &cell : mesh.active_cell_iterators())
          {
            cell->clear_refine_flag();
            cell->clear_coarsen_flag();
          }
        mark(mesh);
        for (const auto &cell : mesh.active_cell_iterators())
          if (cell->is_locally_owned() && level(*cell) == 0)
            cell->clear_coarsen_flag();
        if (!flagged())
          break;
        // Some flags may have to go.
        mesh.prepare_coarsening_and_refinement();
        if (!flagged())
          break;
        make_lattice(true);

        FieldTransfer<dim> fields(*this);
        const std::uint64_t before = fingerprint;
        mesh.execute_coarsening_and_refinement();
        distribute_dofs();
        const bool new_mesh = fingerprint != before;
        changed             = changed || new_mesh;
        fields.finish();
        distribute(velocity, false);
        // Its boundary values are of its own time, also where nodes hang on them.
        make_continuity_constraints<dim>(velocity_dof_handler, node_lattice, relevant_velocity)
          .distribute(old_velocity);
        old_velocity.update_ghost_values();
        older_velocity = old_velocity;
        if (!new_mesh)
          break;
      }
    return changed;
  }


  template <int dim>
  std::vector<unsigned char>
  EulerianSpace<dim>::levels_in_order() const
  {
    std::vector<unsigned char> levels, result;
    for (const auto &cell : cells_in_order(mesh))
      levels.push_back(cell->level());
    for (const auto &part : dealii::Utilities::MPI::all_gather(mpi_communicator, levels))
      result.insert(result.end(), part.begin(), part.end());
    return result;
  }


  template <int dim>
  void
  EulerianSpace<dim>::archive_mesh(Archive &archive)
  {
    std::vector<unsigned char> levels = levels_in_order();
    archive("levels", levels);
    if (!archive.reading())
      return;
    const std::vector<CellKey> keys = keys_of_levels<dim>(levels, mesh.n_cells(0));
    const auto towards              = [&](auto &triangulation) {
      for (const auto &cell : triangulation.active_cell_iterators())
        if (cell->is_locally_owned())
          {
            // The cell of the wanted mesh that has the first corner.
            const CellKey key    = key_of(*cell);
            const auto following = std::upper_bound(keys.begin(), keys.end(), key);
            const auto wanted    = std::prev(following)->level;
            if (wanted > key.level)
              cell->set_refine_flag();
            else if (wanted < key.level)
              cell->set_coarsen_flag();
          }
    };
    adapt(towards, true);
    if (levels_in_order() != levels)
      throw RunFailure("the archived mesh cannot be made again");
  }


  template <int dim>
  void
  EulerianSpace<dim>::archive(Archive &archive)
  {
    // Within a step the mesh stays.
    if (archive.persistent())
      archive_mesh(archive);
    double time = present_time;
    archive("time", time);
    if (archive.reading())
      set_time(time);
    archive("velocity", velocity);
    archive("old_velocity", old_velocity);
    archive("pressure", pressure);
    archive("earlier_pressures", earlier_pressures);
    archive("old_dt", old_dt);
    if (archive.reading())
      older_velocity = old_velocity; // a step replaces it
  }


  template <int dim>
  VelocityVector
  EulerianSpace<dim>::make_velocity() const
  {
    return VelocityVector(velocity_partitioner);
  }


  template <int dim>
  PressureVector
  EulerianSpace<dim>::make_pressure() const
  {
    return PressureVector(pressure_partitioner);
  }


  template <int dim>
  void
  EulerianSpace<dim>::condense(VelocityVector &v) const
  {
    v.zero_out_ghost_values();
    flat_constraints.condense(v);
  }


  template <int dim>
  void
  EulerianSpace<dim>::condense_continuity(VelocityVector &v) const
  {
    if (!continuity)
      {
        const auto constraints =
          make_continuity_constraints<dim>(velocity_dof_handler, node_lattice, relevant_velocity);
        auto made         = std::make_unique<Continuity>();
        made->partitioner = std::make_shared<dealii::Utilities::MPI::Partitioner>(
          velocity_dof_handler.locally_owned_dofs(),
          FlatConstraints::with_masters(relevant_velocity, constraints),
          mpi_communicator);
        made->constraints = {constraints, relevant_velocity, *made->partitioner};
        continuity        = std::move(made);
      }
    VelocityVector with_all_masters(continuity->partitioner);
    with_all_masters.copy_locally_owned_data_from(v);
    continuity->constraints.condense(with_all_masters);
    v.zero_out_ghost_values();
    v.copy_locally_owned_data_from(with_all_masters);
  }


  template <int dim>
  void
  EulerianSpace<dim>::distribute(VelocityVector &v, const bool homogeneous) const
  {
    flat_constraints.distribute(v, homogeneous);
  }


  template <int dim>
  void
  EulerianSpace<dim>::shape_values(const dealii::Point<dim> &unit, double *values)
  {
    double line[dim][3];
    for (unsigned int a = 0; a < dim; ++a)
      {
        const double x = unit[a];
        line[a][0]     = 2 * (x - .5) * (x - 1);
        line[a][1]     = 4 * x * (1 - x);
        line[a][2]     = 2 * x * (x - .5);
      }
    if constexpr (dim == 2)
      for (unsigned int j = 0; j < 3; ++j)
        for (unsigned int i = 0; i < 3; ++i)
          values[3 * j + i] = line[0][i] * line[1][j];
    else
      for (unsigned int k = 0; k < 3; ++k)
        for (unsigned int j = 0; j < 3; ++j)
          for (unsigned int i = 0; i < 3; ++i)
            values[9 * k + 3 * j + i] = line[0][i] * line[1][j] * line[2][k];
  }


  template <int dim>
  const Domain<dim> &
  EulerianSpace<dim>::domain() const
  {
    return box;
  }

  template <int dim>
  MPI_Comm
  EulerianSpace<dim>::communicator() const
  {
    return mpi_communicator;
  }

  template <int dim>
  const dealii::parallel::distributed::Triangulation<dim> &
  EulerianSpace<dim>::triangulation() const
  {
    return mesh;
  }

  template <int dim>
  const dealii::DoFHandler<dim> &
  EulerianSpace<dim>::velocity_handler() const
  {
    return velocity_dof_handler;
  }

  template <int dim>
  const dealii::DoFHandler<dim> &
  EulerianSpace<dim>::pressure_handler() const
  {
    return pressure_dof_handler;
  }

  template <int dim>
  const dealii::MappingCartesian<dim> &
  EulerianSpace<dim>::mapping() const
  {
    return cartesian_mapping;
  }

  template <int dim>
  const dealii::AffineConstraints<double> &
  EulerianSpace<dim>::constraints() const
  {
    return velocity_constraints;
  }

  template <int dim>
  unsigned int
  EulerianSpace<dim>::revision() const
  {
    return revision_number;
  }

  template <int dim>
  const std::vector<typename EulerianSpace<dim>::Cell> &
  EulerianSpace<dim>::cells() const
  {
    return cell_list;
  }

  template <int dim>
  const std::vector<typename EulerianSpace<dim>::BoundaryFace> &
  EulerianSpace<dim>::boundary_faces() const
  {
    return boundary_face_list;
  }

  template <int dim>
  const CartesianForest<dim> &
  EulerianSpace<dim>::forest() const
  {
    return locator;
  }

  template <int dim>
  const Lattice<dim> &
  EulerianSpace<dim>::lattice() const
  {
    return node_lattice;
  }

  template <int dim>
  double
  EulerianSpace<dim>::smallest_edge() const
  {
    return smallest_edge_length;
  }


  template class EulerianSpace<2>;
  template class EulerianSpace<3>;
} // namespace feib
