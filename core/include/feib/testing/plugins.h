// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_plugins_h
#define feib_testing_plugins_h

#include <feib/registry.h>

namespace feib::testing
{
  /// All components of the plugins found on PluginLoader::search_path({}), loaded once.
  const Registry &registry();
} // namespace feib::testing

#endif
