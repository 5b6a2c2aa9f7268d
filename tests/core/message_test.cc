// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/message.h>

#include <gtest/gtest.h>

using namespace feib;

TEST(Message, PartsInPercent)
{
  EXPECT_EQ(percent(.12345), "12 %");
  EXPECT_EQ(percent(.0012345), "0.12 %");
  EXPECT_EQ(percent(1e-7), "1e-05 %");
  EXPECT_EQ(percent(-.5), "-50 %");
  EXPECT_EQ(percent(.9949), "99 %");
  EXPECT_EQ(percent(.9951), "100 %");
  EXPECT_EQ(percent(1.4), "140 %");
  EXPECT_EQ(percent(219.3), "21930 %");
}
