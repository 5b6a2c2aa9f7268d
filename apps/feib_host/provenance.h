// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_host_provenance_h
#define feib_host_provenance_h

#include <feib/case.h>
#include <feib/plugin_loader.h>

#include <map>
#include <string>

namespace feib
{
  /// What a case computes depends on, beside its text: the versions of Feib and of the plugins it
  /// uses, by name, and the checksums of the files it names with a key "file", by their pointers;
  /// for outputs neither. The same on all ranks; collective.
  std::map<std::string, std::string> provenance(const PluginLoader &loader,
                                                const Case &description);
} // namespace feib

#endif
