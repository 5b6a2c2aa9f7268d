// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_tests_small_case_h
#define feib_tests_small_case_h

namespace feib::testing
{
  /// A fluid at rest: one quick step.
  const char *const small_case = R"({
  "dimension": 2,
  "domain": { "cells": [2, 2] },
  "fluid": { "navier_stokes": { "density": 1, "viscosity": 1 } },
  "structures": [],
  "time": { "step": 0.1, "end": 0.1 }
}
)";
} // namespace feib::testing

#endif
