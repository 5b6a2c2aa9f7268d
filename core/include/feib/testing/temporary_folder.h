// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_temporary_folder_h
#define feib_testing_temporary_folder_h

#include <feib/error.h>

#include <deal.II/base/mpi.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <string>

#include <unistd.h>

namespace feib::testing
{
  /// A folder that all ranks share and that goes away with the object. All functions but read() are
  /// collective.
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
      on_first_rank([&] { std::filesystem::remove_all(path); });
    }

    TemporaryFolder(const TemporaryFolder &)            = delete;
    TemporaryFolder &operator=(const TemporaryFolder &) = delete;

    /// Makes a file of the folder one on a full disk.
    void
    make_full(const std::string &file) const
    {
      on_first_rank([&] {
        std::filesystem::create_directories(std::filesystem::path(path + "/" + file).parent_path());
        std::filesystem::create_symlink("/dev/full", path + "/" + file);
      });
    }

    std::string
    read(const std::string &file) const
    {
      std::ifstream in(path + "/" + file, std::ios::binary);
      return {std::istreambuf_iterator<char>(in), {}};
    }

    /// All files of the folder, names and bytes.
    std::map<std::string, std::string>
    contents() const
    {
      std::map<std::string, std::string> result;
      MPI_Barrier(MPI_COMM_WORLD);
      for (const auto &entry : std::filesystem::recursive_directory_iterator(path))
        if (entry.is_regular_file())
          {
            const std::string name = std::filesystem::relative(entry.path(), path).string();
            result[name]           = read(name);
          }
      MPI_Barrier(MPI_COMM_WORLD);
      return result;
    }

    /// Something that is done once, when all ranks have come, and before any goes on.
    static void
    on_first_rank(const std::function<void()> &action)
    {
      MPI_Barrier(MPI_COMM_WORLD);
      if (rank() == 0)
        action();
      MPI_Barrier(MPI_COMM_WORLD);
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
