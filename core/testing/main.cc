// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/plugins.h>

#include <feib/log.h>
#include <feib/plugin_loader.h>

#include <deal.II/base/mpi.h>

#include <gtest/gtest.h>

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

int
main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  ::testing::InitGoogleTest(&argc, argv);
  feib::log::set_level("off");
  int result = RUN_ALL_TESTS();
  return dealii::Utilities::MPI::max(result, MPI_COMM_WORLD);
}
