// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/fluid_solver_kit.h>

FEIB_TEST_FLUID_SOLVER("navier_stokes");

/// Beside the examples of the schema.
TEST(NavierStokesKit, AllOptionsKeepTheRequirements)
{
  using namespace feib::testing;
  const std::string fluid = "{\"density\": 1.3, \"viscosity\": 0.05";
  for (const std::string options :
       {", \"convection\": \"none\", \"linear_solver\": \"direct\"}",
        ", \"convection\": \"none\", \"linear_solver\": \"multigrid\", \"grad_div\": 0.1}",
        ", \"linear_solver\": \"direct\", \"viscous_form\": \"laplacian\"}",
        ", \"linear_solver\": \"multigrid\", \"convective_form\": \"skew_symmetric\"}"})
    {
      SCOPED_TRACE(options);
      check_step<2>("navier_stokes", fluid + options);
      check_powers<2>("navier_stokes", fluid + options);
      check_rest<2>("navier_stokes", fluid + options);
      check_projection<2>("navier_stokes", fluid + options);
      check_commit<2>("navier_stokes", fluid + options);
      check_fluid_checkpoint<2>("navier_stokes", fluid + options);
      check_fluid_ranks<2>("navier_stokes", fluid + options);
    }
}
