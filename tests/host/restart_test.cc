// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs that are taken up again: after a kill at any moment, a signal, an earlier end.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <map>
#include <random>

using namespace feib::testing;

namespace
{
  namespace fs = std::filesystem;
  using nlohmann::json;

  using Table = std::map<std::string, std::vector<std::string>>; // columns

  Table
  read_table(const std::string &file)
  {
    std::istringstream lines(read_file(file));
    std::string line, entry;
    std::vector<std::string> names;
    Table table;
    while (std::getline(lines, line))
      {
        std::istringstream entries(line);
        const bool heading = names.empty();
        for (std::size_t i = 0; std::getline(entries, entry, ','); ++i)
          if (heading)
            names.push_back(entry);
          else
            table[names.at(i)].push_back(entry);
      }
    return table;
  }


  /// Of all but the seconds spent.
  void
  expect_same_ledger(const std::string &folder, const std::string &expected)
  {
    const Table found = read_table(folder + "/ledger.csv"),
                right = read_table(expected + "/ledger.csv");
    ASSERT_GT(right.at("step").size(), 2u);
    for (const auto &[name, column] : right)
      if (name.rfind("seconds_", 0) != 0)
        {
          EXPECT_EQ(found.at(name), column) << name << " in " << folder;
        }
  }


  /// All other files that grow.
  void
  expect_same_files(const std::string &folder, const std::string &expected)
  {
    for (const auto &entry : fs::directory_iterator(expected))
      {
        const std::string name = entry.path().filename();
        if (entry.path().extension() == ".pvd" || name.rfind("probe_", 0) == 0)
          {
            EXPECT_EQ(read_file(folder + "/" + name), read_file(entry.path())) << name;
          }
      }
  }


  unsigned int
  n_rows(const std::string &folder)
  {
    std::ifstream file(folder + "/ledger.csv");
    unsigned int n = 0;
    for (std::string line; std::getline(file, line);)
      ++n;
    return n;
  }


  unsigned int
  last_checkpoint(const std::string &folder)
  {
    unsigned int last = 0;
    for (const auto &entry : fs::directory_iterator(folder + "/checkpoints"))
      if (const std::string name = entry.path().filename(); name.rfind("step_", 0) == 0)
        last = std::max<unsigned int>(last, std::stoul(name.substr(5)));
    return last;
  }


  /// feib-host as a process that can be sent signals.
  class Process
  {
  public:
    explicit Process(const std::vector<std::string> &arguments)
    {
      std::vector<std::string> all = {FEIB_HOST};
      all.insert(all.end(), arguments.begin(), arguments.end());
      std::vector<char *> pointers;
      for (std::string &argument : all)
        pointers.push_back(argument.data());
      pointers.push_back(nullptr);
      id = fork();
      if (id == 0)
        {
          if (freopen("/dev/null", "w", stdout) != nullptr &&
              freopen("/dev/null", "w", stderr) != nullptr)
            execv(FEIB_HOST, pointers.data());
          _exit(127);
        }
    }

    ~Process()
    {
      if (running())
        {
          kill(id, SIGKILL);
          wait();
        }
    }

    bool
    running()
    {
      if (!ended && waitpid(id, &status, WNOHANG) == id)
        ended = true;
      return !ended;
    }

    /// The exit code; 128 + the signal where one ended it.
    int
    wait()
    {
      if (!ended)
        waitpid(id, &status, 0);
      ended = true;
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }

    /// Waits until the ledger has so many lines, or the process has ended.
    void
    wait_for_rows(const std::string &folder, const unsigned int rows)
    {
      while (running() && n_rows(folder) < rows)
        ;
    }

    void
    signal(const int number) const
    {
      kill(id, number);
    }

  private:
    pid_t id;
    int status = 0;
    bool ended = false;
  };


  /// A heavy disc carried around, with most of what a scheme can remember.
  json
  disc_case()
  {
    return json::parse(R"({
      "dimension": 2,
      "domain": { "cells": [8, 8], "boundary": { "y_max": { "velocity": { "value": ["1+t", 0] } } } },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.02, "linear_solver": "direct" } },
      "structures": [ { "hyperelastic": { "name": "disc", "mesh": { "disc": { "radius": 0.2, "rings": 3 } },
        "initial_position": ["0.6+s1", "0.5+s2"], "law": { "neo_hookean": { "shear_modulus": 0.5 } }, "excess_density": 1 } } ],
      "refinement": { "immersed_cells": { "level": 1, "interval": 7 } },
      "time": { "step": 0.02, "end": 0.8, "control": { "adaptive": {} }, "integrator": { "lagged_midpoint": {} } },
      "checkpoint": { "interval": 5, "keep": 3 },
      "output": [ { "ledger_csv": {} }, { "vtu": { "interval": 10 } },
        { "probe": { "name": "a", "interval": 3, "at": { "points": { "places": [[0.5, 0.5], [0.1, 0.9]] } } } } ]
    })");
  }


  class RestartAfterKill : public ::testing::TestWithParam<const char *>
  {
  protected:
    TemporaryFolder folder;

    std::vector<std::string>
    arguments() const
    {
      if (std::string(GetParam()) == "disc")
        return {folder.write("disc.json", disc_case().dump())};
      const char *const wanted = std::getenv("FEIB_KILL_END");
      return {std::string(FEIB_SOURCE) + "/cases/elliptic_shell/case.json",
              "--set",
              std::string("/time/end=") + (wanted != nullptr ? wanted : "0.03"),
              "--set",
              R"(/checkpoint={"interval":4})",
              "--set",
              R"(/output=[{"ledger_csv":{}},{"vtu":{"interval":10}}])"};
    }
  };


  /// FEIB_KILLS of them, at random moments of which the seed is printed; the shell to
  /// FEIB_KILL_END.
  TEST_P(RestartAfterKill, NothingIsLostOrDoubled)
  {
    const char *const wanted       = std::getenv("FEIB_KILLS");
    const unsigned int n_kills     = wanted != nullptr ? std::stoul(wanted) : 5;
    std::vector<std::string> whole = arguments(), killed = whole;
    whole.insert(whole.end(), {"--output", folder / "whole"});
    ASSERT_EQ(Process(whole).wait(), 0);
    const unsigned int rows = n_rows(folder / "whole");

    const unsigned int seed = std::random_device()();
    std::mt19937 random(seed);
    std::cout << "seed " << seed << ", " << rows << " rows" << std::endl;
    killed.insert(killed.end(), {"--overwrite", "--output", folder / "killed"});
    unsigned int resumed = 0;
    for (unsigned int k = 0; k < n_kills;)
      {
        // From the start, then taken up and killed again until it gets to its end.
        fs::remove_all(folder / "killed");
        std::vector<std::string> next = killed;
        for (bool end = false; !end;)
          {
            const unsigned int reached =
              fs::exists(folder / "killed") ? n_rows(folder / "killed") : 0;
            Process process(next);
            if (k < n_kills && reached < rows)
              {
                // At any moment of a start, or of a step further than before; the first checkpoint
                // comes before the row of the first step.
                const bool while_starting = reached >= 3 && random() % 5 == 0;
                if (!while_starting)
                  process.wait_for_rows(folder / "killed",
                                        std::uniform_int_distribution<unsigned int>(
                                          std::max(3u, reached + 1), rows)(random));
                std::uniform_int_distribution<int> delay(0, while_starting ? 1000000 : 40000);
                const auto moment =
                  std::chrono::steady_clock::now() + std::chrono::microseconds(delay(random));
                while (process.running() && std::chrono::steady_clock::now() < moment)
                  ;
                process.signal(SIGKILL);
              }
            const int code = process.wait();
            ASSERT_TRUE(code == 0 || code == 128 + SIGKILL) << code;
            end = code == 0;
            if (!end)
              {
                ++k;
                ++resumed;
              }
            next = {"--restart", folder / "killed"};
          }
        expect_same_ledger(folder / "killed", folder / "whole");
        expect_same_files(folder / "killed", folder / "whole");
        if (HasFailure())
          return;
      }
    std::cout << resumed << " kills, all taken up" << std::endl;
    EXPECT_GE(resumed, n_kills);
  }

  INSTANTIATE_TEST_SUITE_P(Cases, RestartAfterKill, ::testing::Values("shell", "disc"));


  /// Runs a case to @p ends one after the other, on those numbers of ranks; returns the folder.
  std::string
  run_in_pieces(const TemporaryFolder &folder,
                const json &document,
                const std::vector<double> &ends,
                const std::vector<unsigned int> &ranks)
  {
    static int count       = 0;
    const std::string name = "pieces_" + std::to_string(++count);
    const std::string file = folder.write(name + ".json", document.dump());
    for (std::size_t i = 0; i < ends.size(); ++i)
      {
        const RunResult result =
          run_host((i == 0 ? file + " --output " + name : "--restart " + name) +
                     " --set /time/end=" + std::to_string(ends[i]),
                   ranks[i],
                   folder.path);
        EXPECT_EQ(result.exit_code, 0) << result.output;
      }
    return folder / name;
  }


  TEST(Restart, EverySchemeAndSolverToTheBit)
  {
    const TemporaryFolder folder;
    for (const char *const scheme : {"fe_be", "be_be", "lagged_be", "midpoint", "lagged_midpoint"})
      for (const char *const solver : {"direct", "multigrid"})
        {
          SCOPED_TRACE(std::string(scheme) + ", " + solver);
          json document                                        = disc_case();
          document["fluid"]["navier_stokes"]["linear_solver"]  = solver;
          document["time"]["integrator"]                       = {{scheme, json::object()}};
          document["time"]["control"]                          = {{"fixed", json::object()}};
          document["time"]["step"]                             = 0.01;
          document["refinement"]["immersed_cells"]["interval"] = 3;
          document["checkpoint"]["interval"]                   = 6;
          const std::string whole  = run_in_pieces(folder, document, {.12}, {1});
          const std::string pieces = run_in_pieces(folder, document, {.06, .12}, {1, 1});
          expect_same_ledger(pieces, whole);
          expect_same_files(pieces, whole);
        }
  }


  /// A case of the tree, made small, with "ledger_csv" for output.
  json
  small_case(const std::string &name, const json &changes)
  {
    json document = json::parse(
      read_file(std::string(FEIB_SOURCE) + "/cases/" + name + "/case.json"), nullptr, true, true);
    document.erase("$schema");
    document["output"] = json::parse(R"([{"ledger_csv":{}}])");
    for (const auto &[pointer, value] : changes.items())
      document[json::json_pointer(pointer)] = value;
    return document;
  }


  /// Surfaces in three dimensions, levels that follow the structure or the flow, the classical
  /// coupling, directions of fibres, forces that are tested with reconstructed velocities, a long
  /// box: what the disc has not.
  TEST(Restart, EveryDimensionRefinementAndCouplingToTheBit)
  {
    const TemporaryFolder folder;
    const json follow                    = {{"immersed_cells", {{"level", 1}, {"interval", 2}}}};
    const std::pair<json, double> runs[] = {
      {small_case("ellipsoid", {{"/domain/cells", {4, 4, 4}}, {"/refinement", follow}}), 8e-3},
      {small_case("elliptic_membrane",
                  {{"/domain/cells", {16, 16}},
                   {"/structures/0/membrane/mesh/closed_curve/elements", 64},
                   {"/refinement",
                    {{"error_indicator", {{"maximum_level", 1}, {"interval", 2}}}}}}),
       4e-3},
      {small_case("fibre_ring",
                  {{"/domain/cells", {8, 8}},
                   {"/structures/0/hyperelastic/mesh/ring/cells", {32, 2}}}),
       6e-3},
      {small_case("elliptic_membrane",
                  {{"/domain/cells", {8, 8}},
                   {"/structures/0/membrane/mesh/closed_curve/elements", 32},
                   {"/fluid/navier_stokes/body_force", {"20*sin(6*x)", "cos(9*x)*t"}},
                   {"/fluid/navier_stokes/reconstruction", "body_force"}}),
       2e-3},
      // A long box: its trees are in another order than its coarse cells.
      {small_case(
         "cylinder_2d",
         {{"/time/step", .015625}, {"/checkpoint", {{"interval", 3}}}, {"/statistics/from", 0}}),
       .09375}};
    for (const auto &[document, end] : runs)
      {
        SCOPED_TRACE(document["title"]);
        const std::string whole = run_in_pieces(folder, document, {end}, {1});
        expect_same_ledger(run_in_pieces(folder, document, {end / 2, end}, {1, 1}), whole);
      }
  }


  TEST(Restart, StateOfLawsToTheBit)
  {
    const TemporaryFolder folder;
    const json rubber   = {{"neo_hookean", {{"shear_modulus", .5}}}};
    const json softened = {{"mullins_damage", {{"r", 1.5}, {"m", .01}, {"law", rubber}}}};
    const json active   = {
        {"active_fibre",
         {{"tension", "0.1*sin(9*t)^2"}, {"fibres", {{1, "s1"}}}, {"law", softened}}}};
    for (const char *const scheme : {"fe_be", "be_be", "lagged_be", "midpoint", "lagged_midpoint"})
      {
        SCOPED_TRACE(scheme);
        json document                                       = disc_case();
        document["fluid"]["navier_stokes"]["linear_solver"] = "multigrid";
        document["time"]["integrator"]                      = {{scheme, json::object()}};
        document["time"]["step"]                            = 0.005;
        document["time"]["control"]                         = {{"fixed", json::object()}};
        document["structures"][0]["hyperelastic"]["law"]    = {
             {"kelvin_voigt", {{"viscosity", .02}, {"law", active}}}};
        document["output"]      = json::parse(R"([{"ledger_csv":{}}])");
        const std::string whole = run_in_pieces(folder, document, {.06}, {1});
        expect_same_ledger(run_in_pieces(folder, document, {.03, .06}, {1, 1}), whole);
        const Table ledger = read_table(whole + "/ledger.csv");
        EXPECT_NE(std::stod(ledger.at("inelastic").back()), 0);
        if (std::string(scheme) != "midpoint")
          continue;
        // On other ranks elements change hands.
        const auto dissipated = [&](const std::vector<unsigned int> &ranks) {
          const std::string pieces = run_in_pieces(folder, document, {.03, .06}, ranks);
          return std::stod(read_table(pieces + "/ledger.csv").at("inelastic").back());
        };
        const double alone = dissipated({1, 1});
        EXPECT_NEAR(dissipated({2, 1}), alone, 1e-6 * std::abs(alone));
      }
  }


  /// Springs that move, damp and break, weight, dead and follower loads, walls.
  TEST(Restart, ForcesToTheBit)
  {
    const TemporaryFolder folder;
    for (const char *const scheme : {"fe_be", "be_be", "lagged_be", "midpoint", "lagged_midpoint"})
      {
        SCOPED_TRACE(scheme);
        json document                                       = disc_case();
        document["fluid"]["navier_stokes"]["linear_solver"] = "multigrid";
        document["time"]["integrator"]                      = {{scheme, json::object()}};
        document["time"]["step"]                            = 0.005;
        document["time"]["control"]                         = {{"fixed", json::object()}};
        document["structures"][0]["hyperelastic"]["forces"] = json::parse(R"j([
          {"gravity": {"acceleration": [0, "-3 - t"]}},
          {"spring_network": {"stiffness": 0.5, "damping": 0.1, "breaking_stretch": 1.01}},
          {"tether": {"stiffness": 20, "damping": 1, "on": {"where": "s1 < 0"},
                      "target": ["0.6+s1+0.1*sin(9*t)", "0.5+s2"],
                      "target_velocity": ["0.9*cos(9*t)", 0]}},
          {"traction": {"pressure": "1 + t", "force": [0.1, 0], "on": {"boundary": true}}},
          {"contact": {"range": 0.25, "strength": 2}}])j");
        document["output"]                                  = json::parse(R"([{"ledger_csv":{}}])");
        const std::string whole = run_in_pieces(folder, document, {.05}, {1});
        expect_same_ledger(run_in_pieces(folder, document, {.025, .05}, {1, 1}), whole);
        // Some springs have broken.
        EXPECT_GT(
          std::stod(read_table(whole + "/ledger.csv").at("energy_disc_spring_network").back()), 0);
      }
  }


  // MUMPS on several ranks adds in an order that depends on time: no two runs are the same.
  TEST(Restart, OnTwoRanksToTheBit)
  {
    const TemporaryFolder folder;
    json document                                       = disc_case();
    document["fluid"]["navier_stokes"]["linear_solver"] = "multigrid";
    document["time"]["control"]                         = {{"fixed", json::object()}};
    const std::string whole = run_in_pieces(folder, document, {.4}, {2});
    expect_same_ledger(run_in_pieces(folder, document, {.2, .4}, {2, 2}), whole);
  }


  TEST(Restart, OnAnotherNumberOfRanksToTheTolerance)
  {
    const TemporaryFolder folder;
    json document                                   = disc_case();
    document["time"]["control"]                     = {{"fixed", json::object()}};
    document["fluid"]["navier_stokes"]["tolerance"] = 1e-11;
    const Table whole = read_table(run_in_pieces(folder, document, {.6}, {1}) + "/ledger.csv");
    const Table pieces =
      read_table(run_in_pieces(folder, document, {.2, .4, .6}, {2, 1, 3}) + "/ledger.csv");
    ASSERT_EQ(whole.at("step"), pieces.at("step"));
    for (const char *const name : {"kinetic",
                                   "elastic",
                                   "dissipated",
                                   "total_energy",
                                   "largest_velocity",
                                   "measure_disc",
                                   "centroid_x_disc"})
      for (std::size_t i = 0; i < whole.at(name).size(); ++i)
        EXPECT_NEAR(std::stod(pieces.at(name)[i]), std::stod(whole.at(name)[i]), 1e-8)
          << name << " in row " << i;
    EXPECT_EQ(whole.at("cells"), pieces.at("cells"));
  }


  /// Whatever the first piece did, multiples of the step are hit from then on, once each.
  TEST(Restart, AnotherControlAndEndsBesideTheMultiples)
  {
    const TemporaryFolder folder;
    json document            = disc_case();
    document["time"]["step"] = .01;
    document["output"]       = json::parse(R"([{"ledger_csv":{}}])");
    const auto times_after =
      [&](const char *const first, const char *const then, const double end, const double begin) {
        document["time"]["control"] = {{first, json::object()}};
        const std::string name      = std::string(first) + "_" + then;
        const std::string file      = folder.write(name + ".json", document.dump());
        EXPECT_EQ(run_host(file + " --output " + name +
                             " --overwrite --set /time/end=" + std::to_string(begin),
                           1,
                           folder.path)
                    .exit_code,
                  0);
        const RunResult result =
          run_host("--restart " + name + " --set /time/end=" + std::to_string(end) +
                     " --set '/time/control={\"" + then + "\":{}}'",
                   1,
                   folder.path);
        EXPECT_EQ(result.exit_code, 0) << result.output;
        std::vector<double> times;
        const Table ledger = read_table(folder / (name + "/ledger.csv"));
        for (const std::string &time : ledger.at("time"))
          if (std::stod(time) > begin)
            times.push_back(std::stod(time));
        return times;
      };
    const auto expect = [](const std::vector<double> &times, const std::vector<double> &expected) {
      ASSERT_EQ(times.size(), expected.size());
      for (unsigned int i = 0; i < times.size(); ++i)
        EXPECT_NEAR(times[i], expected[i], 1e-14);
    };
    expect(times_after("adaptive", "fixed", .055, .033), {.04, .05, .055});
    expect(times_after("fixed", "fixed", .055, .033), {.04, .05, .055});
    expect(times_after("fixed", "fixed", .05, .03), {.04, .05});
    const std::vector<double> adaptive = times_after("fixed", "adaptive", .055, .033);
    EXPECT_EQ(adaptive.back(), .055);
  }


  TEST(Restart, ADamagedCheckpointIsPassedOver)
  {
    const TemporaryFolder folder;
    const json document      = disc_case();
    const std::string whole  = run_in_pieces(folder, document, {.8}, {1});
    const std::string pieces = run_in_pieces(folder, document, {.4}, {1});
    const std::string newest =
      pieces + "/checkpoints/step_" + std::to_string(last_checkpoint(pieces));
    for (const char *const file : {"fields", "values", "manifest.json"})
      {
        // One bit is enough.
        const std::string content = read_file(newest + "/" + file);
        std::string changed       = content;
        changed[changed.size() / 2] ^= 1;
        std::ofstream(newest + "/" + file) << changed;
        const RunResult result = run_host("--validate --restart " + pieces);
        EXPECT_EQ(result.exit_code, 0) << result.output;
        EXPECT_NE(result.output.find(newest + " is damaged"), std::string::npos) << result.output;
        EXPECT_NE(result.output.find(file), std::string::npos) << result.output;
        std::ofstream(newest + "/" + file) << content;
      }
    fs::resize_file(newest + "/fields", 100);
    const RunResult result = run_host("--restart " + pieces);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_EQ(read_json(pieces + "/summary.json")["time"], .4);
    expect_same_ledger(run_in_pieces(folder, document, {.4}, {1}), pieces);

    for (const auto &entry : fs::directory_iterator(pieces + "/checkpoints"))
      fs::remove(entry.path() / "values");
    const RunResult none = run_host("--restart " + pieces);
    EXPECT_EQ(none.exit_code, 2);
    EXPECT_NE(none.output.find("there is no other"), std::string::npos) << none.output;
  }


  TEST(Restart, WhatWouldBeAnotherRunIsRefused)
  {
    const TemporaryFolder folder;
    const std::string run    = run_in_pieces(folder, disc_case(), {.1}, {1});
    const std::string before = read_file(run + "/resolved.json"),
                      ledger = read_file(run + "/ledger.csv");
    const std::pair<std::string, std::string> faults[] = {
      {"--restart " + run + " --set /fluid/navier_stokes/viscosity=0.1",
       "/fluid/navier_stokes/viscosity: found 0.1, and the run to go on with had 0.02"},
      {"--restart " + run + " --set /structures=[]", "/structures: found []"},
      {"--restart " + run + " --set '/time/integrator={\"midpoint\":{}}'", "/time/integrator"},
      {"--restart " + run + " --set /time/end=-1", "/time/end"},
      {"--restart " + run + " --set /time/end=0.05",
       "/time/end: found 0.05, and the checkpoint " + run + "/checkpoints/"},
      {"--restart " + folder.path.string(), "there is no checkpoint in"},
      {"--restart " + (folder / "nowhere"), "there is no checkpoint in"},
      {"--restart " + run + " --output " + (folder / "other"), "--output"},
      {"case.json --restart " + run, "case.json too"}};
    for (const auto &[arguments, sentence] : faults)
      {
        const RunResult result = run_host(arguments);
        EXPECT_EQ(result.exit_code, 2) << arguments << '\n' << result.output;
        EXPECT_NE(result.output.find(sentence), std::string::npos) << result.output;
      }
    EXPECT_EQ(read_file(run + "/resolved.json"), before);
    EXPECT_EQ(read_file(run + "/ledger.csv"), ledger);

    // A file that was changed is neither continued nor written anew.
    std::ofstream(run + "/ledger.csv") << "step\n";
    const RunResult cut = run_host("--restart " + run + " --set /time/end=0.2");
    EXPECT_EQ(cut.exit_code, 1) << cut.output;
    EXPECT_NE(cut.output.find("it is of another run, or has been changed"), std::string::npos)
      << cut.output;
    EXPECT_EQ(read_file(run + "/ledger.csv"), "step\n");
    std::ofstream(run + "/ledger.csv") << ledger;

    // What may change.
    const RunResult changed =
      run_host("--restart " + run +
               " --set /time/end=0.2 --set '/output=[{\"ledger_csv\":{\"interval\":2}}]'");
    EXPECT_EQ(changed.exit_code, 0) << changed.output;
    EXPECT_EQ(read_json(run + "/summary.json")["time"], .2);
  }


  TEST(Restart, AFileThatWasChangedIsRefused)
  {
    const TemporaryFolder folder;
    json document = disc_case();
    folder.write("speed.csv", "0 0\n1 1\n");
    document["series"]["speed"]["file"] = "speed.csv";
    const std::string run               = run_in_pieces(folder, document, {.1}, {1});
    const auto goes_on = [&] { return run_host("--restart " + run + " --set /time/end=0.15"); };
    folder.write("speed.csv", "0 0\n1 2\n");
    RunResult result = goes_on();
    EXPECT_EQ(result.exit_code, 2) << result.output;
    EXPECT_NE(result.output.find("/series/speed/file: names a file that has changed since "),
              std::string::npos)
      << result.output;
    std::filesystem::remove(folder / "speed.csv");
    result = goes_on();
    EXPECT_EQ(result.exit_code, 2) << result.output;
    EXPECT_NE(result.output.find("speed.csv\": there is no such file"), std::string::npos)
      << result.output;
    folder.write("speed.csv", "0 0\n1 1\n");
    result = goes_on();
    EXPECT_EQ(result.exit_code, 0) << result.output;
  }


  TEST(Restart, SignalsLeaveACheckpoint)
  {
    const TemporaryFolder folder;
    json document                      = disc_case();
    document["checkpoint"]["interval"] = 0;
    const std::string file             = folder.write("disc.json", document.dump());
    const std::string whole            = run_in_pieces(folder, document, {.8}, {1});

    Process going_on({file, "--output", folder / "usr1"});
    going_on.wait_for_rows(folder / "usr1", 6);
    going_on.signal(SIGUSR1);
    while (going_on.running() && last_checkpoint(folder / "usr1") == 0)
      ;
    EXPECT_GT(last_checkpoint(folder / "usr1"), 3u);
    EXPECT_EQ(going_on.wait(), 0);
    EXPECT_EQ(read_json(folder / "usr1/summary.json")["status"], "completed");

    for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGUSR2, SIGXCPU})
      {
        SCOPED_TRACE(number);
        const std::string name = folder / ("stopped_" + std::to_string(number));
        Process stopped({file, "--output", name});
        stopped.wait_for_rows(name, 5);
        stopped.signal(number);
        EXPECT_EQ(stopped.wait(), 1);
        EXPECT_EQ(read_json(name + "/summary.json")["status"], "stopped");
        const RunResult result = run_host("--restart " + name);
        EXPECT_EQ(result.exit_code, 0) << result.output;
        expect_same_ledger(name, whole);
        expect_same_files(name, whole);
      }
  }
} // namespace
