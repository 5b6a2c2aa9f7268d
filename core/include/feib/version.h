// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_version_h
#define feib_version_h

#include <string>

namespace feib
{
  /// The version of Feib, e.g. "0.1.0".
  std::string version();
} // namespace feib

#endif
