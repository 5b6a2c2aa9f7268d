// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/output_writer_kit.h>

#include <gtest/gtest.h>

#include <sstream>

FEIB_TEST_OUTPUT_WRITER("ledger_csv");

namespace
{
  using namespace feib;
  using feib::testing::TemporaryFolder;

  struct Fixture
  {
    void
    write()
    {
      writer->write({ledger.n_rows(), 0., folder.path, *space, structures, ledger});
    }

    TemporaryFolder folder;
    std::unique_ptr<EulerianSpace<2>> space = feib::testing::make_space<2>(R"({"cells": [2, 2]})");
    std::vector<ImmersedStructure<2>> structures;
    Ledger ledger;
    std::unique_ptr<OutputWriter<2>> writer =
      feib::testing::registry().create<OutputWriter<2>>("ledger_csv");
  };

  TEST(LedgerCsv, NumbersComeBackAsTheyWere)
  {
    Fixture f;
    const std::vector<std::vector<double>> rows = {{0, 1. / 3, -1e-300},
                                                   {1, 0.1, 6.02214076e23},
                                                   {2, -0., 2. / 7}};
    for (const std::vector<double> &row : rows)
      {
        f.ledger.add({{"step", row[0]}, {"time", row[1]}, {"measure of disc", row[2]}});
        f.write();

        // Every row is there as soon as it is written.
        std::istringstream lines(f.folder.read("ledger.csv"));
        std::string line;
        std::getline(lines, line);
        EXPECT_EQ(line, "step,time,measure of disc");
        for (unsigned int i = 0; i < f.ledger.n_rows(); ++i)
          {
            ASSERT_TRUE(std::getline(lines, line));
            std::istringstream fields(line);
            std::string field;
            for (const double value : rows[i])
              {
                ASSERT_TRUE(std::getline(fields, field, ','));
                EXPECT_EQ(std::strtod(field.c_str(), nullptr), value);
              }
          }
        EXPECT_FALSE(std::getline(lines, line));
        // No rank adds a row while another still reads.
        MPI_Barrier(MPI_COMM_WORLD);
      }
  }

  TEST(LedgerCsv, WritesTheLastRowAndNoRowTwice)
  {
    Fixture f;
    for (const double step : {0., 1., 2.})
      f.ledger.add({{"step", step}});
    f.write();
    f.write();
    EXPECT_EQ(f.folder.read("ledger.csv"), "step\n2\n");
  }

  TEST(LedgerCsv, EveryStepUnlessTold)
  {
    EXPECT_EQ(feib::testing::registry().create<OutputWriter<3>>("ledger_csv")->interval(), 1u);
    EXPECT_EQ(feib::testing::registry()
                .create<OutputWriter<3>>("ledger_csv", R"({"interval": 7})")
                ->interval(),
              7u);
  }
} // namespace
