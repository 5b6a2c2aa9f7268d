// SPDX-License-Identifier: LGPL-2.1-or-later
#include "checkpoint.h"

#include "text_file.h"

#include <feib/failure.h>
#include <feib/log.h>
#include <feib/message.h>

#include <deal.II/base/mpi.h>

#include <boost/crc.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace feib
{
  namespace
  {
    namespace fs = std::filesystem;

    const char *const values_file   = "values";
    const char *const fields_file   = "fields";
    const char *const manifest_file = "manifest.json";
    const char *const prefix        = "step_";

    bool
    first_rank(const MPI_Comm communicator)
    {
      return dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    }


    void
    check(const int code, const std::string &file)
    {
      if (code == MPI_SUCCESS)
        return;
      char text[MPI_MAX_ERROR_STRING];
      int length = 0;
      MPI_Error_string(code, text, &length);
      throw RunFailure(file + ": " + std::string(text, length));
    }


    template <typename Number>
    void
    append(std::string &bytes, const Number number)
    {
      bytes.append(reinterpret_cast<const char *>(&number), sizeof(number));
    }


    std::uint64_t
    take_number(const std::string &bytes, std::size_t &at)
    {
      std::uint64_t number;
      if (bytes.size() - at < sizeof(number))
        throw RunFailure("a checkpoint ends too early");
      std::memcpy(&number, bytes.data() + at, sizeof(number));
      at += sizeof(number);
      return number;
    }


    std::string
    take_text(const std::string &bytes, std::size_t &at)
    {
      const std::uint64_t size = take_number(bytes, at);
      if (bytes.size() - at < size)
        throw RunFailure("a checkpoint ends too early");
      at += size;
      return bytes.substr(at - size, size);
    }


    /// Waits until a file or a folder is on the disk.
    void
    sync(const fs::path &path)
    {
      const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
      const bool done      = descriptor >= 0 && fsync(descriptor) == 0;
      const int problem    = errno;
      if (descriptor >= 0)
        close(descriptor);
      if (!done)
        throw RunFailure("cannot write " + path.string() + ": " + std::strerror(problem));
    }


    void
    write_file(const fs::path &path, const std::string &text)
    {
      errno = 0;
      std::ofstream stream(path, std::ios::binary);
      stream.write(text.data(), text.size());
      stream.close();
      if (!stream)
        throw RunFailure("cannot write " + path.string() +
                         (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
      sync(path);
    }


    /// Bytes and checksum of a file.
    Json
    seal(const fs::path &path)
    {
      std::ifstream stream(path, std::ios::binary);
      if (!stream)
        throw RunFailure("cannot read " + path.string());
      boost::crc_32_type crc;
      std::uint64_t size = 0;
      std::vector<char> piece(1 << 20);
      while (stream.read(piece.data(), piece.size()) || stream.gcount() > 0)
        {
          crc.process_bytes(piece.data(), stream.gcount());
          size += stream.gcount();
        }
      return {{"bytes", size}, {"crc32", crc.checksum()}};
    }


    std::uint32_t
    checksum(const Json &manifest)
    {
      const std::string text = manifest.dump();
      boost::crc_32_type crc;
      crc.process_bytes(text.data(), text.size());
      return crc.checksum();
    }


    /// The manifest of a checkpoint; throws RunFailure when something about it is wrong.
    Json
    inspect(const fs::path &folder)
    {
      std::ifstream stream(folder / manifest_file);
      if (!stream)
        throw RunFailure("it has no " + std::string(manifest_file));
      Json manifest = Json::parse(stream, nullptr, false);
      if (!manifest.is_object() || !manifest.contains("crc32") || !manifest.contains("files"))
        throw RunFailure(std::string(manifest_file) + " is not whole");
      const Json crc = manifest["crc32"];
      manifest.erase("crc32");
      if (crc != checksum(manifest))
        throw RunFailure(std::string(manifest_file) + " is not what was written");
      for (const auto &[name, sealed] : manifest["files"].items())
        if (seal(folder / name) != sealed)
          throw RunFailure("the file " + name + " is not what was written");
      return manifest;
    }


    /// Those of a run, the newest first.
    std::vector<std::pair<unsigned long, fs::path>>
    list(const fs::path &folder)
    {
      std::vector<std::pair<unsigned long, fs::path>> result;
      std::error_code problem;
      for (const auto &entry : fs::directory_iterator(folder, problem))
        {
          const std::string name = entry.path().filename();
          const std::string rest = name.substr(std::min(name.size(), std::strlen(prefix)));
          if (name.rfind(prefix, 0) == 0 && !rest.empty() && rest.size() < 12 &&
              rest.find_first_not_of("0123456789") == std::string::npos)
            result.emplace_back(std::stoul(rest), entry.path());
        }
      std::sort(result.rbegin(), result.rend());
      return result;
    }
  } // namespace


  template <int dim>
  CheckpointWriter<dim>::CheckpointWriter(const EulerianSpace<dim> &space,
                                          const std::string &folder)
    : Archive(false)
    , space(space)
    , folder(folder)
  {
    const std::string name = folder + "/" + fields_file;
    check(MPI_File_open(space.communicator(),
                        name.c_str(),
                        MPI_MODE_CREATE | MPI_MODE_WRONLY,
                        MPI_INFO_NULL,
                        &file),
          name);
  }


  template <int dim>
  CheckpointWriter<dim>::~CheckpointWriter()
  {
    if (file != MPI_FILE_NULL)
      MPI_File_close(&file);
  }


  template <int dim>
  void
  CheckpointWriter<dim>::write(const std::string &bytes)
  {
    if (!written.emplace(path, true).second)
      throw std::logic_error("two states are called \"" + path + "\"");
    if (!first_rank(space.communicator()))
      return;
    append(values, std::uint64_t(path.size()));
    values += path;
    append(values, std::uint64_t(bytes.size()));
    values += bytes;
  }


  template <int dim>
  std::string
  CheckpointWriter<dim>::read()
  {
    throw std::logic_error("nothing is read while a checkpoint is written");
  }


  template <int dim>
  void
  CheckpointWriter<dim>::field(Vector &vector)
  {
    const auto partitioner = vector.get_partitioner();
    const char kind        = partitioner == space.velocity.get_partitioner()   ? 'v'
                             : partitioner == space.pressure.get_partitioner() ? 'p'
                             : vector.size() == 0                              ? '0'
                                                                               : '?';
    if (kind == '?')
      throw std::logic_error("the field \"" + path + "\" is not of this mesh");
    std::string entry(1, kind);
    append(entry, n_in_file);
    append(entry, std::uint64_t(vector.size()));
    write(entry);
    if (kind == '0')
      return;
    const auto begin = vector.locally_owned_elements().n_elements() > 0
                         ? *vector.locally_owned_elements().begin()
                         : 0;
    check(MPI_File_write_at_all(file,
                                (n_in_file + begin) * sizeof(double),
                                vector.begin(),
                                vector.locally_owned_size(),
                                MPI_DOUBLE,
                                MPI_STATUS_IGNORE),
          folder + "/" + fields_file);
    n_in_file += vector.size();
  }


  template <int dim>
  void
  CheckpointWriter<dim>::finish()
  {
    check(MPI_File_sync(file), folder + "/" + fields_file);
    check(MPI_File_close(&file), folder + "/" + fields_file);
    agree(space.communicator(), [&] {
      if (first_rank(space.communicator()))
        write_file(fs::path(folder) / values_file, values);
    });
  }


  template <int dim>
  CheckpointReader<dim>::CheckpointReader(const EulerianSpace<dim> &space,
                                          const std::string &folder)
    : Archive(true)
    , space(space)
  {
    const std::string name  = folder + "/" + values_file;
    const std::string bytes = read_text_file(name, name, true);
    for (std::size_t at = 0; at < bytes.size();)
      {
        const std::string place = take_text(bytes, at);
        values[place]           = take_text(bytes, at);
      }
    const std::string fields = folder + "/" + fields_file;
    check(
      MPI_File_open(space.communicator(), fields.c_str(), MPI_MODE_RDONLY, MPI_INFO_NULL, &file),
      fields);
  }


  template <int dim>
  CheckpointReader<dim>::~CheckpointReader()
  {
    if (file != MPI_FILE_NULL)
      MPI_File_close(&file);
  }


  template <int dim>
  bool
  CheckpointReader<dim>::contains(const std::string &place) const
  {
    const auto below = values.lower_bound(place + "/");
    return values.count(place) > 0 ||
           (below != values.end() && below->first.rfind(place + "/", 0) == 0);
  }


  template <int dim>
  void
  CheckpointReader<dim>::write(const std::string &)
  {
    throw std::logic_error("nothing is written while a checkpoint is read");
  }


  template <int dim>
  std::string
  CheckpointReader<dim>::read()
  {
    const auto entry = values.find(path);
    if (entry == values.end())
      throw RunFailure("the checkpoint has no state \"" + path + "\"");
    return entry->second;
  }


  template <int dim>
  void
  CheckpointReader<dim>::field(Vector &vector)
  {
    const std::string entry = read();
    std::size_t at          = 1;
    const auto begin        = take_number(entry, at);
    const auto size         = take_number(entry, at);
    if (entry[0] == '0')
      {
        vector.reinit(0);
        return;
      }
    vector.reinit(entry[0] == 'v' ? space.velocity.get_partitioner()
                                  : space.pressure.get_partitioner());
    if (vector.size() != size)
      throw RunFailure("the field \"" + path + "\" has " + std::to_string(size) +
                       " unknowns, the mesh " + std::to_string(vector.size()));
    const auto first = vector.locally_owned_elements().n_elements() > 0
                         ? *vector.locally_owned_elements().begin()
                         : 0;
    check(MPI_File_read_at_all(file,
                               (begin + first) * sizeof(double),
                               vector.begin(),
                               vector.locally_owned_size(),
                               MPI_DOUBLE,
                               MPI_STATUS_IGNORE),
          fields_file);
    vector.update_ghost_values();
  }


  Checkpoints::Checkpoints(const Parameters &parameters)
    : interval(parameters.integer("interval"))
    , keep(parameters.integer("keep"))
    , seconds(parameters.number("seconds"))
    , last(std::chrono::steady_clock::now())
  {}


  bool
  Checkpoints::due(const unsigned int step, const MPI_Comm communicator) const
  {
    if (interval > 0 && step % interval == 0)
      return true;
    if (seconds == 0)
      return false;
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - last;
    return dealii::Utilities::MPI::max(int(since.count() >= seconds), communicator) != 0;
  }


  void
  Checkpoints::write(const std::string &run_folder,
                     const unsigned int step,
                     Json manifest,
                     const MPI_Comm communicator,
                     const std::function<void(const std::string &)> &fill)
  {
    if (last_step == int(step))
      return; // it is there already
    const fs::path all       = fs::path(run_folder) / "checkpoints";
    const fs::path temporary = all / "unfinished";
    const fs::path final     = all / (prefix + std::to_string(step));
    const auto on_first_rank = [&](const std::function<void()> &action) {
      agree(communicator, [&] {
        try
          {
            if (first_rank(communicator))
              action();
          }
        catch (const fs::filesystem_error &failure)
          {
            throw RunFailure(std::string("cannot write a checkpoint: ") + failure.what());
          }
      });
    };
    on_first_rank([&] {
      fs::remove_all(temporary);
      fs::create_directories(temporary);
    });
    fill(temporary.string());
    on_first_rank([&] {
      manifest["files"] = {{values_file, seal(temporary / values_file)},
                           {fields_file, seal(temporary / fields_file)}};
      manifest["crc32"] = checksum(manifest);
      write_file(temporary / manifest_file, manifest.dump(1) + "\n");
      sync(temporary);
      // One of the same step, from before a restart, holds the same.
      fs::remove_all(final);
      fs::rename(temporary, final);
      sync(all);
      // What is later than this one was found damaged when the run was taken up again.
      unsigned int n = 0;
      for (const auto &[number, path] : list(all))
        if (number > step || ++n > keep)
          fs::remove_all(path);
    });
    last      = std::chrono::steady_clock::now();
    last_step = step;
  }


  std::pair<std::string, Json>
  Checkpoints::newest(const std::string &run_folder)
  {
    std::string folder, text, problem;
    std::vector<std::string> damaged;
    if (first_rank(MPI_COMM_WORLD))
      {
        const auto known = list(fs::path(run_folder) / "checkpoints");
        for (const auto &[step, path] : known)
          try
            {
              text   = inspect(path).dump();
              folder = path.string();
              break;
            }
          catch (const RunFailure &failure)
            {
              damaged.push_back("the checkpoint " + path.string() +
                                " is damaged: " + failure.what());
            }
        if (folder.empty())
          problem = known.empty() ? "there is no checkpoint in " + readable(run_folder) +
                                      "; --restart takes the output folder of a run"
                                  : damaged.front() + "; there is no other";
      }
    const auto share = [](const std::string &value) {
      return dealii::Utilities::MPI::broadcast(MPI_COMM_WORLD, value);
    };
    problem = share(problem);
    if (!problem.empty())
      throw Error(problem);
    for (const std::string &sentence : damaged)
      log::warning(sentence + "; going on from " + folder);
    folder = share(folder);
    return {folder, Json::parse(share(text))};
  }


  template class CheckpointWriter<2>;
  template class CheckpointWriter<3>;
  template class CheckpointReader<2>;
  template class CheckpointReader<3>;
} // namespace feib
