// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/ledger.h>
#include <feib/timers.h>

#include <gtest/gtest.h>

using namespace feib;

TEST(Ledger, KeepsRowsByColumn)
{
  Ledger ledger;
  ledger.add({{"step", 0}, {"energy", 2.5}});
  ledger.add({{"step", 1}, {"energy", 2.0}});
  EXPECT_EQ(ledger.columns(), (std::vector<std::string>{"step", "energy"}));
  EXPECT_EQ(ledger.n_rows(), 2u);
  EXPECT_EQ(ledger.last_row(), (std::vector<double>{1, 2.0}));
  EXPECT_EQ(ledger.first("energy"), 2.5);
  EXPECT_EQ(ledger.last("energy"), 2.0);
}

TEST(Ledger, RefusesOtherColumns)
{
  Ledger ledger;
  EXPECT_THROW(ledger.last("step"), std::logic_error);
  EXPECT_THROW(ledger.add({{"step", 0}, {"step", 1}}), std::logic_error);

  Ledger other;
  other.add({{"step", 0}, {"energy", 1}});
  EXPECT_THROW(other.add({{"step", 1}}), std::logic_error);
  EXPECT_THROW(other.add({{"energy", 1}, {"step", 1}}), std::logic_error);
  EXPECT_THROW(other.first("volume"), std::logic_error);
  EXPECT_EQ(other.n_rows(), 1u);
}

TEST(Timers, NestedSectionsAreChargedOnce)
{
  Timers timers;
  const auto start = std::chrono::steady_clock::now();
  {
    Timers::Section outer(timers, "solve");
    {
      Timers::Section inner(timers, "assemble");
      Timers::Section innermost(timers, "locate");
    }
  }
  const double elapsed =
    std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ASSERT_EQ(timers.seconds().size(), 3u);
  double sum = 0;
  for (const auto &[phase, seconds] : timers.seconds())
    {
      EXPECT_GE(seconds, -1e-12) << phase;
      sum += seconds;
    }
  EXPECT_LE(sum, elapsed);
}
