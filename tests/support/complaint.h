// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_tests_complaint_h
#define feib_tests_complaint_h

#include <feib/case.h>
#include <feib/plugin_loader.h>
#include <feib/registry.h>
#include <feib/simulation.h>

namespace feib::testing
{
  /// What is said of a case when its simulation is built, as --validate and runs do; "" when it is
  /// valid. The plugins of the folder, the same in all calls, are known too.
  inline std::string
  complaint(const std::string &text,
            const Case::Settings &settings = {},
            const std::string &plugins     = "")
  {
    static Registry registry;
    [[maybe_unused]] static const bool loaded = [&] {
      PluginLoader loader(registry);
      for (const std::string &folder : PluginLoader::search_path(
             plugins.empty() ? std::vector<std::string>() : std::vector<std::string>{plugins}))
        loader.load_directory(folder);
      return true;
    }();
    try
      {
        const Case description(text, "case.json", registry, settings);
        try
          {
            Simulation::create(description);
          }
        catch (const Error &error)
          {
            return description.format(error.issues());
          }
      }
    catch (const Error &error)
      {
        return Case::format(error.issues(), text, "case.json", settings);
      }
    return "";
  }
} // namespace feib::testing

#endif
