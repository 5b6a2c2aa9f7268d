// SPDX-License-Identifier: LGPL-2.1-or-later
#include "provenance.h"

#include <feib/version.h>

#include <deal.II/base/mpi.h>

#include <boost/crc.hpp>
#include <boost/serialization/map.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <vector>

namespace feib
{
  namespace
  {
    using Json = nlohmann::json;

    /// Of the files named at and below a pointer those that can be read, with their checksums.
    void
    add_files(const Json &value,
              const std::string &pointer,
              const std::filesystem::path &folder,
              std::map<std::string, std::string> &files)
    {
      if (!value.is_structured() || pointer == "/output")
        return;
      for (const auto &[key, part] : value.items())
        if (key == "file" && part.is_string())
          {
            const std::filesystem::path file = folder / part.get<std::string>();
            std::error_code none;
            std::ifstream stream;
            if (std::filesystem::is_regular_file(file, none)) // others may never end
              stream.open(file, std::ios::binary);
            boost::crc_32_type crc;
            std::vector<char> piece(1 << 16);
            while (stream.read(piece.data(), piece.size()) || stream.gcount() > 0)
              crc.process_bytes(piece.data(), stream.gcount());
            if (stream.is_open() && stream.eof()) // all was read
              files[pointer + "/" + key] = std::to_string(crc.checksum());
          }
        else
          add_files(part, pointer + "/" + key, folder, files);
    }
  } // namespace


  std::map<std::string, std::string>
  provenance(const PluginLoader &loader, const Case &description)
  {
    std::map<std::string, std::string> result = {{"Feib", version()}};
    const std::string text                    = description.resolved();
    for (const PluginLoader::Result &plugin : loader.results())
      if (plugin.accepted)
        for (const std::string &component : plugin.components)
          if (component.rfind("output_writer/", 0) != 0 &&
              text.find("\"" + component.substr(component.find('/') + 1) + "\":") !=
                std::string::npos)
            result["the plugin " + plugin.plugin] = plugin.version;
    std::map<std::string, std::string> files;
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      add_files(Json::parse(text), "", description.parameters().directory(), files);
    result.merge(dealii::Utilities::MPI::broadcast(MPI_COMM_WORLD, files));
    return result;
  }
} // namespace feib
