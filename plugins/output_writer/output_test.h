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
} // namespace feib::testing

#endif
