// SPDX-License-Identifier: LGPL-2.1-or-later
#include "velocity_constraints.h"

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_tools.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

namespace feib
{
  namespace
  {
    using Constraints = dealii::AffineConstraints<double>;
    using Index       = dealii::types::global_dof_index;

    /// The nodes of the cells this rank knows, by their place: what lies at a hanging node or at
    /// the other side of a periodic box is found by looking the place up. Only cells where that can
    /// matter take part: beside cells of other levels, and at periodic boundaries.
    template <int dim>
    class Nodes
    {
    public:
      Nodes(const dealii::DoFHandler<dim> &handler, const Lattice<dim> &lattice)
        : lattice(lattice)
      {
        using Level            = signed char;
        const unsigned int n_v = handler.get_triangulation().n_vertices();
        std::vector<Level> coarsest(n_v, std::numeric_limits<Level>::max()), finest(n_v, 0);
        for (const auto &cell : handler.active_cell_iterators())
          if (!cell->is_artificial())
            for (const unsigned int v : cell->vertex_indices())
              {
                const unsigned int i = cell->vertex_index(v);
                coarsest[i]          = std::min<Level>(coarsest[i], cell->level());
                finest[i]            = std::max<Level>(finest[i], cell->level());
              }

        const auto lexicographic = dealii::FETools::hierarchic_to_lexicographic_numbering<dim>(2);
        std::vector<Index> indices(handler.get_fe().n_dofs_per_cell());
        for (const auto &cell : handler.active_cell_iterators())
          if (!cell->is_artificial())
            {
              Cell entry;
              entry.lower     = lattice.nearest(cell->vertex(0));
              entry.size      = lattice.nearest(cell->vertex(1))[0] - entry.lower[0];
              bool takes_part = false;
              for (const unsigned int v : cell->vertex_indices())
                takes_part =
                  takes_part || coarsest[cell->vertex_index(v)] != finest[cell->vertex_index(v)];
              for (unsigned int a = 0; a < dim; ++a)
                takes_part =
                  takes_part ||
                  (lattice.periodic(a) &&
                   (entry.lower[a] == 0 || entry.lower[a] + entry.size == lattice.extent(a)));
              if (!takes_part)
                continue;
              entry.owned = cell->is_locally_owned();
              cell->get_dof_indices(indices);
              for (unsigned int i = 0; i < indices.size(); ++i)
                {
                  const auto [component, node] = handler.get_fe().system_to_component_index(i);
                  entry.unknowns[lexicographic[node]][component] = indices[i];
                }
              cells.push_back(entry);
            }
        // Active cells come level by level: of unknowns at one place, that of the coarsest cell is
        // kept, on all ranks.
        for (const Cell &cell : cells)
          for (unsigned int i = 0; i < n; ++i)
            {
              const Image image{place(cell, 2, i), cell.unknowns[i]};
              const auto [found, is_new] = first.try_emplace(key(image.place), image);
              if (!is_new && image.place < found->second.place)
                found->second = image;
            }
      }

      /// Adds lines for the constrained unknowns of the cells this rank owns, all of whose
      /// neighbours it knows: a node of finer cells on the boundary of a coarser one, but not one
      /// of its nodes, is interpolated there; of images, all depend on the first.
      void
      constrain(Constraints &constraints) const
      {
        // Places of a cell's boundary in quarters of the cell, of which the halves are its nodes.
        std::unordered_map<std::uint64_t, std::pair<const Cell *, unsigned int>> hanging;
        constexpr unsigned int n_quarters = dim == 2 ? 25 : 125;
        for (const Cell &cell : cells)
          if (cell.size > 2)
            for (unsigned int q = 0; q < n_quarters; ++q)
              {
                bool boundary = false, node = true;
                for (unsigned int a = 0, rest = q; a < dim; ++a, rest /= 5)
                  {
                    boundary = boundary || rest % 5 % 4 == 0;
                    node     = node && rest % 5 % 2 == 0;
                  }
                if (boundary && !node)
                  if (const auto k = key(place(cell, 4, q)); first.find(k) != first.end())
                    hanging.try_emplace(k, &cell, q);
              }

        for (const Cell &cell : cells)
          if (cell.owned)
            for (unsigned int i = 0; i < n; ++i)
              {
                const auto k      = key(place(cell, 2, i));
                const auto coarse = hanging.find(k);
                for (unsigned int a = 0; a < dim; ++a)
                  {
                    const Index unknown = cell.unknowns[i][a];
                    if (constraints.is_constrained(unknown))
                      continue;
                    if (coarse != hanging.end())
                      interpolate(
                        *coarse->second.first, coarse->second.second, a, unknown, constraints);
                    else if (const Index image = first.at(k).unknowns[a]; image != unknown)
                      {
                        constraints.add_line(unknown);
                        constraints.add_entry(unknown, image, 1.);
                      }
                  }
              }
      }

    private:
      static constexpr unsigned int n = dim == 2 ? 9 : 27;

      using Place = typename Lattice<dim>::Place;

      struct Cell
      {
        Place lower;
        std::int64_t size;
        bool owned;
        std::array<std::array<Index, dim>, n> unknowns; // nodes lexicographic
      };

      /// What lies at a place; of several that the periodic box identifies, that with the smallest
      /// coordinates: the choice must not depend on the division between ranks.
      struct Image
      {
        Place place;
        std::array<Index, dim> unknowns;
      };

      /// The place @p i, lexicographic, of those that divide a cell into @p parts in each
      /// direction.
      static Place
      place(const Cell &cell, const unsigned int parts, unsigned int i)
      {
        Place result = cell.lower;
        for (unsigned int a = 0; a < dim; ++a, i /= parts + 1)
          result[a] += cell.size * (i % (parts + 1)) / parts;
        return result;
      }

      /// The same number for all places that the periodic box identifies.
      std::uint64_t
      key(Place place) const
      {
        lattice.wrap(place, true);
        return lattice.key(place);
      }

      void
      interpolate(const Cell &cell,
                  const unsigned int q,
                  const unsigned int component,
                  const Index unknown,
                  Constraints &constraints) const
      {
        // Q2 on a line, at its quarters.
        static constexpr double value[5][3] = {
          {1, 0, 0}, {3 / 8., 3 / 4., -1 / 8.}, {0, 1, 0}, {-1 / 8., 3 / 4., 3 / 8.}, {0, 0, 1}};
        constraints.add_line(unknown);
        for (unsigned int i = 0; i < n; ++i)
          {
            double weight = 1;
            for (unsigned int a = 0, nodes = i, quarters = q; a < dim;
                 ++a, nodes /= 3, quarters /= 5)
              weight *= value[quarters % 5][nodes % 3];
            if (weight != 0)
              constraints.add_entry(unknown, cell.unknowns[i][component], weight);
          }
      }

      const Lattice<dim> &lattice;
      std::vector<Cell> cells;
      std::unordered_map<std::uint64_t, Image> first; // at a place
    };


    /// Prescribed values, less a share of what goes out of the box and with as much more of what
    /// comes in. The first condition to reach an unknown holds.
    template <int dim>
    void
    prescribe(const dealii::DoFHandler<dim> &handler,
              const Domain<dim> &box,
              const Lattice<dim> &lattice,
              const double share,
              Constraints &constraints)
    {
      const auto &fe = handler.get_fe();
      struct Node
      {
        dealii::Point<dim> x;
        std::array<Index, dim> unknowns;
      };
      std::array<std::vector<Node>, 2 * dim> nodes; // some of them several times
      std::vector<Index> indices(fe.n_dofs_per_cell());
      for (const auto &cell : handler.active_cell_iterators())
        if (!cell->is_artificial() && cell->at_boundary())
          {
            cell->get_dof_indices(indices);
            const auto lower = lattice.nearest(cell->vertex(0));
            const auto size  = lattice.nearest(cell->vertex(1))[0] - lower[0];
            for (unsigned int f = 0; f < 2 * dim; ++f)
              if (cell->at_boundary(f))
                for (unsigned int i = 0; i < indices.size(); i += dim)
                  if (fe.has_support_on_face(i, f))
                    {
                      Node node;
                      auto place = lower;
                      for (unsigned int a = 0; a < dim; ++a)
                        place[a] += std::lround(size * fe.unit_support_point(i)[a]);
                      node.x = box.place(lattice.share(place));
                      for (unsigned int a = 0; a < dim; ++a)
                        node.unknowns[fe.system_to_component_index(i + a).first] = indices[i + a];
                      nodes[f].push_back(node);
                    }
          }

      using Kind = typename BoundaryCondition<dim>::Kind;
      dealii::Vector<double> values(dim);
      for (const Kind kind : {Kind::no_slip, Kind::free_slip, Kind::velocity, Kind::open})
        for (unsigned int f = 0; f < 2 * dim; ++f)
          for (const Node &node : nodes[f])
            if (const auto &condition = box.conditions[box.condition_at_node(f, node.x)];
                condition.kind == kind)
              {
                values = 0;
                if (condition.velocity)
                  {
                    condition.velocity->vector_value(node.x, values);
                    double &across = values[condition.normal()];
                    across -= share * condition.outward() * std::abs(across);
                  }
                for (unsigned int a = 0; a < dim; ++a)
                  if (condition.prescribes(a) && !constraints.is_constrained(node.unknowns[a]))
                    {
                      constraints.add_line(node.unknowns[a]);
                      constraints.set_inhomogeneity(node.unknowns[a], values[a]);
                    }
              }
    }


    void
    add(const Constraints::ConstraintLine &line, Constraints &constraints)
    {
      constraints.add_line(line.index);
      constraints.add_entries(line.index, line.entries);
      constraints.set_inhomogeneity(line.index, line.inhomogeneity);
    }


    /// From the lines of the owned unknowns, those of the relevant ones and of all they lead to.
    Constraints
    gather(const Constraints &constraints,
           const dealii::IndexSet &owned,
           const dealii::IndexSet &relevant,
           const MPI_Comm communicator)
    {
      using Line = Constraints::ConstraintLine;
      std::vector<Line> lines;
      dealii::IndexSet asked = relevant, wanted = relevant; // other ranks' unknowns
      asked.subtract_set(owned);
      wanted.subtract_set(owned);
      const auto want_masters = [&](const Line &line) {
        for (const auto &[master, weight] : line.entries)
          if (!owned.is_element(master) && !asked.is_element(master))
            wanted.add_index(master);
      };
      const bool parallel = dealii::Utilities::MPI::n_mpi_processes(communicator) > 1;
      for (const auto &line : constraints.get_lines())
        if (owned.is_element(line.index))
          {
            lines.push_back(line);
            if (parallel)
              want_masters(line);
          }
      while (parallel && dealii::Utilities::MPI::max(wanted.n_elements(), communicator) > 0)
        {
          asked.add_indices(wanted);
          const std::vector<unsigned int> owners =
            dealii::Utilities::MPI::compute_index_owner(owned, wanted, communicator);
          std::map<unsigned int, std::vector<Index>> questions;
          auto owner = owners.begin();
          for (const Index i : wanted)
            questions[*owner++].push_back(i);
          std::map<unsigned int, std::vector<Line>> answers;
          for (const auto &[rank, indices] :
               dealii::Utilities::MPI::some_to_some(communicator, questions))
            for (const Index i : indices)
              if (constraints.is_constrained(i))
                {
                  const auto *entries = constraints.get_constraint_entries(i);
                  Line line;
                  line.index = i;
                  line.entries.assign(entries->begin(), entries->end());
                  line.inhomogeneity = constraints.get_inhomogeneity(i);
                  answers[rank].push_back(line);
                }
          wanted.clear();
          wanted.set_size(owned.size());
          for (const auto &[rank, received] :
               dealii::Utilities::MPI::some_to_some(communicator, answers))
            for (const Line &line : received)
              {
                lines.push_back(line);
                want_masters(line);
              }
        }
      dealii::IndexSet known = relevant;
      known.add_indices(asked);
      Constraints result(known);
      for (const Line &line : lines)
        add(line, result);
      result.close();
      return result;
    }
  } // namespace


  template <int dim>
  dealii::AffineConstraints<double>
  make_velocity_constraints(const dealii::DoFHandler<dim> &handler,
                            const Domain<dim> &box,
                            const Lattice<dim> &lattice,
                            const dealii::IndexSet &relevant,
                            const double t,
                            const double share)
  {
    Constraints constraints(relevant);
    Nodes<dim>(handler, lattice).constrain(constraints);

    for (const auto &condition : box.conditions)
      if (condition.velocity)
        condition.velocity->set_time(t);
    prescribe(handler, box, lattice, share, constraints);
    return gather(constraints, handler.locally_owned_dofs(), relevant, handler.get_communicator());
  }


  template <int dim>
  dealii::AffineConstraints<double>
  make_continuity_constraints(const dealii::DoFHandler<dim> &handler,
                              const Lattice<dim> &lattice,
                              const dealii::IndexSet &relevant)
  {
    Constraints constraints(relevant);
    Nodes<dim>(handler, lattice).constrain(constraints);
    return gather(constraints, handler.locally_owned_dofs(), relevant, handler.get_communicator());
  }


  template dealii::AffineConstraints<double>
  make_velocity_constraints(const dealii::DoFHandler<2> &,
                            const Domain<2> &,
                            const Lattice<2> &,
                            const dealii::IndexSet &,
                            double,
                            double);
  template dealii::AffineConstraints<double>
  make_velocity_constraints(const dealii::DoFHandler<3> &,
                            const Domain<3> &,
                            const Lattice<3> &,
                            const dealii::IndexSet &,
                            double,
                            double);
  template dealii::AffineConstraints<double>
  make_continuity_constraints(const dealii::DoFHandler<2> &,
                              const Lattice<2> &,
                              const dealii::IndexSet &);
  template dealii::AffineConstraints<double>
  make_continuity_constraints(const dealii::DoFHandler<3> &,
                              const Lattice<3> &,
                              const dealii::IndexSet &);
} // namespace feib
