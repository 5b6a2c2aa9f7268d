// SPDX-License-Identifier: LGPL-2.1-or-later
#include "provenance.h"

#include <feib/error.h>
#include <feib/text_file.h>
#include <feib/version.h>

#include <boost/crc.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <set>
#include <sstream>

namespace feib
{
  namespace
  {
    using Json = nlohmann::json;

    void
    add_files(const Json &value, std::set<std::string> &files)
    {
      if (value.is_object())
        if (const auto file = value.find("file"); file != value.end() && file->is_string())
          files.insert(file->get<std::string>());
      if (value.is_structured())
        for (const Json &part : value)
          add_files(part, files);
    }


    std::string
    checksum(const std::string &file)
    {
      try
        {
          const std::string bytes = read_text_file(file, file, true);
          boost::crc_32_type crc;
          crc.process_bytes(bytes.data(), bytes.size());
          std::ostringstream text;
          text << "of checksum " << std::hex << crc.checksum();
          return text.str();
        }
      catch (const Error &)
        {
          return "that cannot be read";
        }
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
    const std::filesystem::path folder = description.parameters().directory();
    std::set<std::string> files;
    add_files(Json::parse(text), files);
    for (const std::string &file : files)
      result["the file " + file] = checksum((folder / file).string());
    return result;
  }
} // namespace feib
