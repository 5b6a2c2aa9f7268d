#include <feib/testing/plugins.h>
#include <feib/time_integrator.h>

#include <gtest/gtest.h>

TEST(MyScheme, IsMade)
{
  EXPECT_NO_THROW(feib::testing::registry().create<feib::TimeIntegrator<2>>("my_scheme"));
  EXPECT_NO_THROW(feib::testing::registry().create<feib::TimeIntegrator<3>>("my_scheme"));
}
