// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kit_test.h"

#include <feib/testing/output_writer_kit.h>

// Without a fault the kit finds none.
FEIB_TEST_OUTPUT_WRITER("wrong_writer");

namespace
{
  using namespace feib::testing;

  const ExpectNamed expect_named{
    "wrong_writer",
    R"({"probe": {"name": "a", "at": {"points": {"places": [[0.5, 0.5]]}}}})"};
} // namespace

TEST(OutputWriterKitItself, NamesWhatIsWrong)
{
  expect_named(check_reopen<2>, "doubles a row", "is not that of a run that was not killed");
  expect_named(check_reopen<2>, "loses a row", "is not that of a run that was not killed");
  expect_named(check_reopen<2>, "forgets its files", "probe_a.csv");
  expect_named(check_missing_files<2>, "does not miss files", "reopen() says \"\"");
  expect_named(check_unwritable<2>, "swallows failures", "write() says \"\"");
  expect_named(check_unwritable<2>, "nameless failures", "write() says \"cannot write\"");
  expect_named(check_interval<2>, "never", "interval");
}
