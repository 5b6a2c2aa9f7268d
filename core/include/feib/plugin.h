// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugin_h
#define feib_plugin_h

#include <feib/header_hash.h>
#include <feib/registry.h>

#include <deal.II/base/config.h>

#include <cstdint>

/// Counts the layouts of what a plugin hands to the program that loads it; another number is
/// refused. A plugin that was compiled with other public headers is refused by the build tag: with
/// reordered virtual functions it would compute wrong numbers without any error.
#define FEIB_ABI 6

#define FEIB_STRINGIZE_(x) #x
#define FEIB_STRINGIZE(x) FEIB_STRINGIZE_(x)

#ifdef DEBUG
#define FEIB_BUILD_TYPE "debug"
#else
#define FEIB_BUILD_TYPE "release"
#endif

/// What must be the same in the host and in a plugin for their objects to have the same layout.
#define FEIB_BUILD_TAG                                                      \
  "deal.II " DEAL_II_PACKAGE_VERSION " " FEIB_BUILD_TYPE                    \
  ", compiler " FEIB_STRINGIZE(__GNUC__) ", libstdc++ abi " FEIB_STRINGIZE( \
    _GLIBCXX_USE_CXX11_ABI) ", headers " FEIB_HEADER_HASH

/// The only symbol a plugin exports: plain data, read before any code of the plugin is trusted.
struct FeibPlugin
{
  std::uint32_t abi;
  const char *build_tag;
  const char *name;
  const char *version;
  void (*add_components)(feib::Registry &);
};

/// Defines a plugin; the body adds its components to the registry:
/// @code
/// FEIB_PLUGIN("my_law", "1.0", registry)
/// {
///   registry.add<feib::ConstitutiveLaw, MyLaw>("my_law", my_law_schema);
/// }
/// @endcode
#define FEIB_PLUGIN(name_, version_, registry_)                                      \
  static void feib_add_components(feib::Registry &);                                 \
  extern "C" __attribute__((visibility("default"))) const FeibPlugin feib_plugin = { \
    FEIB_ABI, FEIB_BUILD_TAG, name_, version_, &feib_add_components};                \
  static void feib_add_components(feib::Registry &registry_)

#endif
