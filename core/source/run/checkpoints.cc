// SPDX-License-Identifier: LGPL-2.1-or-later
#include "checkpoints.h"

#include "checkpoint_archive.h"
#include "synced_file.h"

#include <feib/failure.h>
#include <feib/log.h>
#include <feib/message.h>

#include <boost/crc.hpp>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace feib
{
  namespace
  {
    namespace fs = std::filesystem;

    const char *const manifest_file = "manifest.json";
    const char *const prefix        = "step_";

    bool
    first_rank(const MPI_Comm communicator)
    {
      return dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
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
      if (stream.bad())
        throw RunFailure("cannot read " + path.string());
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
      const char *const values        = CheckpointArchive<2>::values_file,
                        *const fields = CheckpointArchive<2>::fields_file;
      manifest["files"] = {{values, seal(temporary / values)}, {fields, seal(temporary / fields)}};
      manifest["crc32"] = checksum(manifest);
      write_synced(temporary / manifest_file, manifest.dump(1) + "\n");
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
  Checkpoints::newest(const std::string &run_folder, const MPI_Comm communicator)
  {
    std::string folder, text, problem;
    std::vector<std::string> damaged;
    if (first_rank(communicator))
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
                                      "; the output folder of a run is needed"
                                  : damaged.front() + "; there is no other";
      }
    const auto share = [communicator](const std::string &value) {
      return dealii::Utilities::MPI::broadcast(communicator, value);
    };
    problem = share(problem);
    if (!problem.empty())
      throw Error(problem);
    for (const std::string &sentence : damaged)
      log::warning(sentence + "; going on from " + folder);
    folder = share(folder);
    return {folder, Json::parse(share(text))};
  }
} // namespace feib
