// SPDX-License-Identifier: LGPL-2.1-or-later
// How the tests of the kits see what a kit says of a component.
#ifndef feib_tests_kits_kit_test_h
#define feib_tests_kits_kit_test_h

#include <feib/testing/plugins.h>

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace feib::testing
{
  /// Wrong components are found like those of any other folder of plugins.
  [[maybe_unused]] static const int found = setenv("FEIB_PLUGIN_PATH", FEIB_WRONG_COMPONENTS, 1);

  /// What a requirement of a kit says, put together; "" when it is met.
  template <typename Requirement>
  std::string
  judgement(const Requirement &requirement)
  {
    ::testing::TestPartResultArray results;
    {
      const ::testing::ScopedFakeTestPartResultReporter reporter(
        ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ALL_THREADS, &results);
      try
        {
          requirement();
        }
      catch (const std::exception &failure)
        {
          ADD_FAILURE() << failure.what();
        }
    }
    std::string said;
    for (int i = 0; i < results.size(); ++i)
      said += std::string(results.GetTestPartResult(i).message()) + "\n";
    return said;
  }

  /// Called, expects a requirement of a kit to name a fault of the component, which is made of
  /// another one.
  struct ExpectNamed
  {
    std::string component, of;

    template <typename Requirement>
    void
    operator()(const Requirement &requirement,
               const std::string &fault,
               const std::string &sentence) const
    {
      const std::string block = "{\"of\": " + of + ", \"fault\": \"" + fault + "\"}",
                        said  = judgement([&] { requirement(component, block); });
      EXPECT_NE(said.find(sentence), std::string::npos) << fault << ": " << said;
    }
  };
} // namespace feib::testing

#endif
