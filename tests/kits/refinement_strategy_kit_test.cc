// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kit_test.h"

#include <feib/testing/refinement_strategy_kit.h>

// Without a fault the kit finds none.
FEIB_TEST_REFINEMENT_STRATEGY("wrong_refinement");

namespace
{
  using namespace feib::testing;

  const ExpectNamed expect_named{"wrong_refinement",
                                 R"({"immersed_cells": {"level": 3, "minimum_level": 1}})"};
} // namespace

TEST(RefinementStrategyKitItself, NamesWhatIsWrong)
{
  expect_named(check_mesh<2>, "flickers", "the mesh changes again and again");
  expect_named(check_mesh<2>, "stays", "cells where the structure is now");
  expect_named(check_mesh<3>, "forecasts more", "forecast: ");
  expect_named(check_refinement_checkpoint<2>, "forgets", "cells_of");
  if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) > 1)
    expect_named(check_refinement_ranks<2>, "by rank", "cells_of");
}
