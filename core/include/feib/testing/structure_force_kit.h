// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_structure_force_kit_h
#define feib_testing_structure_force_kit_h

#include <feib/testing/examples.h>
#include <feib/testing/structure_force_requirements.h>

#include <gtest/gtest.h>

/// Runs the conformance kit for the force of that name.
#define FEIB_TEST_STRUCTURE_FORCE(name) FEIB_TEST_STRUCTURE_FORCE_(name, __LINE__)
#define FEIB_TEST_STRUCTURE_FORCE_(name, line) FEIB_TEST_STRUCTURE_FORCE__(name, line)
#define FEIB_TEST_STRUCTURE_FORCE__(name, line)                                           \
  TEST(StructureForceKit##line, KeepsWhatForcesMust)                                      \
  {                                                                                       \
    feib::testing::for_each_example<feib::StructureForce<2>>(                             \
      name, [](const std::string &example) {                                              \
        const auto findings =                                                             \
          feib::testing::check_structure_force(feib::testing::registry(), name, example); \
        for (const std::string &sentence : findings.sentences)                            \
          ADD_FAILURE() << sentence;                                                      \
      });                                                                                 \
  }                                                                                       \
  static_assert(true, "")

#endif
