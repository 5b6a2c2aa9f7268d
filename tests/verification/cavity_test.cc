// SPDX-License-Identifier: LGPL-2.1-or-later
// The steady lid-driven cavity against published extrema of the velocity on its centre lines.
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <iomanip>

namespace
{
  using namespace feib::testing;

  struct Extremum
  {
    double value, position;
  };

  /// u_min on x = 1/2, v_max and v_min on y = 1/2.
  using Extrema = std::array<Extremum, 3>;

  const char *const names[] = {"u_min", "v_max", "v_min"};

  /// The columns x, y, velocity_x, velocity_y of the last output of a probe.
  std::vector<std::array<double, 4>>
  last_profile(const std::string &file)
  {
    std::istringstream lines(read_file(file));
    std::string line, field, step;
    std::getline(lines, line);
    EXPECT_EQ(line, "step,time,point,x,y,velocity_x,velocity_y,pressure");
    std::vector<std::array<double, 4>> profile;
    while (std::getline(lines, line))
      {
        std::istringstream fields(line);
        std::getline(fields, field, ',');
        if (field != step)
          profile.clear();
        step = field;
        std::getline(fields, field, ',');
        std::getline(fields, field, ',');
        profile.emplace_back();
        for (double &value : profile.back())
          {
            std::getline(fields, field, ',');
            value = std::stod(field);
          }
      }
    return profile;
  }

  /// The largest value (times sign) inside, on the parabola through the largest sample and its
  /// neighbours: the profile of a Q2 velocity is a parabola in each cell.
  Extremum
  extremum(const std::vector<std::array<double, 4>> &profile,
           const unsigned int axis,
           const unsigned int component,
           const double sign)
  {
    std::size_t at = 1;
    for (std::size_t i = 1; i + 1 < profile.size(); ++i)
      if (sign * profile[i][2 + component] > sign * profile[at][2 + component])
        at = i;
    const double before = profile[at - 1][2 + component], here = profile[at][2 + component],
                 after = profile[at + 1][2 + component],
                 step  = profile[at + 1][axis] - profile[at][axis];
    const double slope = (after - before) / 2, curvature = after - 2 * here + before;
    return {here - slope * slope / (2 * curvature), profile[at][axis] - slope / curvature * step};
  }

  Extrema
  run_cavity(const unsigned int n, const double reynolds, const std::string &settings = "")
  {
    const TemporaryFolder folder;
    const std::string cells = std::to_string(n);
    std::ostringstream viscosity;
    viscosity << std::setprecision(17) << 1 / reynolds;
    const RunResult run =
      run_host(shell_quoted(FEIB_SOURCE "/cases/lid_driven_cavity/case.json") + " --output " +
               shell_quoted(folder / "results") + " --set /domain/cells=[" + cells + "," + cells +
               "] --set /fluid/navier_stokes/viscosity=" + viscosity.str() +
               " --set '/output/0/vtu/interval=1000'" + settings);
    if (run.exit_code != 0)
      throw std::runtime_error(run.output);
    const auto vertical   = last_profile(folder / "results/probe_vertical.csv"),
               horizontal = last_profile(folder / "results/probe_horizontal.csv");
    const Extrema found   = {extremum(vertical, 1, 0, -1),
                             extremum(horizontal, 0, 1, 1),
                             extremum(horizontal, 0, 1, -1)};
    std::printf("Re = %g, %u^2 cells%s:", reynolds, n, settings.empty() ? "" : ", refined");
    for (unsigned int i = 0; i < 3; ++i)
      std::printf(" %s %.6f at %.4f", names[i], found[i].value, found[i].position);
    std::printf("\n");
    return found;
  }

  /// A few per cent: that is how far they are from the spectral values themselves.
  void
  expect_ghia(const Extrema &found, const Extrema &ghia)
  {
    for (unsigned int i = 0; i < 3; ++i)
      {
        EXPECT_NEAR(found[i].value, ghia[i].value, .04 * std::abs(ghia[i].value)) << names[i];
        // The positions are those of their 128 x 128 intervals.
        EXPECT_NEAR(found[i].position, ghia[i].position, 1.25 / 128) << names[i];
      }
  }

  void
  expect_spectral(const Extrema &coarse,
                  const Extrema &fine,
                  const Extrema &spectral,
                  const double tolerance)
  {
    for (unsigned int i = 0; i < 3; ++i)
      {
        const double error        = std::abs(fine[i].value - spectral[i].value),
                     coarse_error = std::abs(coarse[i].value - spectral[i].value);
        std::printf("%s: error %.1e, on the coarse mesh %.1e\n", names[i], error, coarse_error);
        EXPECT_LT(error, tolerance) << names[i];
        // At least the third order of velocities in L2.
        EXPECT_LT(error, coarse_error / 8) << names[i];
        EXPECT_NEAR(fine[i].position, spectral[i].position, 5e-4) << names[i];
      }
  }
} // namespace

// Ghia, Ghia, Shin, J. Comput. Phys. 48 (1982) 387: tables I and II, 129 x 129 points.
// Botella, Peyret, Computers & Fluids 27 (1998) 421: spectral, singular parts at the corners
// subtracted.

TEST(LidDrivenCavity, Re100)
{
  const Extrema coarse = run_cavity(32, 100), fine = run_cavity(64, 100);
  expect_ghia(fine, {{{-0.21090, 0.4531}, {0.17527, 0.2344}, {-0.24533, 0.8047}}});
  expect_spectral(coarse,
                  fine,
                  {{{-0.2140424, 0.4581}, {0.1795728, 0.2370}, {-0.2538030, 0.8104}}},
                  1.5e-5);
}

TEST(LidDrivenCavity, Re400)
{
  expect_ghia(run_cavity(64, 400), {{{-0.32726, 0.2813}, {0.30203, 0.2266}, {-0.44993, 0.8594}}});
}

TEST(LidDrivenCavity, Re1000)
{
  const Extrema coarse = run_cavity(32, 1000), fine = run_cavity(64, 1000);
  const Extrema spectral = {{{-0.3885698, 0.1717}, {0.3769447, 0.1578}, {-0.5270771, 0.9092}}};
  expect_ghia(fine, {{{-0.38289, 0.1719}, {0.37095, 0.1563}, {-0.51550, 0.9063}}});
  expect_spectral(coarse, fine, spectral, 4e-4);

  // Refined where the velocity's gradient jumps, half as many cells are better.
  const Extrema refined =
    run_cavity(32,
               1000,
               " --set '/refinement={\"error_indicator\": {\"indicator\": \"kelly\","
               " \"marking\": \"fixed_fraction\", \"refine_fraction\": 0.2,"
               " \"coarsen_fraction\": 0, \"maximum_level\": 2, \"maximum_cells\": 2048,"
               " \"interval\": 1}}'");
  for (unsigned int i = 0; i < 3; ++i)
    EXPECT_LT(std::abs(refined[i].value - spectral[i].value),
              std::abs(fine[i].value - spectral[i].value))
      << names[i];
}
