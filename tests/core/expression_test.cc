// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components.h"

#include <feib/case.h>
#include <feib/expression.h>

#include <gtest/gtest.h>

#include <cmath>

using namespace feib;
using namespace feib::testing;

namespace
{
  /// The block of the fluid of a case with the body force @p force (JSON).
  struct Force
  {
    explicit Force(const std::string &force, const std::string &constants = "{}")
      : registry(small_registry())
      , description(small_case,
                    "case.json",
                    registry,
                    {{"/constants", constants}, {"/fluid/stokes/force", force}})
      , block(description.parameters().child("fluid").child("stokes"))
    {}

    template <int dim>
    double
    value(const unsigned int component,
          const dealii::Point<dim> &p,
          const double t            = 0,
          const Variables variables = Variables::space_time) const
    {
      const auto function =
        parse_expressions<dim>(block, "force", block.expressions("force").size(), variables);
      function->set_time(t);
      dealii::Vector<double> all(function->n_components);
      function->vector_value(p, all);
      EXPECT_EQ(all[component], function->value(p, component));
      return all[component];
    }

    std::string
    problem(const unsigned int n = 2, const Variables variables = Variables::space_time) const
    {
      try
        {
          parse_expressions<2>(block, "force", n, variables);
        }
      catch (const Error &error)
        {
          return error.what();
        }
      return "";
    }

    const Registry registry;
    const Case description;
    const Parameters block;
  };
} // namespace

TEST(Expression, VariablesConstantsAndFunctions)
{
  const dealii::Point<2> p(0.3, 0.7);
  EXPECT_DOUBLE_EQ(Force(R"j(["x + 2*y - t", 4])j").value(0, p, 0.5), 0.3 + 1.4 - 0.5);
  EXPECT_DOUBLE_EQ(Force(R"j(["x", 4])j").value(1, p), 4);
  EXPECT_DOUBLE_EQ(Force(R"j(["sin(pi*x)^2 + log(e)", 0])j").value(0, p),
                   std::pow(std::sin(M_PI * .3), 2) + 1);
  EXPECT_DOUBLE_EQ(Force(R"j(["mu*x", 0])j", R"j({"mu": 5})j").value(0, p), 1.5);
  EXPECT_DOUBLE_EQ(Force(R"j(["if(x < 0.5, 1, 2) + (y < 0.5 ? 10 : 20)", 0])j").value(0, p), 21);
  EXPECT_DOUBLE_EQ(
    Force(R"j(["min(x, y) + max(x, y) + abs(-1) + sqrt(4) + exp(0) + x^2", 0])j").value(0, p),
    5.09);
  EXPECT_DOUBLE_EQ(Force(R"j(["mod(-x, 1) + floor(1.5) + ceil(1.5) + pow(2, 3)", 0])j").value(0, p),
                   11.7);
  EXPECT_DOUBLE_EQ(Force(R"j(["z", 0, 0])j").value(0, dealii::Point<3>(1, 2, 3)), 3);
  EXPECT_DOUBLE_EQ(Force(R"j(["s1 + 10*s2", 0])j").value(0, p, 0, Variables::reference), 7.3);
}

TEST(Expression, SaysWhatCannotBeRead)
{
  EXPECT_EQ(
    Force(R"j(["x", "2*foo + 1"])j", R"j({"mu": 1})j").problem(),
    "/fluid/stokes/force/1: the expression \"2*foo + 1\" cannot be read: Unexpected token \"foo\" "
    "found at position 2; variables and constants are x, y, t, e, mu, pi");
  EXPECT_NE(Force(R"j(["x +", 0])j").problem().find("/fluid/stokes/force/0: "), std::string::npos);
  EXPECT_NE(Force(R"j(["", 0])j").problem(), "");
  EXPECT_NE(Force(R"j(["sin(x", 0])j").problem(), "");
  EXPECT_NE(Force(R"j(["x = 3", 0])j").problem(), "");
  EXPECT_NE(Force(R"j(["x, y", 0])j").problem(), "");
  EXPECT_NE(Force(R"j(["z", 0])j").problem(), "") << "there is no z in two dimensions";
  EXPECT_NE(Force(R"j(["x", 0])j").problem(2, Variables::reference), "");
  EXPECT_NE(Force(R"j(["s1", 0])j").problem(), "");
  EXPECT_EQ(Force(R"j(["x", 0])j").problem(3),
            "/fluid/stokes/force: must have 3 expressions, found 2");
  EXPECT_EQ(Force(R"j(["x >= 1 && y == 2 && x <= 3 && x != 4", 0])j").problem(), "");
}

TEST(Expression, DependenceOnTime)
{
  EXPECT_TRUE(depends_on_time(Force(R"j([0, "sin(2*t)"])j").block, "force"));
  EXPECT_FALSE(depends_on_time(Force(R"j([0, "tan(x)"])j").block, "force"));
}
