// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugin_loader_h
#define feib_plugin_loader_h

#include <feib/registry.h>

#include <string>
#include <vector>

namespace feib
{
  /// Finds the plugins, checks the handshake of each and lets it add its components to a registry.
  /// A plugin that fails a check is skipped with a reason. Libraries stay open until the process
  /// ends: an object or an exception may outlive any owner of the handle.
  class PluginLoader
  {
  public:
    /// What became of one file.
    struct Result
    {
      std::string file;
      std::string plugin, version;
      bool accepted;
      std::string reason;                  // why it was skipped
      std::vector<std::string> components; // "kind/name"
    };

    explicit PluginLoader(Registry &registry);

    /// Loads every "*.feib.so" of the folder, sorted by name. Throws Error when there is no such
    /// folder.
    void load_directory(const std::string &directory);

    /// Loads one file.
    const Result &load(const std::string &file);

    const std::vector<Result> &results() const;

    /// --plugin-path, then FEIB_PLUGIN_PATH (colon separated), then feib/plugins beside Feib's
    /// library, installed or in a build tree.
    static std::vector<std::string> search_path(const std::vector<std::string> &from_command_line);

  private:
    Registry &registry;
    std::vector<Result> result_list;
  };
} // namespace feib

#endif
