// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_numbers_h
#define feib_testing_numbers_h

#include <gtest/gtest.h>

#include <vector>

namespace feib::testing
{
  /// Whether these are the same numbers to the bit.
  inline void
  expect_same(const std::vector<double> &numbers, const std::vector<double> &expected)
  {
    ASSERT_EQ(numbers.size(), expected.size());
    for (unsigned int i = 0; i < numbers.size(); ++i)
      ASSERT_EQ(numbers[i], expected[i]) << "number " << i << " of " << numbers.size();
  }
} // namespace feib::testing

#endif
