// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/version.h>

namespace feib
{
  std::string
  version()
  {
    return FEIB_VERSION;
  }
} // namespace feib
