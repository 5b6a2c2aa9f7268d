// SPDX-License-Identifier: LGPL-2.1-or-later
// Flows that go on from files and earlier runs, what is reported of them, and what outlets
// remember.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace feib::testing;

namespace
{
  namespace fs = std::filesystem;

  std::string
  set(const std::string &pointer, const std::string &value)
  {
    return " --set " + shell_quoted("/" + pointer + "=" + value);
  }


  /// A channel of length 2 and height 1, with these conditions at its ends.
  std::string
  channel(const std::string &in, const std::string &out, const std::string &more = "")
  {
    return R"j({ "dimension": 2, "domain": { "upper": [2, 1], "cells": [4, 4],
        "boundary": { "x_min": )j" +
           in + R"j(, "x_max": )j" + out + R"j( } },
      "fluid": { "navier_stokes": { "density": 2, "viscosity": 0.1, "tolerance": 1e-11 } },
      "time": { "step": 0.1, "end": 1 },
      "output": [ { "ledger_csv": {} } ])j" +
           more + "}";
  }

  const std::string outflow = R"j({ "outflow": {} })j";

  const std::string ring =
    R"j({ "membrane": { "name": "ring", "law": { "neo_hookean": { "shear_modulus": 0.01 } },
      "mesh": { "closed_curve": { "length": 1.2, "elements": 24 } },
      "initial_position": ["1+0.19098593*cos(2*pi*s1/1.2)", "0.5+0.19098593*sin(2*pi*s1/1.2)"])j";


  /// Runs of one folder.
  class Flow : public ::testing::Test
  {
  protected:
    const TemporaryFolder folder;

    /// Of the case in a text, or with "--restart", into the folder @p name; must end well.
    CaseRun
    run(const std::string &name,
        const std::string &text,
        const std::string &settings = "",
        const unsigned int ranks    = 1)
    {
      const bool goes_on = text == "--restart";
      const std::string what =
        goes_on ? "--restart " + name
                : shell_quoted(folder.write(name + ".json", text)) + " --output " + name;
      const RunResult host = run_host(what + settings, ranks, folder.path);
      EXPECT_EQ(host.exit_code, 0) << host.output;
      return {host.exit_code,
              host.output,
              "",
              read_json(folder / (name + "/summary.json")),
              read_table(folder / (name + "/ledger.csv")),
              {}};
    }

    /// Refused before anything is written, by --validate too if @p both are tried.
    void
    expect_refused(const std::string &text, const std::string &says, const bool both = false)
    {
      const std::string file = folder.write("refused.json", text);
      for (const std::string mode : {"", " --validate"})
        if (mode.empty() || both)
          {
            const RunResult host =
              run_host(shell_quoted(file) + mode + " --output refused", 1, folder.path);
            EXPECT_EQ(host.exit_code, 2) << host.output;
            EXPECT_TRUE(holds(host.output, says)) << host.output << "\nwithout: " << says;
            EXPECT_FALSE(fs::exists(folder / "refused"));
          }
    }
  };

  using Series        = Flow;
  using Coefficients  = Flow;
  using InitialState  = Flow;
  using OutletsOfRuns = Flow;


  /// All but the seconds spent.
  void
  expect_same_ledger(const Table &found, const Table &expected)
  {
    for (const auto &[name, column] : expected)
      if (name.rfind("seconds_", 0) != 0)
        {
          EXPECT_EQ(found.at(name), column) << name;
        }
  }
} // namespace


TEST_F(Series, IsStraightBetweenTheRowsOfItsFile)
{
  folder.write("a.csv",
               "\xEF\xBB\xBF# measured\r\n\"time\", other, \"in flow\"\r\n0, 9, 1\r\n"
               "# a break\r\n\r\n0.25, 9, 2\r\n0.45,9,-1\r\n");
  folder.write("b.txt", "  0 0\n 0.2\t 1\n");
  folder.write("c.csv", "0;1\n.3;4\n.4;1\n");
  const std::string series = R"j(, "series": { "A": { "file": "a.csv", "column": "in flow" },
    "C": { "file": "c.csv", "repeat": true } })j";
  const CaseRun result =
    run("a",
        channel(R"j({ "velocity": { "value": ["6*y*(1-y)*(A(t)+2*C(t-0.05))", 0] } })j",
                outflow,
                series),
        set("time/integrator", R"({"fe_be":{}})"));
  const auto a = [](const double t) {
    return t < .25 ? 1 + 4 * t : t < .45 ? 2 - 15 * (t - .25) : -1;
  };
  const auto c = [](double t) {
    t -= .4 * std::floor(t / .4);
    return t < .3 ? 1 + 10 * t : 4 - 30 * (t - .3);
  };
  for (unsigned int i = 1; i <= 10; ++i)
    {
      const double t = result.ledger.at("time")[i];
      EXPECT_NEAR(result.ledger.at("flux_x_min")[i], -(a(t) + 2 * c(t - .05)), 1e-9) << t;
    }
}


TEST_F(Series, WrongFilesAreRefusedByLine)
{
  const std::string column = R"(, "column": "q")", repeat = R"(, "repeat": true)";
  struct Wrong
  {
    std::string text, says, more;
  };
  const std::vector<Wrong> examples = {
    {"# nothing\n", "has 0 rows of numbers", ""},
    {"t,q\n", "has 0 rows of numbers", ""},
    {"0,1\n", "has 1 rows of numbers", ""},
    {"0,1\n1,2\n1,3\n", "line 3: the time 1 is not after 1", ""},
    {"t,q\n0,1\n1,two\n", "line 3: found \"two\", a number is needed", ""},
    {"0,1\n1\n", "line 2: found 1 columns", ""},
    {"0,1\n1,nan\n", "line 2: found \"nan\"", ""},
    {"0..0,1\n1,2\n2,3\n", "line 1: found \"0..0\", a number is needed", ""},
    {"0;1,5\n1;2,5\n", "line 1: found \"1,5\", a number is needed", ""},
    {"t,p\n0,1\n1,2\n", "line 1: no column of values is called \"q\"", column},
    {"0,1\n1,2\n", "line 1: there is no line of names", column},
    {"0,1\n1,2\n", "begins with 1 and ends with 2", repeat}};
  std::string series = R"("S": { "file": "none.csv" })";
  for (unsigned int i = 0; i < examples.size(); ++i)
    {
      const std::string name = "S" + std::to_string(i);
      folder.write(name + ".csv", examples[i].text);
      series += ", \"" + name + R"(": { "file": ")" + name + ".csv\"" + examples[i].more + " }";
    }
  const std::string text =
    channel(R"j({ "flux": { "value": "-S(t)" } })j", outflow, R"j(, "series": { )j" + series + "}");
  expect_refused(text, "/series/S/file: the file \"" + (folder / "none.csv") + "\": ", true);
  const RunResult host = run_host(shell_quoted(folder / "refused.json") + " --validate");
  for (unsigned int i = 0; i < examples.size(); ++i)
    {
      const std::string name = "S" + std::to_string(i);
      const std::string start =
        "/series/" + name + "/file: the file \"" + (folder / name) + ".csv\"";
      const auto found = host.output.find(start);
      ASSERT_NE(found, std::string::npos) << start << " in " << host.output;
      const std::string line = host.output.substr(found, host.output.find('\n', found) - found);
      EXPECT_TRUE(holds(line, examples[i].says)) << line << "\nwithout: " << examples[i].says;
    }
}


namespace
{
  /// A ring carried up and down by its springs, once in half a unit of time, in a stream.
  std::string
  carried(const std::string &more)
  {
    return channel(R"j({ "velocity": { "value": ["0.2+0.02*t", 0] } })j",
                   outflow,
                   R"j(, "structures": [ )j" + ring +
                     R"j(, "forces": [ { "tether": { "stiffness": 50,
      "target": ["1+0.19098593*cos(2*pi*s1/1.2)", "0.5+0.19098593*sin(2*pi*s1/1.2)+0.05*sin(4*pi*t)"] } } ]
      } } ], "coefficients": { "velocity": 2, "length": 0.4, "flow": [1, 1], "lift": [0, 2] })j" +
                     more);
  }

  const std::string fast = set("fluid/navier_stokes/tolerance", "1e-8") + set("time/step", "0.02") +
                           set("time/integrator", R"({"lagged_midpoint":{}})") +
                           set("domain/boundary/y_min", R"({"free_slip":{}})") +
                           set("domain/boundary/y_max", R"({"free_slip":{}})");
} // namespace

TEST_F(Coefficients, AreForcesAndStatisticsThoseOfTheLedger)
{
  const CaseRun result = run("a",
                             carried(R"j(, "statistics": { "from": 0.4, "to": 1.9 })j"),
                             fast + set("time/end", "2"));
  const Table &ledger  = result.ledger;
  double mean = 0, largest = -1e300, smallest = 1e300;
  for (unsigned int i = 0; i < ledger.at("time").size(); ++i)
    {
      // density/2 velocity^2 length = 1.6
      const double x = ledger.at("force_x_ring")[i], y = ledger.at("force_y_ring")[i];
      EXPECT_NEAR(ledger.at("drag_ring")[i], -(x + y) / std::sqrt(2.) / 1.6, 1e-9);
      EXPECT_NEAR(ledger.at("lift_ring")[i], -y / 1.6, 1e-9);
      if (ledger.at("time")[i] < .41 || ledger.at("time")[i] > 1.91)
        continue;
      const double lift = ledger.at("lift_ring")[i];
      mean += lift * ledger.at("dt")[i] / 1.5;
      largest  = std::max(largest, lift);
      smallest = std::min(smallest, lift);
    }
  const auto &statistics = result.summary["statistics"];
  EXPECT_NEAR(statistics["from"], .4, 1e-12);
  EXPECT_NEAR(statistics["to"], 1.9, 1e-12);
  const auto &lift = statistics["columns"]["lift_ring"];
  EXPECT_NEAR(lift["mean"], mean, 1e-12 * largest);
  EXPECT_EQ(lift["largest"], largest);
  EXPECT_EQ(lift["smallest"], smallest);
  EXPECT_EQ(lift["amplitude"], (largest - smallest) / 2);
  EXPECT_NEAR(lift["frequency"], 2., .02);
  EXPECT_GE(lift["periods"], 2);
  EXPECT_NEAR(result.summary["structures"][0]["strouhal"], 2 * .4 / 2, .004);
}


/// Also where the first run was to end before the window of the second begins.
TEST_F(Coefficients, StatisticsGoOnWithARun)
{
  const std::string often = set("checkpoint", R"({"interval":10})");
  const auto whole        = run("whole", carried(""), fast + often + set("time/end", "0.8"));
  for (const std::string end : {"0.2", "0.4"})
    {
      run("a" + end, carried(""), fast + often + set("time/end", end));
      const auto pieces = run("a" + end, "--restart", set("time/end", "0.8"));
      for (const char *key : {"from", "to"})
        EXPECT_EQ(pieces.summary["statistics"][key], whole.summary["statistics"][key]);
      const auto &found = pieces.summary["statistics"]["columns"];
      for (const auto &[name, column] : whole.summary["statistics"]["columns"].items())
        EXPECT_EQ(found[name], column) << name;
    }
}


TEST_F(Coefficients, WhatMakesNoSenseIsRefused)
{
  const auto with = [](const std::string &block) {
    return channel(R"j({ "velocity": { "value": [1, 0] } })j", outflow, ", " + block);
  };
  expect_refused(with(R"j("statistics": { "from": 0.7, "to": 0.6 })j"),
                 "/statistics/from: the window goes from 0.7 to 0.6",
                 true);
  expect_refused(with(R"j("statistics": { "from": 3, "to": 4 })j"),
                 "/statistics/from: the window goes from 3 to 4, the run to 1");
  const auto coefficients = [&](const std::string &more) {
    return with(R"j("coefficients": { "velocity": 1, "length": 1, )j" + more + "}");
  };
  expect_refused(coefficients(R"j("flow": [0, 0])j"), "/coefficients/flow: is zero", true);
  expect_refused(coefficients(R"j("lift": [0, 0, 1])j"), "/coefficients/lift: found 3 components");
  expect_refused(coefficients(R"j("flow": [0, 1])j"),
                 "/coefficients/flow: makes lift the same as drag");
  expect_refused(with(R"j("coefficients": { "velocity": 1e-200, "length": 1 })j"),
                 "/coefficients/velocity: gives the reference force");
}


TEST_F(Coefficients, NamesOfTheLedgerAreUnique)
{
  const auto with = [](const std::string &part) {
    return channel(R"j({ "parts": { "list": [ { "name": ")j" + part +
                     R"j(", "where": "y > 0.5", "condition": { "outflow": {} } } ] } })j",
                   outflow,
                   R"j(, "structures": [ )j" + ring +
                     R"j(, "forces": [ { "tether": { "stiffness": 1 } } ] } } ])j");
  };
  expect_refused(with("ring"), "/structures/0/membrane/name: found \"ring\"");
  expect_refused(with("ring_tether"),
                 "/structures/0/membrane/forces: have a force called \"tether\"");
}


namespace
{
  const std::string pressure_in  = R"j({ "pressure": { "value": 2, "inflow": "static" } })j",
                    pressure_out = R"j({ "pressure": { "value": 0 } })j";

  const std::string exact = R"j(, "exact": { "velocity": ["5*y*(1-y)", 0], "pressure": "2-x" })j";

  /// Poiseuille's flow, which quadratic elements hold.
  std::string
  poiseuille(const std::string &more)
  {
    return channel(pressure_in, pressure_out, exact + more);
  }
} // namespace

/// On a finer and refined mesh, with a structure in it, on any number of ranks; and the earlier run
/// need not be there any more to go on.
TEST_F(InitialState, IsTheFlowOfTheEarlierRun)
{
  run("earlier",
      poiseuille(""),
      set("fluid/navier_stokes/initial_velocity", R"j(["5*y*(1-y)",0])j") + set("time/end", "0.2"),
      2);
  const std::string later = poiseuille(
    R"j(, "initial_state": { "run": "earlier" },
    "structures": [ )j" +
    ring + R"j( } } ], "refinement": { "immersed_cells": { "level": 1, "minimum_level": 0 } })j");
  const std::string settings = set("domain/cells", "[8,8]") + set("time/step", "1e-5") +
                               set("time/end", "2e-5") +
                               set("structures/0/membrane/law/neo_hookean/shear_modulus", "1e-9");
  for (const unsigned int ranks : {1, 2})
    {
      const std::string name = "later_" + std::to_string(ranks);
      const CaseRun result   = run(name, later, settings, ranks);
      EXPECT_GT(result.summary["cells"], 64);
      EXPECT_NEAR(result.ledger.at("kinetic")[0], 5. / 3, 1e-9);
      EXPECT_NEAR(result.ledger.at("flux_x_max")[1], 5. / 6, 1e-9);
      EXPECT_LT(result.summary["errors"]["velocity_l2"], 1e-9);
    }
  fs::remove_all(folder / "earlier");
  const CaseRun result = run("later_1", "--restart", set("time/end", "4e-5"));
  EXPECT_EQ(result.summary["steps"], 4);
  EXPECT_LT(result.summary["errors"]["velocity_l2"], 1e-9);
  // What it began with is still said.
  EXPECT_EQ(read_json(folder / "later_1/resolved.json")["initial_state"]["run"], "earlier");
}


/// Of a box that is larger, periodic, and refined in a place.
TEST_F(InitialState, MayComeFromALargerPeriodicBox)
{
  const std::string shear =
    R"j({ "dimension": 2, "domain": { "lower": [-1, -1], "upper": [3, 3], "cells": [8, 8],
      "periodic": ["x"], "boundary": { "y_min": { "free_slip": {} }, "y_max": { "free_slip": {} } } },
    "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1, "tolerance": 1e-11,
      "initial_velocity": ["1+y*(2-y)", 0] } },
    "structures": [ )j" +
    ring + R"j( } } ],
    "refinement": { "immersed_cells": { "level": 2 } },
    "time": { "step": 1e-6, "end": 1e-6 }, "output": [ { "ledger_csv": {} } ] })j";
  run("earlier", shear, "", 2);
  const CaseRun result = run(
    "later",
    channel(
      R"j({ "velocity": { "value": ["1+y*(2-y)", 0] } })j",
      outflow,
      R"j(, "initial_state": { "run": "earlier" }, "exact": { "velocity": ["1+y*(2-y)", 0] })j"),
    set("time/step", "1e-6") + set("time/end", "1e-6") +
      set("domain/boundary/y_min", R"({"velocity":{"value":[1,0]}})") +
      set("domain/boundary/y_max", R"({"velocity":{"value":[2,0]}})"));
  EXPECT_LT(result.summary["errors"]["velocity_l2"], 1e-6);
}


/// A flux is prescribed from the start: else schemes that damp nothing have it alternate for ever.
TEST_F(InitialState, HasThePrescribedFlux)
{
  const std::string in = R"j({ "flux": { "value": -0.5 } })j";
  run("earlier", channel(pressure_in, pressure_out), set("time/end", "0.2"));
  const Table with =
                run("with", channel(in, outflow, R"j(, "initial_state": { "run": "earlier" })j"))
                  .ledger,
              without = run("without", channel(in, outflow)).ledger;
  for (unsigned int i = 3; i <= 10; ++i)
    EXPECT_NEAR(with.at("force_x_x_min")[i], without.at("force_x_x_min")[i], .2) << i;
}


TEST_F(InitialState, WhatCannotBeIsRefused)
{
  const std::string earlier = folder / "earlier";
  run("earlier", poiseuille(""), set("time/end", "0.1"));
  const auto from = [](const std::string &run) {
    return R"j(, "initial_state": { "run": ")j" + run + "\" }";
  };
  expect_refused(channel(pressure_in, outflow, from("nowhere")),
                 "/initial_state/run: there is no checkpoint in " + (folder / "nowhere") + "");
  expect_refused(R"j({ "dimension": 3, "domain": { "cells": [2, 2, 2] },
    "fluid": { "navier_stokes": { "density": 1, "viscosity": 1 } }, "time": { "step": 1, "end": 1 })j" +
                   from("earlier") + "}",
                 "/initial_state/run: the run \"" + earlier + "\" has the dimension 2");
  std::string higher = channel(pressure_in, outflow, from("earlier"));
  higher.replace(higher.find("[2, 1]"), 6, "[2, 2]");
  expect_refused(higher,
                 "/initial_state/run: the box of the run \"" + earlier +
                   "\" goes from (0 0) to (2 1)");

  // Its own place: what it begins with would be gone.
  const std::string file = folder.write("own.json", channel(pressure_in, outflow, from("earlier")));
  const RunResult host   = run_host("own.json --output earlier --overwrite", 1, folder.path);
  EXPECT_EQ(host.exit_code, 2) << host.output;
  EXPECT_TRUE(holds(host.output, "/initial_state/run: is the output folder")) << host.output;
  EXPECT_TRUE(fs::exists(folder / "earlier/checkpoints"));
}


namespace
{
  /// What goes in and comes out of two windkessels is found by the pressures there.
  std::string
  branches(const std::string &more = "")
  {
    return channel(R"j({ "flux": { "value": "-(1+0.5*sin(9*t))" } })j",
                   R"j({ "parts": { "list": [ { "name": "upper", "where": "y > 0.5",
            "condition": { "windkessel": { "resistance": 0.5, "distal_resistance": 2, "capacitance": 0.1 } } } ],
          "elsewhere": { "windkessel": { "distal_resistance": 1, "capacitance": 0.2, "initial_pressure": 1 } } } })j",
                   more);
  }
} // namespace

TEST_F(OutletsOfRuns, GoOnToTheBit)
{
  for (const std::string scheme : {"fe_be", "midpoint"})
    for (const std::string control : {R"({"fixed":{}})", R"({"adaptive":{"cfl":0.3}})"})
      {
        SCOPED_TRACE(scheme + control);
        const std::string text = branches(R"j(, "structures": [ )j" + ring + R"j( } } ],
        "refinement": { "immersed_cells": { "level": 1, "minimum_level": 0, "interval": 3 } },
        "checkpoint": { "interval": 5, "keep": 10 })j");
        const std::string name = scheme + (control.size() > 12 ? "a" : "f");
        const std::string settings =
          set("time/integrator", "{\"" + scheme + "\":{}}") + set("time/control", control) +
          set("fluid/navier_stokes/tolerance", "1e-8") + set("time/step", "0.02");
        const CaseRun whole = run(name, text, settings + set("time/end", "0.2"));
        // From a checkpoint half way, by its rows.
        fs::copy(folder / name, folder / (name + "_again"), fs::copy_options::recursive);
        for (const auto &entry : fs::directory_iterator(folder / (name + "_again/checkpoints")))
          if (const std::string step = entry.path().filename(); step != "step_5")
            fs::remove_all(entry.path());
        const CaseRun again = run(name + "_again", "--restart");
        ASSERT_EQ(again.ledger.at("time").size(), whole.ledger.at("time").size());
        expect_same_ledger(again.ledger, whole.ledger);
        EXPECT_GT(whole.ledger.at("time").size(), 6u);
      }
}


/// A first step that fails and is tried again with half its length is that half step.
TEST_F(OutletsOfRuns, AStepTriedAgainLeavesNoTrace)
{
  const std::string few =
    set("fluid/navier_stokes/viscosity", "0.002") + set("fluid/navier_stokes/max_iterations", "3");
  const CaseRun tried =
    run("tried", branches(), few + set("time/step", "0.5") + set("time/end", "0.5"));
  ASSERT_GT(tried.summary["retries"], 0);
  const double step = tried.ledger.at("dt")[1];
  const CaseRun plain =
    run("plain",
        branches(),
        few + set("time/step", std::to_string(step)) + set("time/end", std::to_string(step)));
  EXPECT_EQ(plain.summary["retries"], 0);
  for (const char *name :
       {"flux_upper", "force_x_upper", "force_x_x_max", "force_x_x_min", "kinetic"})
    EXPECT_NEAR(tried.ledger.at(name)[1], plain.ledger.at(name)[1], 1e-9) << name;
}


/// Zero is a flux, too: of a closed valve beside flow, and of fluid at rest under pressure.
TEST_F(OutletsOfRuns, AFluxMayBeZero)
{
  const std::string closed = R"j({ "flux": { "value": 0 } })j";
  const CaseRun rest       = run("rest", channel(R"j({ "pressure": { "value": 1 } })j", closed));
  EXPECT_EQ(rest.summary["retries"], 0);
  EXPECT_NEAR(rest.ledger.at("force_x_x_max").back(), -1, 1e-9);
  EXPECT_NEAR(rest.ledger.at("largest_velocity").back(), 0, 1e-9);
  const CaseRun beside = run(
    "beside",
    channel(
      R"j({ "velocity": { "value": ["y*(1-y)", 0] } })j",
      R"j({ "parts": { "list": [ { "name": "valve", "where": "y > 0.5", "condition": { "flux": { "value": 0 } } } ],
          "elsewhere": { "outflow": {} } } })j"));
  EXPECT_EQ(beside.summary["retries"], 0);
  EXPECT_NEAR(beside.ledger.at("flux_valve").back(), 0, 1e-9);
  EXPECT_NEAR(beside.ledger.at("flux_x_max").back(), 1. / 6, 1e-9);
}


/// Where a flux has a kink, as those of files have, schemes that damp nothing do not go on to
/// bounce between too much and too little.
TEST_F(OutletsOfRuns, AFluxWithAKinkIsFollowed)
{
  const CaseRun result = run("kink",
                             channel(R"j({ "flux": { "value": "-min(1,t/0.25)" } })j", outflow),
                             set("time/integrator", R"({"midpoint":{}})"));
  for (unsigned int i = 3; i <= 10; ++i)
    {
      EXPECT_NEAR(result.ledger.at("momentum_x")[i], 4, 1e-8); // density flux length
      EXPECT_NEAR(result.ledger.at("flux_x_min")[i], i > 3 ? -1 : -.9, 1e-8);
    }
}


/// So with a velocity, on a mesh with hanging nodes at the inlet too.
TEST_F(OutletsOfRuns, AVelocityWithAKinkIsFollowed)
{
  const std::string adaptive = R"j({"error_indicator":{"maximum_level":1}})j";
  for (const char *const scheme : {"midpoint", "lagged_midpoint"})
    for (const std::string refinement : {std::string(R"j({"uniform":{"levels":0}})j"), adaptive})
      {
        SCOPED_TRACE(std::string(scheme) + ' ' + refinement);
        const CaseRun result =
          run(std::string(scheme) + (refinement == adaptive ? "_adaptive" : ""),
              channel(R"j({ "velocity": { "value": ["6*y*(1-y)*min(1,t/0.25)", 0] } })j", outflow),
              set("time/integrator", std::string("{\"") + scheme + "\":{}}") +
                set("refinement", refinement));
        for (unsigned int i = 3; i <= 10; ++i)
          {
            EXPECT_NEAR(result.ledger.at("momentum_x")[i], 4, 1e-8) << i;
            EXPECT_NEAR(result.ledger.at("flux_x_min")[i], i > 3 ? -1 : -.9, 1e-8) << i;
          }
      }
}


/// With steps much longer than the flow takes to change, what outlets answer changes within one.
TEST_F(OutletsOfRuns, NewtonsMethodConvergesWithLongSteps)
{
  const CaseRun result = run("long",
                             channel(R"j({ "velocity": { "value": ["16*ramp(t)*y*(1-y)", 0] } })j",
                                     R"j({ "parts": { "list": [ { "name": "up", "where": "y > 0.5",
          "condition": { "flux": { "value": "2*ramp(t)" } } } ], "elsewhere": { "outflow": {} } } })j"),
                             set("fluid/navier_stokes/viscosity", "0.05") +
                               set("fluid/navier_stokes/tolerance", "1e-8") +
                               set("time/step", "0.5") + set("time/end", "5"));
  EXPECT_EQ(result.summary["retries"], 0);
  EXPECT_LT(result.summary["iterations"]["nonlinear_mean"], 7);
}


/// A part that coarse cells have and fine ones do not.
TEST_F(OutletsOfRuns, APartThatVanishesEndsTheRunByName)
{
  folder.write(
    "a.json",
    channel(R"j({ "velocity": { "value": [1, 0] } })j",
            R"j({ "parts": { "list": [ { "name": "slit", "where": "0.01 - abs(y - 0.375)",
              "condition": { "flux": { "value": 0.1 } } } ], "elsewhere": { "outflow": {} } } })j",
            R"j(, "structures": [ )j" + ring + R"j( } } ],
            "refinement": { "immersed_cells": { "level": 1, "minimum_level": 0, "interval": 1 } })j"));
  const RunResult host =
    run_host("a.json --output a" + set("time/integrator", R"({"lagged_midpoint":{}})") +
               set("fluid/navier_stokes/tolerance", "1e-8") + set("time/step", "0.05") +
               set("domain/boundary/y_min", R"({"free_slip":{}})") +
               set("domain/boundary/y_max", R"({"free_slip":{}})"),
             1,
             folder.path);
  EXPECT_EQ(host.exit_code, 1);
  const auto summary = read_json(folder / "a/summary.json");
  EXPECT_TRUE(holds(summary["message"],
                    "the condition \"slit\" (/domain/boundary/x_max/parts/list/0/"
                    "condition/flux) holds nowhere any more"))
    << host.output;
}
