// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/text_file.h>

#include <feib/error.h>

#include <deal.II/base/mpi.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

namespace feib
{
  namespace
  {
    /// Returns what is wrong with the file, or "".
    std::string
    read(const std::string &file, const bool regular, std::string &text)
    {
      std::error_code problem;
      const std::filesystem::file_status status = std::filesystem::status(file, problem);
      if (std::filesystem::is_directory(status))
        return "is a folder";
      if (status.type() == std::filesystem::file_type::not_found)
        return "there is no such file";
      if (regular && std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        return "is a fifo or a device, not a file";
      std::ifstream stream(file, std::ios::binary);
      if (!stream)
        return "cannot be read";
      // Not by operator<<, which takes a failure after the first piece for the end of the file.
      std::vector<char> piece(1 << 16);
      while (stream.read(piece.data(), piece.size()) || stream.gcount() > 0)
        text.append(piece.data(), stream.gcount());
      return stream.bad() ? "cannot be read" : "";
    }
  } // namespace


  std::string
  read_text_file(const std::string &file,
                 const std::string &named,
                 const bool regular,
                 const MPI_Comm communicator)
  {
    const bool parallel = dealii::Utilities::MPI::job_supports_mpi();
    std::string text, problem;
    if (!parallel || dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
      problem = read(file, regular, text);
    if (parallel)
      {
        problem = dealii::Utilities::MPI::broadcast(communicator, problem);
        // Pieces of any size, unlike the broadcast of an object.
        std::uint64_t size = text.size();
        dealii::Utilities::MPI::broadcast(&size, 1, 0, communicator);
        text.resize(size);
        dealii::Utilities::MPI::broadcast(text.data(), size, 0, communicator);
      }
    if (!problem.empty())
      throw Error(named + ": " + problem);
    return text;
  }
} // namespace feib
