#include <feib/output_writer.h>
#include <feib/testing/plugins.h>

#include <gtest/gtest.h>

TEST(MyWriter, IsMade)
{
  const auto writer =
    feib::testing::registry().create<feib::OutputWriter<2>>("my_writer", R"({"interval": 3})");
  EXPECT_EQ(writer->interval(), 3u);
  EXPECT_NO_THROW(feib::testing::registry().create<feib::OutputWriter<3>>("my_writer"));
}
