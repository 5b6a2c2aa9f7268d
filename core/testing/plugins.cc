// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/plugins.h>

#include <feib/plugin_loader.h>

#include <iostream>

namespace feib::testing
{
  const Registry &
  registry()
  {
    static Registry *const registry = [] {
      auto *result = new Registry;
      PluginLoader loader(*result);
      for (const std::string &directory : PluginLoader::search_path({}))
        loader.load_directory(directory);
      for (const PluginLoader::Result &plugin : loader.results())
        if (!plugin.accepted)
          std::cerr << plugin.file << " skipped: " << plugin.reason << '\n';
      return result;
    }();
    return *registry;
  }
} // namespace feib::testing
