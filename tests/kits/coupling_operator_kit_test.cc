// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kit_test.h"

#include <feib/testing/coupling_operator_kit.h>

// Without a fault the kit finds none.
FEIB_TEST_COUPLING_OPERATOR("wrong_coupling")

namespace
{
  using namespace feib::testing;

  const ExpectNamed expect_named{"wrong_coupling", R"({"variational": {}})"};
} // namespace

TEST(CouplingOperatorKitItself, NamesWhatIsWrong)
{
  const auto dualities = [](const auto &name, const auto &block) {
    check_all_dualities<2>(name, 2, block);
  };
  expect_named(dualities, "faster", "the power of J^T f on v");
  expect_named(dualities, "faster within elements", "points within");
  expect_named(dualities, "lacks entries", "entries() of point");
}
