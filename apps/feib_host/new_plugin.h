// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_new_plugin_h
#define feib_new_plugin_h

#include <feib/registry.h>

#include <string>

namespace feib
{
  /// A plugin to be begun with.
  struct NewPlugin
  {
    std::string kind; // of its component, e.g. constitutive_law
    std::string name;
    std::string style;     // of a law: "", "energy_only" or "with_state"
    std::string directory; // the folder to make
  };

  /// Writes the plugin from Feib's template of the kind. Returns what was written and how to go on,
  /// as text. Throws Error, and writes nothing, where the name will not do, something of that name
  /// is there, or the kind has no template. Not collective.
  std::string write(const NewPlugin &plugin, const Registry &registry);
} // namespace feib

#endif
