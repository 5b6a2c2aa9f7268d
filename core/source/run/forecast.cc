// SPDX-License-Identifier: LGPL-2.1-or-later
#include "forecast.h"

#include <feib/error.h>

#include <deal.II/base/mpi.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace feib
{
  namespace
  {
    /// What a run needs [bytes], measured with a fluid alone: per rank, and per cell.
    template <int dim>
    double
    memory_of(const double n_cells, const MPI_Comm communicator)
    {
      return 180e6 * dealii::Utilities::MPI::n_mpi_processes(communicator) +
             n_cells * (dim == 2 ? 5.2e3 : 14e3);
    }


    /// What the ranks may use [bytes].
    double
    memory_of_machines(const MPI_Comm communicator)
    {
      MPI_Comm machine;
      MPI_Comm_split_type(communicator, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
      double share = double(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGE_SIZE) /
                     dealii::Utilities::MPI::n_mpi_processes(machine);
      MPI_Comm_free(&machine);
      struct rlimit limit;
      if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
        share = std::min(share, double(limit.rlim_cur));
      return dealii::Utilities::MPI::sum(share, communicator);
    }


    std::string
    bytes(const double n)
    {
      std::ostringstream text;
      if (n < .995e9)
        text << std::round(n / 1e7) * 10 << " MB";
      else if (n < 1e11)
        text << std::round(n / 1e8) / 10 << " GB";
      else
        text << std::round(n / 1e9) << " GB";
      return text.str();
    }


    /// The shortest and the longest edge of a structure where it is.
    template <int dim>
    std::pair<double, double>
    edges(const StructureModel<dim> &model)
    {
      double shortest = std::numeric_limits<double>::max(), longest = 0;
      for (const auto &element : model.mesh().elements())
        for (unsigned int k = 0; k <= model.mesh().structure_dim(); ++k)
          for (unsigned int l = 0; l < k; ++l)
            {
              const double edge =
                model.positions[element.nodes[k]].distance(model.positions[element.nodes[l]]);
              shortest = std::min(shortest, edge);
              longest  = std::max(longest, edge);
            }
      return {shortest, longest};
    }
  } // namespace


  std::vector<double>
  sample_times(const double end)
  {
    std::vector<double> times = {0.};
    for (unsigned int k = 1; k < 7; ++k)
      times.push_back(end * std::fmod(k * .6180339887498949, 1.));
    times.push_back(end);
    return times;
  }


  template <int dim>
  void
  check_size(const double n_cells, const std::string &pointer, const MPI_Comm communicator)
  {
    std::ostringstream message;
    message.precision(3);
    message << "makes a mesh of about " << n_cells << " cells, ";
    if (n_cells > Domain<dim>::most_cells)
      {
        message << "at most " << Domain<dim>::most_cells << " are allowed";
        throw Error(pointer, message.str());
      }
    const double needed = memory_of<dim>(n_cells, communicator),
                 there  = memory_of_machines(communicator);
    if (needed > there)
      {
        message << "which takes at least " << bytes(needed) << " of memory, more than the "
                << bytes(there) << " there are";
        throw Error(pointer, message.str());
      }
  }


  template <int dim>
  std::string
  size_text(const EulerianSpace<dim> &space, const std::vector<ImmersedStructure<dim>> &structures)
  {
    const double n_cells = space.triangulation().n_global_active_cells();
    const double h_x     = space.smallest_edge();
    std::ostringstream text;
    text << space.triangulation().n_global_active_cells() << " cells, "
         << space.velocity_handler().n_dofs() << " velocity and "
         << space.pressure_handler().n_dofs() << " pressure unknowns, about "
         << bytes(memory_of<dim>(n_cells, space.communicator())) << " of memory\n";
    text.precision(3);
    for (const ImmersedStructure<dim> &structure : structures)
      {
        const StructureModel<dim> &model = *structure.model;
        const auto [shortest, longest]   = edges(model);
        text << "structure \"" << model.name() << "\": " << model.mesh().n_nodes() << " nodes, "
             << model.mesh().n_elements() << " elements with edges of " << shortest << " to "
             << longest << "; the longest is " << longest / h_x
             << " times the smallest cells' edge, " << h_x << '\n';
        for (const auto &remark : model.mesh().remarks())
          text << "warning: the structure \"" << model.name() << "\": " << remark.text << '\n';
      }
    return text.str();
  }


  template void check_size<2>(double, const std::string &, MPI_Comm);
  template void check_size<3>(double, const std::string &, MPI_Comm);
  template std::string size_text(const EulerianSpace<2> &,
                                 const std::vector<ImmersedStructure<2>> &);
  template std::string size_text(const EulerianSpace<3> &,
                                 const std::vector<ImmersedStructure<3>> &);
} // namespace feib
