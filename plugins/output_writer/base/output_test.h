// SPDX-License-Identifier: LGPL-2.1-or-later
// What the tests of the output writers share.
#ifndef feib_output_test_h
#define feib_output_test_h

#include <feib/output_writer.h>
#include <feib/testing/spaces.h>

#include <deal.II/base/mpi.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include <unistd.h>

namespace feib::testing
{
  /// A folder that all ranks share and that goes away with the object.
  class TemporaryFolder
  {
  public:
    TemporaryFolder()
    {
      std::string name = (std::filesystem::temp_directory_path() / "feib_output_XXXXXX").string();
      if (rank() == 0)
        name = mkdtemp(name.data());
      path = dealii::Utilities::MPI::broadcast(MPI_COMM_WORLD, name, 0);
    }

    ~TemporaryFolder()
    {
      MPI_Barrier(MPI_COMM_WORLD);
      if (rank() == 0)
        std::filesystem::remove_all(path);
    }

    /// Makes a file of the folder one on a full disk.
    void
    make_full(const std::string &file) const
    {
      if (rank() == 0)
        std::filesystem::create_symlink("/dev/full", path + "/" + file);
      MPI_Barrier(MPI_COMM_WORLD);
    }

    std::string
    read(const std::string &file) const
    {
      std::ifstream in(path + "/" + file, std::ios::binary);
      return {std::istreambuf_iterator<char>(in), {}};
    }

    static unsigned int
    rank()
    {
      return dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
    }

    std::string path;
  };

  /// The message of the RunFailure that the call must throw; nothing when it does not.
  template <typename Call>
  std::string
  failure_of(const Call &call)
  {
    try
      {
        call();
      }
    catch (const RunFailure &failure)
      {
        return failure.what();
      }
    return "";
  }

  /// Fields that the spaces hold exactly.
  template <int dim>
  dealii::Tensor<1, dim>
  exact_velocity(const dealii::Point<dim> &x)
  {
    dealii::Tensor<1, dim> u;
    u[0] = 1 + x[0] * x[0] - 2 * x[0] * x[1];
    u[1] = x[1] * x[1] + 3 * x[0] - x[dim - 1];
    u[dim - 1] += .5 * x[0] * x[dim - 1];
    return u;
  }

  template <int dim>
  double
  exact_pressure(const dealii::Point<dim> &x)
  {
    return 2 - x[0] + 3 * x[1] + .5 * x[dim - 1];
  }

  /// A partly refined mesh with these fields.
  template <int dim>
  std::unique_ptr<EulerianSpace<dim>>
  make_state()
  {
    // Open on all sides: no boundary value disturbs the fields.
    std::string faces;
    for (const char *face : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
      if (dim == 3 || face[0] != 'z')
        faces += (faces.empty() ? "\"" : ", \"") + std::string(face) + R"(": {"outflow": {}})";
    auto space =
      make_space<dim>(std::string(dim == 2 ? R"({"cells": [4, 3])" : R"({"cells": [2, 3, 2])") +
                      R"(, "boundary": {)" + faces + "}}");
    refine_where(*space, [](const auto &x) { return x[0] < .5; });

    const dealii::FiniteElement<dim> &fe = space->pressure_handler().get_fe();
    const std::uint64_t n                = space->cells().size();
    for (unsigned int c = 0; c < n; ++c)
      {
        const auto &cell = space->cells()[c];
        for (unsigned int i = 0; i < EulerianSpace<dim>::n_nodes; ++i)
          {
            dealii::Point<dim> x = cell.lower;
            unsigned int rest    = i;
            for (unsigned int a = 0; a < dim; ++a, rest /= 3)
              x[a] += cell.size[a] * (rest % 3) / 2.;
            for (unsigned int a = 0; a < dim; ++a)
              if (const auto dof = space->velocity_dofs(c)[a * EulerianSpace<dim>::n_nodes + i];
                  dof < space->velocity.locally_owned_size())
                space->velocity.local_element(dof) = exact_velocity<dim>(x)[a];
          }
        const unsigned int *dofs               = space->pressure_dofs(c);
        space->pressure.local_element(dofs[0]) = exact_pressure<dim>(cell.lower + .5 * cell.size);
        for (unsigned int a = 0; a < dim; ++a)
          {
            dealii::Point<dim> low, high;
            high[a] = 1;
            dealii::Tensor<1, dim> edge;
            edge[a]            = cell.size[a];
            const double slope = fe.shape_value(1 + a, high) - fe.shape_value(1 + a, low);
            space->pressure.local_element(dofs[1 + a]) =
              (exact_pressure<dim>(cell.lower + edge) - exact_pressure<dim>(cell.lower)) / slope;
          }
      }
    space->distribute(space->velocity, false);
    return space;
  }
} // namespace feib::testing

#endif
