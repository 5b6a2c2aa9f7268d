// SPDX-License-Identifier: LGPL-2.1-or-later
// Laws with viscosity, state and time: energies close under every scheme, and the exact damping of
// a viscoelastic body that fills the box.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace feib::testing;

namespace
{
  const std::vector<std::string> schemes = {"fe_be",
                                            "be_be",
                                            "lagged_be",
                                            "midpoint",
                                            "lagged_midpoint"};

  const std::string rubber = R"({"neo_hookean": {"shear_modulus": 2, "stress_free": true}})";

  /// An ellipse that was a disc, free in a box.
  std::string
  body(const std::string &law)
  {
    return R"j({ "dimension": 2, "domain": { "cells": [8, 8] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.05 } },
      "structures": [ { "hyperelastic": { "name": "body",
        "mesh": { "disc": { "centre": [0.5, 0.5], "radius": 0.25, "rings": 3 } },
        "initial_position": ["0.5 + 1.2*(s1 - 0.5)", "0.5 + (s2 - 0.5)/1.2"],
        "law": )j" +
           law + R"j( } } ],
      "time": { "step": 0.008, "end": 0.2 },
      "output": [ { "ledger_csv": {} } ] })j";
  }

  /// What is wrong with the energies of a run.
  void
  expect_closed(const CaseRun &run)
  {
    const double scale = run.ledger.at("total_energy")[0];
    for (std::size_t n = 0; n < run.ledger.at("closure").size(); ++n)
      {
        EXPECT_LT(std::abs(run.ledger.at("closure")[n]), 1e-8 * scale) << "row " << n;
        EXPECT_LT(std::abs(run.ledger.at("unexplained")[n]), 1e-4 * scale) << "row " << n;
      }
    EXPECT_EQ(run.summary["status"], "completed") << run.summary["warnings"];
  }
} // namespace


TEST(Inelastic, ViscosityAndDamageDissipateUnderEveryScheme)
{
  const std::string viscous = R"({"kelvin_voigt": {"viscosity": 0.05, "law": )" + rubber + "}}";
  const std::string damaged = R"({"mullins_damage": {"r": 1.5, "m": 0.05, "law": )" + rubber + "}}";
  const std::string both    = R"({"kelvin_voigt": {"viscosity": 0.05, "law": )" + damaged + "}}";
  for (const std::string &law : {viscous, damaged, both})
    for (const std::string &scheme : schemes)
      {
        SCOPED_TRACE(scheme + ", " + law);
        const CaseRun result            = run_text(body(law), scheme_setting(scheme));
        const std::vector<double> &lost = result.ledger.at("inelastic");
        expect_closed(result);
        for (std::size_t n = 1; n < lost.size(); ++n)
          EXPECT_GE(lost[n], lost[n - 1] - 1e-14) << "row " << n;
        EXPECT_GT(lost.back(), 1e-4 * result.ledger.at("total_energy")[0]);
      }
}


/// The body is at rest, its fibres pull for one beat: they put energy in.
TEST(Inelastic, ActiveFibresPutEnergyInUnderEveryScheme)
{
  const std::string law =
    R"({"active_fibre": {"tension": "sin(5*t)^2", "fibres": [[1, 0]], "law": )" + rubber + "}}";
  for (const std::string &scheme : schemes)
    {
      SCOPED_TRACE(scheme);
      const CaseRun result =
        run_text(body(law),
                 scheme_setting(scheme) + " --set " +
                   shell_quoted(R"(/structures/0/hyperelastic/initial_position=["s1","s2"])") +
                   " --set /time/step=0.01 --set /time/end=0.63");
      for (const double closure : result.ledger.at("closure"))
        EXPECT_LT(std::abs(closure), 1e-10);
      EXPECT_EQ(result.summary["status"], "completed") << result.summary["warnings"];
      EXPECT_LT(result.ledger.at("inelastic").back(), -1e-4);
      EXPECT_GT(result.ledger.at("kinetic").back(), 1e-5);
    }
}


/// With fluid and body everywhere, the shear wave xi(t) sin(pi y) between walls is an oscillator,
///   rho xi'' + (mu + eta/2) pi^2 xi' + G pi^2 xi = 0,
/// for small xi: the viscous stress of a shear rate g is eta g/2.
TEST(Inelastic, ShearWaveOfAViscoelasticBody)
{
  const std::string text = R"x({ "dimension": 2, "domain": { "cells": [8, 8], "periodic": ["x"] },
      "fluid": { "navier_stokes": { "density": 1, "viscosity": 0.01,
                                    "initial_velocity": ["0.01*sin(pi*y)", 0] } },
      "structures": [ { "hyperelastic": { "name": "body",
        "mesh": { "rectangle": { "cells": [16, 16] } },
        "law": {"kelvin_voigt": {"viscosity": 0.2, "law": {"neo_hookean": {"shear_modulus": 1}}}} } } ],
      "time": { "step": 0.01, "end": 0.7 },
      "output": [ { "ledger_csv": {} } ] })x";
  constexpr double pi = dealii::numbers::PI, gamma = (.01 + .1) * pi * pi / 2;
  const double omega = std::sqrt(pi * pi - gamma * gamma);
  for (const std::string scheme : {"midpoint", "lagged_midpoint"})
    {
      SCOPED_TRACE(scheme);
      const CaseRun result = run_text(text, scheme_setting(scheme));
      const Table &ledger  = result.ledger;
      for (const std::size_t n : {20u, 40u, 70u})
        {
          const double t = ledger.at("time")[n];
          const double velocity =
            std::exp(-gamma * t) * (std::cos(omega * t) - gamma / omega * std::sin(omega * t));
          EXPECT_NEAR(ledger.at("kinetic")[n] / ledger.at("kinetic")[0], velocity * velocity, .01)
            << "time " << t;
        }
    }
}
