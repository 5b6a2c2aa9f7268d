// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_spectrum_h
#define feib_plugins_navier_stokes_spectrum_h

#include "multigrid/level_space.h"

#include <utility>

namespace feib
{
  /// The ends of the spectrum of D^{-1} A, with A the matrix of the form on a level and D its
  /// diagonal: of fields on lattices of equal cells that are the same in every cell, or change
  /// their sign from one to the next, direction by direction; where outflows meet, bounds from
  /// single cells (A and D are sums over cells). Near hanging nodes and at an outflow an estimate.
  template <int dim>
  std::pair<double, double> spectrum(const LevelSpace<dim> &space, const VelocityForm &form);
} // namespace feib

#endif
