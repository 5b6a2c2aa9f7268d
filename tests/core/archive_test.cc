// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/archive.h>

#include <gtest/gtest.h>

using namespace feib;

namespace
{
  struct Part
  {
    double number = 0;
    std::string text;

    void
    archive(Archive &archive)
    {
      archive("number", number);
      archive("text", text);
    }
  };


  struct Whole
  {
    Part part;
    std::vector<dealii::Point<3>> points;
    std::deque<Part> parts;
    std::optional<int> maybe;
    std::map<std::string, double> sums;
    std::shared_ptr<const Part> shared;

    void
    archive(Archive &archive)
    {
      archive("part", part);
      archive("points", points);
      archive("parts", parts);
      archive("maybe", maybe);
      archive("sums", sums);
      archive("shared", shared);
    }
  };
} // namespace


TEST(MemoryArchive, BringsBackWhatWasThere)
{
  Whole object{{1.5, "one"}, {{1, 2, 3}}, {{2, "two"}}, 7, {{"a", .1}}, {}};
  object.shared        = std::make_shared<const Part>(Part{3, "three"});
  const auto first     = object.shared;
  const auto was_there = object;
  MemoryArchive archive;
  for (unsigned int attempt = 0; attempt < 2; ++attempt)
    {
      archive.start_writing();
      EXPECT_FALSE(archive.reading());
      object.archive(archive);
      object = Whole();
      archive.start_reading();
      EXPECT_TRUE(archive.reading());
      object.archive(archive);
      EXPECT_EQ(object.part.number, 1.5);
      EXPECT_EQ(object.part.text, "one");
      EXPECT_EQ(object.points, was_there.points);
      ASSERT_EQ(object.parts.size(), 1u);
      EXPECT_EQ(object.parts[0].text, "two");
      EXPECT_EQ(object.maybe, 7);
      EXPECT_EQ(object.sums, was_there.sums);
      EXPECT_EQ(object.shared, first); // a constant is not copied
    }
  EXPECT_FALSE(archive.persistent());
}


TEST(MemoryArchive, WhatWasNotWrittenIsNotThere)
{
  Part part;
  MemoryArchive archive;
  part.archive(archive);
  archive.start_reading();
  EXPECT_TRUE(archive.has("number"));
  EXPECT_FALSE(archive.has("other"));
  double other = 0;
  EXPECT_THROW(archive("other", other), RunFailure);
}
