// SPDX-License-Identifier: LGPL-2.1-or-later
// A case is built by the ranks it is told, which need not be all there are.
#include "support/run_case.h"

#include <feib/plugin_loader.h>
#include <feib/simulation.h>

#include <deal.II/base/mpi.h>

#include <gtest/gtest.h>

namespace
{
  using namespace feib;
  using feib::testing::Table;
  using feib::testing::TemporaryFolder;

  constexpr const char *text = R"j({
    "dimension": 2, "domain": { "cells": [4, 4] },
    "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.1,
      "initial_velocity": ["sin(pi*x)^2*sin(2*pi*y)", "-sin(2*pi*x)*sin(pi*y)^2"] } },
    "structures": [ { "membrane": { "name": "ring",
      "mesh": { "closed_curve": { "length": 1.2566370614359172, "elements": 32 } },
      "initial_position": ["0.5 + 0.25*cos(s1/0.2)", "0.5 + 0.15*sin(s1/0.2)"],
      "law": { "neo_hookean": { "shear_modulus": 0.1 } } } } ],
    "time": { "step": 0.01, "end": 0.04 }, "checkpoint": { "interval": 2 },
    "output": [ { "ledger_csv": {} }, { "vtu": {} },
      { "probe": { "name": "p", "at": { "points": { "places": [[0.5, 0.5]] } } } } ] })j";


  /// Runs the case, from the newest checkpoint of a folder where there is one.
  void
  run(const std::string &folder,
      const Case::Settings &settings,
      const MPI_Comm communicator,
      const bool goes_on)
  {
    Registry registry;
    PluginLoader loader(registry);
    for (const std::string &directory : PluginLoader::search_path({}))
      loader.load_directory(directory);
    const Case description(text, folder + "/case.json", registry, settings, "", communicator);
    Simulation::Options options;
    options.directory = folder;
    if (goes_on)
      options.restart = CheckpointInfo::newest(folder, communicator).folder;
    EXPECT_TRUE(Simulation::create(description, goes_on)->run(options));
  }
} // namespace

TEST(Communicator, ARunIsThatOfTheRanksItIsGiven)
{
  // Turned round: the first of the group is not the first of all.
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  MPI_Comm group;
  MPI_Comm_split(MPI_COMM_WORLD, rank == 0, -int(rank), &group);
  const bool first = dealii::Utilities::MPI::this_mpi_process(group) == 0;
  if (rank > 0)
    {
      // The folder of the first one.
      const TemporaryFolder own;
      const std::string parts  = dealii::Utilities::MPI::broadcast(group, own / "parts"),
                        whole  = dealii::Utilities::MPI::broadcast(group, own / "whole"),
                        beside = dealii::Utilities::MPI::broadcast(group, own / "beside");
      if (first)
        for (const std::string &folder : {parts, whole, beside})
          std::filesystem::create_directory(folder);
      MPI_Barrier(group);
      run(whole, {}, group, false);
      run(parts, {{"/time/end", "0.02"}}, group, false);
      run(parts, {}, group, true);
      run(beside, {{"/initial_state", "{\"run\": \"" + whole + "\"}"}}, group, false);
      if (first)
        {
          const Table expected = feib::testing::read_table(whole + "/ledger.csv"),
                      found    = feib::testing::read_table(parts + "/ledger.csv"),
                      later    = feib::testing::read_table(beside + "/ledger.csv");
          EXPECT_EQ(found.at("time").size(), expected.at("time").size());
          EXPECT_EQ(found.at("kinetic"), expected.at("kinetic"));
          EXPECT_NEAR(later.at("kinetic").front(), expected.at("kinetic").back(), 1e-12);
          EXPECT_TRUE(std::filesystem::exists(parts + "/fluid_000004.pvtu"));
        }
      MPI_Barrier(group);
    }
  MPI_Comm_free(&group);
}
