// SPDX-License-Identifier: LGPL-2.1-or-later
#include "source/run/swing_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

using namespace feib;

namespace
{
  /// What is said of forces on "body" in the plane after @p n steps, the last of them.
  SwingCheck::Worst
  after(const unsigned int n,
        const std::function<std::pair<double, double>(unsigned int)> &force,
        const double negligible = 1e-6)
  {
    SwingCheck check;
    Ledger ledger;
    for (unsigned int i = 0; i < n; ++i)
      {
        const auto [x, y] = force(i);
        ledger.add({{"power_body", 0.},
                    {"force_x_body", x},
                    {"force_y_body", y},
                    {"torque_z_body", 1e6 * (i % 2)}});
        check.add(ledger, negligible);
      }
    return check.worst();
  }

  double
  wave(const unsigned int i, const double steps)
  {
    return std::cos(2 * 3.14159265358979 * i / steps);
  }
} // namespace


TEST(SwingCheck, SaysWhatSwingsWithinFewSteps)
{
  const auto alternates = [](const unsigned int i) { return std::pair{2., i % 2 ? 3. : -3.}; };
  EXPECT_EQ(after(21, alternates).part, 0); // not for long
  EXPECT_EQ(after(30, alternates).name, "body");
  EXPECT_NEAR(after(30, alternates).part, 3 / std::hypot(2, 3), 1e-12);
  // One component, which passes its mean again and again.
  EXPECT_GT(after(60, [](const unsigned int i) { return std::pair{wave(i, 4.5), 0.}; }).part, .3);
  EXPECT_EQ(after(60, [](const unsigned int i) { return std::pair{wave(i, 12), 0.}; }).part, 0);
  EXPECT_EQ(after(60, [](const unsigned int i) { return std::pair{20 + wave(i, 2), 0.}; }).part, 0);
}

TEST(SwingCheck, IsSilentOfRoundOffAndOfWhatIsOver)
{
  const auto noise = [](const unsigned int i) { return std::pair{1e-9 * (i % 2), 0.}; };
  EXPECT_EQ(after(60, noise).part, 0);
  EXPECT_GT(after(60, noise, 1e-12).part, 0);
  // A jolt, and a swing that has died down.
  EXPECT_EQ(after(60,
                  [](const unsigned int i) {
                    return std::pair{i == 30 ? 5. : 0., 1.};
                  })
              .part,
            0);
  EXPECT_EQ(after(200,
                  [](const unsigned int i) {
                    return std::pair{1 + std::pow(.9, i) * wave(i, 2), 0.};
                  })
              .part,
            0);
}
