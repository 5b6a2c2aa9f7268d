// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/output_writer_kit.h>

#include <gtest/gtest.h>

#include <map>
#include <sstream>

FEIB_TEST_OUTPUT_WRITER("probe");

namespace
{
  using namespace feib;
  using feib::testing::TemporaryFolder;

  using Row = std::vector<double>;

  /// The header, then rows of numbers.
  std::string
  read_table(const std::string &text, std::vector<Row> &rows)
  {
    std::istringstream lines(text);
    std::string header, line, field;
    std::getline(lines, header);
    while (std::getline(lines, line))
      {
        std::istringstream fields(line);
        rows.emplace_back();
        while (std::getline(fields, field, ','))
          rows.back().push_back(std::strtod(field.c_str(), nullptr));
      }
    return header;
  }

  template <int dim>
  void
  check_values(const std::string &at, const std::vector<dealii::Point<dim>> &points)
  {
    const TemporaryFolder folder;
    const auto space = feib::testing::make_state<dim>();
    const std::vector<ImmersedStructure<dim>> structures;
    const Ledger ledger;
    const auto writer =
      feib::testing::registry().create<OutputWriter<dim>>("probe",
                                                          R"({"name": "a_1", "at": )" + at + "}");
    writer->write({0, 0., folder.path, *space, structures, ledger});
    writer->write({3, .25, folder.path, *space, structures, ledger});

    std::vector<Row> rows;
    EXPECT_EQ(read_table(folder.read("probe_a_1.csv"), rows),
              dim == 2 ? "step,time,point,x,y,velocity_x,velocity_y,pressure"
                       : "step,time,point,x,y,z,velocity_x,velocity_y,velocity_z,pressure");
    ASSERT_EQ(rows.size(), 2 * points.size());
    for (unsigned int i = 0; i < rows.size(); ++i)
      {
        const Row &row                     = rows[i];
        const unsigned int p               = i % points.size();
        const dealii::Point<dim> &point    = points[p];
        const dealii::Tensor<1, dim> exact = feib::testing::exact_velocity<dim>(point);
        ASSERT_EQ(row.size(), 3 + 2 * dim + 1);
        EXPECT_EQ(row[0], i < points.size() ? 0 : 3);
        EXPECT_EQ(row[1], i < points.size() ? 0 : .25);
        EXPECT_EQ(row[2], p);
        for (unsigned int a = 0; a < dim; ++a)
          {
            EXPECT_NEAR(row[3 + a], point[a], 1e-15);
            EXPECT_NEAR(row[3 + dim + a], exact[a], 1e-13);
          }
        EXPECT_NEAR(row[3 + 2 * dim], feib::testing::exact_pressure<dim>(point), 1e-13);
      }
    // No rank starts the next case while another still reads.
    MPI_Barrier(MPI_COMM_WORLD);
  }

  /// The message of the error that the block of a probe in two dimensions must cause.
  std::string
  refusal(const std::string &block)
  {
    try
      {
        feib::testing::registry().create<OutputWriter<2>>("probe", block);
      }
    catch (const Error &error)
      {
        return error.what();
      }
    return "";
  }

  TEST(Probe, FieldsOfTheSpacesComeBackExactlyOnAnyNumberOfRanks)
  {
    using dealii::Point;
    // In cells of both levels, on faces between them, at corners of the box.
    check_values<2>(
      R"({"points": {"places": [[0.1, 0.2], [0.5, 0.3], [0.77, 0.9], [0, 0], [1, 1]]}})",
      {Point<2>(.1, .2), Point<2>(.5, .3), Point<2>(.77, .9), Point<2>(), Point<2>(1, 1)});
    check_values<3>(R"({"points": {"places": [[0.1, 0.2, 0.3], [1, 0.5, 0]]}})",
                    {Point<3>(.1, .2, .3), Point<3>(1, .5, 0)});

    std::vector<Point<2>> points;
    for (unsigned int i = 0; i < 8; ++i)
      points.emplace_back(i / 7., 1);
    check_values<2>(R"({"segment": {"from": [0, 1], "to": [1, 1], "points": 8}})", points);
    check_values<3>(R"({"segment": {"from": [0, 0, 0], "to": [1, 1, 1], "points": 3}})",
                    {Point<3>(), Point<3>(.5, .5, .5), Point<3>(1, 1, 1)});
  }

  TEST(Probe, WhatCannotBeIsRefused)
  {
    EXPECT_NE(refusal(R"({"name": "a", "at": {"points": {"places": [[0, 0], [1, 2, 3]]}}})")
                .find("found 3"),
              std::string::npos);
    EXPECT_NE(refusal(R"({"name": "a", "at": {"segment": {"from": [0, 0, 0], "to": [1, 1],)"
                      R"( "points": 2}}})")
                .find("the dimension is 2"),
              std::string::npos);
    EXPECT_NE(refusal(R"({"name": "../a", "at": {"points": {"places": [[0, 0]]}}})")
                .find("letters, digits and _"),
              std::string::npos);
  }

  struct Fixture
  {
    explicit Fixture(const std::string &place)
      : writer(feib::testing::registry().create<OutputWriter<2>>(
          "probe",
          R"({"name": "a", "at": {"points": {"places": [)" + place + "]}}}"))
    {}

    std::unique_ptr<EulerianSpace<2>> space = feib::testing::make_space<2>(R"({"cells": [2, 2]})");
    std::vector<ImmersedStructure<2>> structures;
    std::unique_ptr<OutputWriter<2>> writer;
  };

  TEST(Probe, PointsOutsideTheBoxAreIssuesBeforeARun)
  {
    Fixture f("[0.5, 1.5], [0.5, 0.5], [-1, 0]");
    try
      {
        f.writer->check({*f.space, f.structures, {0.}});
        FAIL();
      }
    catch (const Error &error)
      {
        ASSERT_EQ(error.issues().size(), 2U);
        EXPECT_EQ(error.issues()[0].pointer, "/at/points/places/0");
        EXPECT_EQ(error.issues()[0].message, "is at (0.5 1.5), the box goes from (0 0) to (1 1)");
        EXPECT_EQ(error.issues()[1].pointer, "/at/points/places/2");
      }
  }

  /// Points of a structure go with it; a curve's place is its first coordinate.
  TEST(Probe, RidesOnStructures)
  {
    TemporaryFolder folder;
    const auto space = feib::testing::make_space<2>(feib::testing::open_box<2>("[4, 4]"));
    std::vector<ImmersedStructure<2>> structures(2);
    structures[0].model = feib::testing::registry().create<StructureModel<2>>(
      "membrane",
      R"({"name": "string", "law": {"neo_hookean": {"shear_modulus": 1}},
          "mesh": {"open_curve": {"length": 1, "elements": 4}}, "initial_position": ["0.2*s1", 0.1]})");
    structures[1].model = feib::testing::registry().create<StructureModel<2>>(
      "hyperelastic",
      R"({"name": "body", "law": {"neo_hookean": {"shear_modulus": 1}},
          "mesh": {"rectangle": {"lower": [0.1, 0.1], "upper": [0.3, 0.3], "cells": [2, 2]}}})");
    const CheckContext<2> context{*space, structures, {0.}};
    const auto make = [&](const std::string &at) {
      auto writer = feib::testing::registry().create<OutputWriter<2>>(
        "probe", R"({"name": "a", "at": {"structure": )" + at + "}}");
      writer->check(context);
      return writer;
    };
    const Ledger ledger;
    const auto on_string = make(R"({"name": "string", "places": [[0.3, 0], [1, 0]]})");
    on_string->write({0, 0., folder.path, *space, structures, ledger});
    const std::string text = folder.read("probe_a.csv");
    EXPECT_NE(text.find("\n0,0,0,0.06"), std::string::npos) << text;
    EXPECT_NE(text.find("\n0,0,1,0.2"), std::string::npos) << text;

    TemporaryFolder other;
    const auto on_body = make(R"({"name": "body", "places": [[0.125, 0.21875]]})");
    for (dealii::Point<2> &x : structures[1].model->positions)
      x[0] += x[1];
    on_body->write({3, .5, other.path, *space, structures, ledger});
    EXPECT_NE(other.read("probe_a.csv").find("\n3,0.5,0,0.34375,0.21875,"), std::string::npos)
      << other.read("probe_a.csv");

    for (const auto &[at, sentence] : std::map<std::string, std::string>{
           {R"({"name": "bodi", "places": [[0, 0]]})",
            "found \"bodi\"; the structures are string, body"},
           {R"({"name": "body", "places": [[0.2, 0.2], [0.2, 0.4]]})",
            "is (0.2 0.4), where the structure \"body\" has no reference place"}})
      try
        {
          make(at);
          ADD_FAILURE() << at;
        }
      catch (const Error &error)
        {
          EXPECT_NE(std::string(error.what()).find(sentence), std::string::npos) << error.what();
        }
  }
} // namespace
