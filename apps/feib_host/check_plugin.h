// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_check_plugin_h
#define feib_check_plugin_h

#include <feib/plugin_loader.h>

#include <functional>
#include <string>

namespace feib
{
  /// Asks of a plugin what can be asked without a compiler, and prints a line for each thing asked,
  /// "ok" or what is wrong, and what is not asked: of laws all that their kit asks, of other
  /// components whether each example is made, fits into a small case and makes steps of it. Nothing
  /// is written. Returns whether all is well. Collective; @p print is called by all ranks.
  ///
  /// @p loader has loaded that plugin first, and then those that its components work with.
  bool check_plugin(const PluginLoader &loader,
                    const Registry &registry,
                    const std::function<void(const std::string &)> &print);
} // namespace feib

#endif
