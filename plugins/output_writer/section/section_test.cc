// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/output_writer_kit.h>

#include <gtest/gtest.h>

#include <sstream>

FEIB_TEST_OUTPUT_WRITER("section");

namespace
{
  using namespace feib;
  using feib::testing::TemporaryFolder;

  /// The numbers of the last row of a section of the state with exact fields.
  template <int dim>
  std::vector<double>
  last_row(const std::string &block)
  {
    const TemporaryFolder folder;
    const auto space = feib::testing::make_state<dim>();
    const std::vector<ImmersedStructure<dim>> structures;
    const Ledger ledger;
    const auto writer =
      feib::testing::registry().create<OutputWriter<dim>>("section",
                                                          R"({"name": "s", )" + block + "}");
    writer->check({*space, structures, {0.}});
    writer->write({3, .25, folder.path, *space, structures, ledger});
    std::istringstream lines(folder.read("section_s.csv"));
    std::string header, line, field;
    std::getline(lines, header);
    EXPECT_EQ(header,
              dim == 2 ? "step,time,area,flux,velocity_x,velocity_y,pressure"
                       : "step,time,area,flux,velocity_x,velocity_y,velocity_z,pressure");
    std::getline(lines, line);
    std::vector<double> row;
    for (std::istringstream fields(line); std::getline(fields, field, ',');)
      row.push_back(std::stod(field));
    MPI_Barrier(MPI_COMM_WORLD);
    return row;
  }

  std::string
  refusal(const std::string &block)
  {
    const auto space = feib::testing::make_state<2>();
    const std::vector<ImmersedStructure<2>> structures;
    try
      {
        feib::testing::registry()
          .create<OutputWriter<2>>("section", R"({"name": "s", )" + block + "}")
          ->check({*space, structures, {0.}});
      }
    catch (const Error &error)
      {
        return error.what();
      }
    return "";
  }
} // namespace


/// The state has a velocity of degree two and a pressure of degree one, on cells of two levels.
TEST(Section, IntegralsOfTheSpacesFieldsAreExact)
{
  const auto integral = [](const double from, const double to, const auto &f) {
    const double half = (to - from) / 2, middle = (from + to) / 2; // Simpson: exact for these
    return half / 3 * (f(from) + 4 * f(middle) + f(to));
  };
  struct Example
  {
    std::string block;
    double x, from, to;
  };
  for (const Example &example :
       {Example{R"("normal": "x", "at": 0.3)", .3, 0, 1},
        Example{R"("normal": "x", "at": 0.5)", .5, 0, 1},
        Example{R"("normal": "x", "at": 1)", 1, 0, 1},
        Example{R"("normal": "x", "at": 0)", 0, 0, 1},
        Example{
          R"("normal": "x", "at": 0.4, "lower": [7, 0.13], "upper": [7, 0.66])", .4, .13, .66}})
    {
      SCOPED_TRACE(example.block);
      const std::vector<double> row = last_row<2>(example.block);
      const double area             = example.to - example.from;
      ASSERT_EQ(row.size(), 7);
      EXPECT_EQ(row[0], 3);
      EXPECT_NEAR(row[2], area, 1e-14);
      for (unsigned int a = 0; a < 2; ++a)
        {
          const double flux = integral(example.from, example.to, [&](const double y) {
            return feib::testing::exact_velocity<2>(dealii::Point<2>(example.x, y))[a];
          });
          if (a == 0)
            EXPECT_NEAR(row[3], flux, 1e-13);
          EXPECT_NEAR(row[4 + a], flux / area, 1e-13);
        }
      EXPECT_NEAR(row[6],
                  integral(example.from,
                           example.to,
                           [&](const double y) {
                             return feib::testing::exact_pressure<2>(
                               dealii::Point<2>(example.x, y));
                           }) /
                    area,
                  1e-13);
    }
  const std::vector<double> row =
    last_row<3>(R"("normal": "z", "at": 0.5, "lower": [0, 0.5, 0], "upper": [0.5, 1, 1])");
  ASSERT_EQ(row.size(), 8);
  EXPECT_NEAR(row[2], .25, 1e-14);
  EXPECT_NEAR(row[7], feib::testing::exact_pressure<3>(dealii::Point<3>(.25, .75, .5)), 1e-13);
}


TEST(Section, WhatCannotBeIsRefused)
{
  EXPECT_NE(refusal(R"("normal": "z", "at": 0.5)").find("found \"z\", the dimension is 2"),
            std::string::npos);
  EXPECT_NE(refusal(R"("normal": "x", "at": 1.5)").find("is x = 1.5, the box goes from 0 to 1"),
            std::string::npos);
  EXPECT_NE(
    refusal(R"("normal": "x", "at": 0.5, "lower": [0, 2])").find("leaves nothing of the box"),
    std::string::npos);
  EXPECT_NE(refusal(R"("normal": "x", "at": 0.5, "upper": [0, 1, 2])").find("found 3 coordinates"),
            std::string::npos);
}
