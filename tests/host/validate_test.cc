// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/complaint.h"
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace feib::testing;
using nlohmann::json;

namespace
{
  /// What only a run used to find: now --validate and the run say the same before anything is
  /// written.
  class Validate : public ::testing::Test
  {
  protected:
    static json
    small()
    {
      return json::parse(R"({
        "dimension": 2,
        "domain": { "cells": [4, 4], "boundary": {} },
        "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1 } },
        "time": { "step": 0.01, "end": 0.02, "integrator": { "lagged_be": {} } } })");
    }

    static json
    velocity(const json &value)
    {
      return {{"velocity", {{"value", value}}}};
    }

    static json
    disc(const double radius = .2)
    {
      return {{"hyperelastic",
               {{"name", "disc"},
                {"mesh", {{"disc", {{"centre", {.5, .5}}, {"radius", radius}, {"rings", 4}}}}},
                {"law", {{"neo_hookean", {{"shear_modulus", 1}, {"stress_free", true}}}}}}}};
    }

    RunResult
    host(const json &description, const std::string &arguments = "", const unsigned int ranks = 1)
    {
      folder.write("case.json", description.dump(1));
      return run_host("case.json --output out --overwrite " + arguments,
                      ranks,
                      folder.path.string());
    }

    /// One issue per entry: it must hold all the words, and the line a place in the file.
    void
    refused(const json &description, const std::vector<std::vector<std::string>> &issues)
    {
      std::filesystem::remove_all(folder / "out");
      const RunResult validated = host(description, "--validate");
      EXPECT_EQ(validated.exit_code, 2);
      // The same code says so in a run: once per test will do.
      if (!compared)
        {
          const RunResult run = host(description);
          EXPECT_EQ(run.exit_code, 2);
          EXPECT_EQ(validated.output, run.output);
          compared = true;
        }
      EXPECT_FALSE(std::filesystem::exists(folder / "out"));
      std::istringstream stream(validated.output);
      std::vector<std::string> lines;
      for (std::string line; std::getline(stream, line);)
        lines.push_back(line);
      ASSERT_EQ(lines.size(), issues.size()) << validated.output;
      for (std::size_t i = 0; i < lines.size(); ++i)
        {
          EXPECT_EQ(lines[i].rfind("case.json:", 0), 0U) << lines[i];
          for (const std::string &word : issues[i])
            EXPECT_NE(lines[i].find(word), std::string::npos) << lines[i] << " lacks " << word;
        }
    }

    std::string
    accepted(const json &description)
    {
      const RunResult validated = host(description, "--validate");
      EXPECT_EQ(validated.exit_code, 0) << validated.output;
      const RunResult run = host(description);
      EXPECT_EQ(run.exit_code, 0) << run.output;
      return validated.output;
    }

    TemporaryFolder folder;
    bool compared = false;
  };
} // namespace

TEST_F(Validate, AFluxMismatchOfTheInterpolationIsSpreadAndSaid)
{
  json description                                    = small();
  description["domain"]["boundary"]["x_min"]          = velocity({"4*y*(1-y)", "0"});
  description["domain"]["boundary"]["x_max"]          = velocity({"20*y^2*(1-y)^2", "0"});
  description["fluid"]["navier_stokes"]["convection"] = "none";
  const std::string said                              = accepted(description);
  EXPECT_NE(said.find("% more out of the box than in"), std::string::npos) << said;
  EXPECT_NE(read_file(folder / "out/log.txt").find("% more out of the box than in"),
            std::string::npos);

  // Where hanging nodes lie on the boundary, too.
  description["refinement"]                 = {{"immersed_cells", {{"level", 2}}}};
  json curve                                = disc();
  curve["hyperelastic"]["initial_position"] = {"s1 - 0.28", "s2"};
  description["structures"]                 = {curve};
  accepted(description);
  EXPECT_EQ(read_json(folder / "out/summary.json")["retries"], 0);
}

TEST_F(Validate, ARealNetFluxIsRefused)
{
  json description                           = small();
  description["domain"]["boundary"]["x_min"] = velocity({"4*y*(1-y)", "0"});
  description["domain"]["boundary"]["x_max"] = velocity({"3.9*y*(1-y)", "0"});
  refused(description, {{"error: /domain/boundary: ", "0.666667 into", "0.65 out of"}});
  // One face alone.
  description["domain"]["boundary"].erase("x_max");
  refused(description, {{"error: /domain/boundary: ", "0.666667 into", " 0 out of"}});
  // Later than the start.
  description["domain"]["boundary"]["x_max"] = velocity({"4*y*(1-y)*(1+t)", "0"});
  refused(description, {{"error: /domain/boundary: ", "at time 0.0"}});
  // An outflow takes what is left.
  description["domain"]["boundary"]["y_max"] = {{"outflow", json::object()}};
  accepted(description);
}

TEST_F(Validate, AJumpInAProfileIsNoNetFlux)
{
  json description                           = small();
  description["domain"]["boundary"]["x_min"] = velocity({"if(y<0.3,1,0)", "0"});
  description["domain"]["boundary"]["x_max"] = velocity({"if(y>0.7,1,0)", "0"});
  accepted(description);
}

TEST_F(Validate, ANetFluxBetweenTheSamplesEndsTheRunWithItsTime)
{
  json description                           = small();
  description["domain"]["boundary"]["x_min"] = velocity({"4*y*(1-y)", "0"});
  // 1 but in (0.00099, 0.00101), where none of the times that are tried lies.
  description["domain"]["boundary"]["x_max"] =
    velocity({"4*y*(1-y)*(1 + if(abs(t-0.001)<0.00001,1,0))", "0"});
  description["time"]["step"] = .001;
  description["time"]["end"]  = .002;
  EXPECT_EQ(host(description, "--validate").exit_code, 0);
  const RunResult run = host(description);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.output.find(
              "/domain/boundary: the prescribed velocities let 0.666667 into the box"),
            std::string::npos)
    << run.output;
  EXPECT_NE(run.output.find("at time 0.001"), std::string::npos) << run.output;
}

TEST_F(Validate, ExpressionsThatAreNotFiniteAreNamedAllAtOnce)
{
  json description                                          = small();
  description["domain"]["boundary"]["x_min"]                = velocity({"sqrt(y-0.5)", "0"});
  description["domain"]["boundary"]["x_max"]                = {{"outflow", json::object()}};
  description["fluid"]["navier_stokes"]["initial_velocity"] = {"0", "1/(x-x)"};
  description["fluid"]["navier_stokes"]["body_force"]       = {"ln(x-0.5)", "0"};
  description["exact"] = {{"velocity", {"0", "0"}}, {"pressure", "ln(y-0.5)"}};
  refused(description,
          {{"/domain/boundary/x_min/velocity/value/0", "sqrt(y-0.5)", "nan at (0, 0) and time 0"},
           {"/fluid/navier_stokes/initial_velocity/1", "1/(x-x)", "(0, 0)"},
           {"/fluid/navier_stokes/body_force/0", "ln(x-0.5)", "nan at (0.0"},
           {"/exact/pressure", "ln(y-0.5)"}});
}

TEST_F(Validate, ExpressionsThatBecomeInfiniteAreNamed)
{
  json description                           = small();
  description["domain"]["boundary"]["y_max"] = velocity({"sqrt(0.01-t)", "0"});
  refused(description,
          {{"/domain/boundary/y_max/velocity/value/0", "nan at (0, 1) and time 0.01"}});
  description                                         = small();
  description["fluid"]["navier_stokes"]["body_force"] = {"0", "sqrt(0.01-t)"};
  refused(description, {{"/fluid/navier_stokes/body_force/1", "nan", "time 0.01"}});

  // Only nodes count: none lies at x = 1/16 on four cells, but one does on eight.
  description                                = small();
  description["domain"]["boundary"]["y_max"] = velocity({"1/(x-0.0625)", "0"});
  accepted(description);
  description["refinement"] = {{"uniform", {{"levels", 1}}}};
  refused(description, {{"/domain/boundary/y_max/velocity/value/0", "inf at (0.0625, 1)"}});
}

TEST_F(Validate, ExpressionsOfStructuresAreTriedWhereTheyAreUsed)
{
  json description = small();
  json modulus = disc(), fibres = disc(), position = disc(), material = disc();
  modulus["hyperelastic"]["law"]["neo_hookean"]["shear_modulus"] = "ln(s1-0.5)";
  fibres["hyperelastic"]["law"]                                  = {
                                     {"mooney_rivlin_fibres",
                                      {{"c1", 1},
                                       {"c2", 0},
                                       {"fibre_modulus", 1},
                                       {"fibres", json::array({json::array({"sqrt(s1-0.5)", "0"})})}}}};
  position["hyperelastic"]["initial_position"] = {"s1 + 0*sqrt(s2-0.5)", "s2"};
  material["hyperelastic"]["material"]         = "1/(s1-s1)";
  description["structures"]                    = {modulus, fibres, position, material};
  refused(description,
          {{"/structures/0/hyperelastic/law/neo_hookean/shear_modulus",
            "must be finite and positive"},
           {"/structures/1/hyperelastic/law/mooney_rivlin_fibres/fibres/0"},
           {"/structures/2/hyperelastic/initial_position", "nan"},
           {"/structures/3/hyperelastic/material", "inf"}});
}

TEST_F(Validate, ANonFiniteValueBetweenTheSamplesEndsTheRunWithItsPlace)
{
  json description                           = small();
  description["time"]["step"]                = .001;
  description["time"]["end"]                 = .002;
  description["domain"]["boundary"]["y_max"] = velocity({"1/(t-0.001)", "0"});
  description["time"]["control"]             = {{"fixed", {{"minimum_step", .001}}}};
  EXPECT_EQ(host(description, "--validate").exit_code, 0);
  RunResult run = host(description);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.output.find(
              "/domain/boundary/y_max/velocity/value/0: \"1/(t-0.001)\" is inf at (0, 1) and time "
              "0.001"),
            std::string::npos)
    << run.output;

  description["domain"]["boundary"]                   = json::object();
  description["fluid"]["navier_stokes"]["body_force"] = {"1/(t-0.001)", "0"};
  run                                                 = host(description);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.output.find("/fluid/navier_stokes/body_force/0: \"1/(t-0.001)\" is inf at ("),
            std::string::npos)
    << run.output;
}

TEST_F(Validate, RefinedCellsCount)
{
  json description          = small();
  description["refinement"] = {{"uniform", {{"levels", 15}}}};
  refused(description, {{"error: /refinement: ", "1.72e+10 cells", "at most 1e+08"}});
  description["structures"] = {disc()};
  description["refinement"] = {{"immersed_cells", {{"level", 15}}}};
  refused(description, {{"error: /refinement: ", " cells", "at most 1e+08"}});
  description["refinement"] = {
    {"error_indicator", {{"maximum_level", 15}, {"structure_level", 15}}}};
  refused(description, {{"error: /refinement: ", " cells", "at most 1e+08"}});
  description["refinement"] = {{"error_indicator", {{"maximum_level", 15}, {"minimum_level", 14}}}};
  refused(description, {{"error: /refinement: ", "4.29e+09 cells"}});
  // What a level asks for away from structures is not much.
  description["refinement"] = {{"immersed_cells", {{"level", 4}}}};
  EXPECT_EQ(host(description, "--validate").exit_code, 0);
}

TEST_F(Validate, MemoryCounts)
{
  json description          = small();
  description["refinement"] = {{"uniform", {{"levels", 9}}}}; // 4 million cells
  folder.write("case.json", description.dump(1));
  const RunResult run =
    run_command("ulimit -v 4000000; " + host_command() + " case.json --output out",
                folder.path.string());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.output.find(
              "/refinement: makes a mesh of about 4.19e+06 cells, which takes at least"),
            std::string::npos)
    << run.output;
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST_F(Validate, ProbesAndNames)
{
  json description = small();
  const auto probe = [](const std::string &name, const json &at) -> json {
    return {{"probe", {{"name", name}, {"at", at}}}};
  };
  description["output"] = {probe("a", {{"points", {{"places", {{.5, .5}, {1.5, .5}}}}}}),
                           probe("b",
                                 {{"segment", {{"from", {0, 0}}, {"to", {0, 2}}, {"points", 3}}}}),
                           {{"vtu", json::object()}},
                           {{"vtu", {{"interval", 2}}}}};
  refused(description,
          {{"/output/3/vtu: stands here a second time"},
           {"/output/0/probe/at/points/places/1: is at (1.5 0.5), the box goes from"},
           {"/output/1/probe/at/segment/to: is at (0 2)"}});
}

TEST_F(Validate, AStructureLongerThanAPeriodicBoxIsRefused)
{
  json description                         = small();
  description["domain"]["periodic"]        = {"x"};
  json body                                = disc();
  body["hyperelastic"]["initial_position"] = {"20*s1", "s2"};
  description["structures"]                = {body};
  refused(description, {{"/structures/0/hyperelastic/initial_position: tears the structure"}});
}

TEST_F(Validate, SaysWhatARunTakes)
{
  json description                                                                    = small();
  description["structures"]                                                           = {disc()};
  description["structures"][0]["hyperelastic"]["law"]["neo_hookean"]["shear_modulus"] = 1e6;
  description["time"]["integrator"] = {{"fe_be", json::object()}};
  const RunResult result            = host(description, "--validate");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  for (const std::string words : {"case.json is valid\n",
                                  "16 cells, 162 velocity and 48 pressure unknowns, about ",
                                  " of memory\n",
                                  "structure \"disc\": 61 nodes, 96 elements with edges of 0.0",
                                  " times the smallest cells' edge, 0.25\n",
                                  "dt = 0.01 exceeds the estimated limit ",
                                  "use lagged_be or dt <= "})
    EXPECT_NE(result.output.find(words), std::string::npos) << result.output << " lacks " << words;
}

TEST_F(Validate, TheLedgerSaysWhereAStructureIs)
{
  json description                                          = small();
  description["domain"]["periodic"]                         = {"x"};
  description["domain"]["boundary"]["y_min"]                = {{"free_slip", json::object()}};
  description["domain"]["boundary"]["y_max"]                = {{"free_slip", json::object()}};
  description["fluid"]["navier_stokes"]["initial_velocity"] = {"50", "0"};
  description["structures"]                                 = {disc()};
  description["output"]                                     = {{{"ledger_csv", json::object()}}};
  ASSERT_EQ(host(description).exit_code, 0);
  std::istringstream lines(read_file(folder / "out/ledger.csv"));
  std::vector<std::string> names;
  const auto split = [](const std::string &line) {
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');)
      fields.push_back(field);
    return fields;
  };
  std::string line;
  std::getline(lines, line);
  names = split(line);
  for (const double moved : {0., .5, 1.}) // beyond the end of the box
    {
      ASSERT_TRUE(std::getline(lines, line));
      const std::vector<std::string> values = split(line);
      const auto value                      = [&](const std::string &name) {
        const auto found = std::find(names.begin(), names.end(), name);
        EXPECT_NE(found, names.end()) << name;
        return found == names.end() ? 0. : std::stod(values[found - names.begin()]);
      };
      EXPECT_NEAR(value("centroid_x_disc"), .5 + moved, 1e-6);
      EXPECT_NEAR(value("centroid_y_disc"), .5, 1e-6);
      EXPECT_NEAR(value("lower_x_disc"), .3 + moved, 1e-6);
      EXPECT_NEAR(value("upper_x_disc"), .7 + moved, 1e-6);
      EXPECT_NEAR(value("lower_y_disc"), .3, .01);
    }
}

TEST_F(Validate, RanksAgree)
{
  json description                           = small();
  description["domain"]["boundary"]["x_min"] = velocity({"sqrt(y-0.5)", "0"});
  description["domain"]["boundary"]["y_max"] = velocity({"1/(x-1)", "0"});
  const RunResult one = host(description, "--validate"), two = host(description, "--validate", 2);
  EXPECT_EQ(two.exit_code, 2);
  // What follows is of mpiexec.
  EXPECT_EQ(two.output.rfind(one.output, 0), 0U) << one.output << two.output;
}

namespace
{
  /// A case, what is set in it, and words of what is said of it ("": it is valid).
  struct Input
  {
    std::string name, file;
    feib::Case::Settings settings;
    std::vector<std::string> words;
  };

  std::string
  repository_case(const std::string &name)
  {
    return read_file(FEIB_SOURCE "/cases/" + name + "/case.json");
  }

  /// A square of a box, both a thousandth of a millimetre.
  const char *const micrometres = R"({
    "dimension": 2, "domain": { "upper": [1e-6, 1e-6], "cells": [8, 8] },
    "fluid": { "navier_stokes": { "density": 1e3, "viscosity": 1e-3 } },
    "structures": [ { "hyperelastic": { "name": "a", "mesh": { "rectangle": {
      "lower": [4e-7, 4e-7], "upper": [5e-7, 5e-7], "cells": [2, 2] } },
      "law": { "neo_hookean": { "shear_modulus": 1 } } } } ],
    "time": { "step": 1e-8, "end": 2e-8, "integrator": { "lagged_be": {} } } })";

  const std::string fluid = "/fluid/navier_stokes/", boundary = "/domain/boundary",
                    membrane = "/structures/0/membrane/", square = "/structures/0/hyperelastic/",
                    not_periodic = "/domain/periodic";

  const std::vector<Input> inputs = {
    // Expressions that are not finite, or so large that their squares are not.
    {"InitialVelocity",
     "ellipsoid",
     {{fluid + "initial_velocity", R"j([0, 0, "ln(z-2)"])j"}},
     {fluid + "initial_velocity/2: \"ln(z-2)\" is nan at (0, 0, 0) and time 0; it must be finite"}},
    {"InitialVelocityTooLarge",
     "elliptic_membrane",
     {{fluid + "initial_velocity", R"j([0, "-1e200*y"])j"}},
     {fluid + "initial_velocity/1: \"-1e200*y\" is -", "it must be at most 1e+100 in size there"}},
    {"BoundaryInSpace",
     "ellipsoid",
     {{not_periodic, "[]"},
      {boundary, R"j({"z_max": {"velocity": {"value": [0, "1/(x-0.5)", 0]}}})j"}},
     {boundary + "/z_max/velocity/value/1: \"1/(x-0.5)\" is inf at (0.5, 0, 1)"}},
    {"BodyForce",
     "elliptic_membrane",
     {{fluid + "body_force", R"j([0, "-1e200*1e200"])j"}},
     {fluid + "body_force/1: \"-1e200*1e200\" is -inf at (0.0"}},
    {"Exact",
     "elliptic_membrane",
     {{"/exact", R"j({"velocity": ["exp(1000*x)", 0]})j"}},
     {"/exact/velocity/0: \"exp(1000*x)\" is "}},
    {"InitialPosition",
     "elliptic_membrane",
     {{membrane + "initial_position", R"j(["0.4", "sqrt(s1-0.1)"])j"}},
     {membrane + "initial_position/1: \"sqrt(s1-0.1)\" is nan at the reference place (0, 0)"}},
    {"VelocityOfExcessMass",
     "elliptic_membrane",
     {{membrane + "excess_density", "1"}, {membrane + "initial_velocity", R"j(["1/s1", 0])j"}},
     {membrane + "initial_velocity/0: \"1/s1\" is inf at the reference place (0, 0)"}},

    // More goes in than out, where there is a structure.
    {"InflowWithABody",
     "cavity_disc",
     {{boundary, R"j({"x_min": {"velocity": {"value": [1, 0]}}})j"}},
     {boundary + ": the prescribed velocities let 1 into the box and 0 out of it"}},
    {"InflowWithAMembrane",
     "elliptic_membrane",
     {{not_periodic, "[]"}, {boundary, R"j({"y_max": {"velocity": {"value": [0, "x-1"]}}})j"}},
     {boundary + ": the prescribed velocities let 0.5 into the box and 0 out of it"}},
    {"InflowWithASurface",
     "ellipsoid",
     {{not_periodic, "[]"}, {boundary, R"j({"x_min": {"velocity": {"value": ["t", 0, 0]}}})j"}},
     {boundary + ": the prescribed velocities let ", " into the box and 0 out of it", "at time "}},
    {"FluxesInSpace",
     "ellipsoid",
     {{not_periodic, "[]"},
      {boundary,
       R"j({"x_min": {"velocity": {"value": ["16*y*(1-y)*z*(1-z)", 0, 0]}},
           "x_max": {"velocity": {"value": ["15*y*(1-y)*z*(1-z)", 0, 0]}}})j"}},
     {boundary + ": the prescribed velocities let 0.444444 into the box and 0.41"}},

    // Too many cells, of any kind and dimension.
    {"CellsInSpace",
     "ellipsoid",
     {{"/domain/cells", "[2000, 2000, 2000]"}},
     {"/domain/cells: found 8e+09 cells in all, at most 1e8 are allowed"}},
    {"UniformInSpace",
     "ellipsoid",
     {{"/refinement", R"j({"uniform": {"levels": 10}})j"}},
     {"/refinement: makes a mesh of about ", "e+11 cells, at most 1e+08 are allowed"}},
    {"ImmersedInSpace",
     "ellipsoid",
     {{"/refinement", R"j({"immersed_cells": {"level": 15}})j"}},
     {"/refinement: makes a mesh of about ", " cells, at most 1e+08 are allowed"}},
    {"IndicatedInSpace",
     "ellipsoid",
     {{"/refinement", R"j({"error_indicator": {"maximum_level": 15, "minimum_level": 12}})j"}},
     {"/refinement: makes a mesh of about ", " cells, at most 1e+08 are allowed"}},
    {"PlacesOfBaseCells",
     "ellipsoid",
     {{"/domain/upper", "[1e6, 1, 1]"}, {"/domain/cells", "[2000000, 2, 2]"}},
     {"/domain/cells: along x, 2000000 base cells of 2^1 units each are 4000000 units",
      "at most 2097151 are possible in 3D"}},
    {"PlacesOfLevels",
     "ellipsoid",
     {{"/domain/upper", "[1, 1, 16]"},
      {"/domain/cells", "[2, 2, 64]"},
      {"/refinement", R"j({"error_indicator": {"maximum_level": 14}})j"}},
     {"/refinement: along z, 64 base cells of 2^15 units each are 2097152 units",
      "at most 2097151 are possible in 3D"}},
    {"PlacesThatFit",
     "ellipsoid",
     {{"/domain/upper", "[1, 1, 16]"},
      {"/domain/cells", "[2, 2, 64]"},
      {"/refinement", R"j({"error_indicator": {"maximum_level": 13}})j"}},
     {}},
    {"LevelsBeyondAll",
     "elliptic_membrane",
     {{"/refinement", R"j({"uniform": {"levels": 2000000000}})j"}},
     {"/refinement/uniform/levels: must be at most 15, found 2000000000"}},

    // Integers beyond 64 bits are numbers, and readable.
    {"IntegerOf2To63", micrometres, {{fluid + "density", "9223372036854775808"}}, {}},
    {"LargestIntegerOf64Bits",
     micrometres,
     {{square + "law/neo_hookean/shear_modulus", "18446744073709551615"}},
     {}},
    {"NegativeInteger",
     micrometres,
     {{fluid + "viscosity", "-18446744073709551616"}},
     {fluid + "viscosity: must be greater than 0, found -1.8"}},

    // Numbers in small units.
    {"SmallAndValid", micrometres, {}, {}},
    {"SmallOutside",
     micrometres,
     {{square + "mesh/rectangle/upper", "[1.3e-6, 5e-7]"}},
     {"node 2 starts at (1.3e-06 4e-07), the box goes from (0 0) to (1e-06 1e-06)"}},
    {"SmallFlux",
     micrometres,
     {{boundary, R"j({"x_min": {"velocity": {"value": [1e-9, 0]}}})j"}},
     {boundary + ": the prescribed velocities let 1e-15 into the box"}},
    {"SmallFluxesThatAgree",
     micrometres,
     {{boundary,
       R"j({"x_min": {"velocity": {"value": ["y*(1e-6-y)", 0]}},
           "x_max": {"velocity": {"value": ["y*(1e-6-y)", 0]}}})j"}},
     {}},
    {"SmallTime",
     micrometres,
     {{boundary, R"j({"y_max": {"velocity": {"value": ["sqrt(1.5e-8-t)", 0]}}})j"}},
     {"is nan at (0, 1e-06) and time 1.", "e-08; it must be"}},
    {"SmallPlace",
     micrometres,
     {{fluid + "body_force", R"j(["ln(x-5e-7)", 0])j"}},
     {"is nan at (8.", "e-09, 8.", "e-09) and time 0"}},
    {"SmallProbe",
     micrometres,
     {{"/output", R"j([{"probe": {"name": "a", "at": {"points": {"places": [[2e-6, 3e-7]]}}}}])j"}},
     {"is at (2e-06 3e-07), the box goes from (0 0) to (1e-06 1e-06)"}},
    {"SmallFold",
     micrometres,
     {{square + "initial_position", R"j(["4.5e-7+abs(s1-4.5e-7)", "s2"])j"}},
     {"folds the body: 4 of its 8 elements", "at the reference place (4.3"}},
    {"SmallAndFlat",
     micrometres,
     {{square + "initial_position", R"j(["5e-7", "s2"])j"}},
     {"flattens element 0 at the reference place (4.3", "e-07, 4.1"}}};

  class Inputs : public ::testing::TestWithParam<Input>
  {};
} // namespace

TEST_P(Inputs, AreJudgedBeforeTheRun)
{
  const Input &input = GetParam();
  const std::string said =
    feib::testing::complaint(input.file[0] == '{' ? input.file : repository_case(input.file),
                             input.settings);
  EXPECT_EQ(said.empty(), input.words.empty()) << said;
  EXPECT_LE(std::count(said.begin(), said.end(), '\n'), 1) << said;
  for (const std::string &word : input.words)
    EXPECT_NE(said.find(word), std::string::npos) << said << " lacks " << word;
}

INSTANTIATE_TEST_SUITE_P(Validate, Inputs, ::testing::ValuesIn(inputs), [](const auto &input) {
  return input.param.name;
});

// A mismatch of the size of the interpolation error, in other boxes.
TEST_F(Validate, AFluxMismatchOfTheInterpolationInOtherBoxes)
{
  // Through three faces, and in space.
  json three                           = small();
  three["domain"]["boundary"]["x_min"] = velocity({"4*y*(1-y)", "0"});
  three["domain"]["boundary"]["x_max"] = velocity({"10*y^2*(1-y)^2", "0"});
  three["domain"]["boundary"]["y_max"] = velocity({"0", "10*x^2*(1-x)^2"});
  json cube                            = small();
  cube["dimension"]                    = 3;
  cube["domain"]["cells"]              = {4, 4, 4};
  cube["domain"]["boundary"]["z_min"]  = velocity({"0", "0", "16*x*(1-x)*y*(1-y)"});
  cube["domain"]["boundary"]["z_max"]  = velocity({"0", "0", "400*(x*(1-x)*y*(1-y))^2"});
  // Slow, in a box of a micrometre.
  json tiny                           = small();
  tiny["domain"]["upper"]             = {1e-6, 1e-6};
  tiny["domain"]["boundary"]["x_min"] = velocity({"4e3*y*(1-1e6*y)", "0"});
  tiny["domain"]["boundary"]["x_max"] = velocity({"2e10*y^2*(1-1e6*y)^2", "0"});
  for (json *const description : {&three, &cube, &tiny})
    {
      (*description)["fluid"]["navier_stokes"]["convection"] = "none";
      (*description)["time"]["end"]                          = .01;
      const RunResult run                                    = host(*description);
      EXPECT_EQ(run.exit_code, 0) << run.output;
      EXPECT_NE(run.output.find("% more out of the box than in"), std::string::npos) << run.output;
      EXPECT_EQ(read_json(folder / "out/summary.json")["retries"], 0);
    }
}

/// What a coupling refuses at the start of a run it refuses before.
TEST_F(Validate, ACouplingThatIsNotMadeForTheGeometryIsRefused)
{
  json description            = small();
  description["structures"]   = {disc()};
  description["coupling"]     = {{"regularised_delta", json::object()}};
  const std::string structure = "error: /coupling: refuses the structure \"disc\": point ";
  refused(description,
          {{structure, "nearer to a side of the box than the kernel", "0.5;", "\"reproducing\""}});
  description["domain"]["cells"]    = {16, 16};
  description["domain"]["boundary"] = json::object();
  accepted(description);
  // The kernel reaches beyond the refined cells.
  description["domain"]["cells"] = {8, 8};
  description["refinement"]      = {{"immersed_cells", {{"level", 1}, {"buffer", 0}}}};
  refused(description, {{structure, "reaches cells of another size", "\"reproducing\""}});
  description["coupling"]["regularised_delta"]["reproducing"] = true;
  accepted(description);
}

/// Whatever they are made from, and where the reason is.
TEST_F(Validate, CurvesInThreeDimensionsAreRefused)
{
  json description                                    = small();
  description["dimension"]                            = 3;
  description["domain"]["cells"]                      = {2, 2, 2};
  const std::vector<std::vector<std::string>> reasons = {
    {"error: /structures/0/membrane/mesh/",
     "curves in dimension 3 are not supported: beside a force on a line the velocity has no bound",
     "make it a thin body (cylinder, tube)"}};
  folder.write("line.msh",
               "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0.2 0.5 0.5\n2 0.4 0.5 0.5\n"
               "3 0.6 0.5 0.6\n$EndNodes\n$Elements\n2\n1 1 2 0 1 1 2\n2 1 2 0 1 2 3\n"
               "$EndElements\n");
  for (const json &mesh : {json{{"closed_curve", {{"length", 1}, {"elements", 9}}}},
                           json{{"open_curve", {{"length", 1}, {"elements", 9}}}},
                           json{{"gmsh", {{"file", "line.msh"}}}}})
    {
      description["structures"] = {
        {{"membrane",
          {{"name", "filament"},
           {"mesh", mesh},
           {"initial_position", {"0.5 + 0.2*cos(2*pi*s1)", "0.5 + 0.2*sin(2*pi*s1)", "0.5"}},
           {"law", {{"anisotropic_linear", {{"stiffness", 1}}}}}}}}};
      refused(description, reasons);
    }
}
