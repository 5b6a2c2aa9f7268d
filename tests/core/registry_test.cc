// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components.h"

#include <gtest/gtest.h>

using namespace feib;
using namespace feib::testing;

namespace
{
  std::string
  message_of(const std::function<void()> &action)
  {
    try
      {
        action();
      }
    catch (const Error &error)
      {
        return error.what();
      }
    return "";
  }
} // namespace

TEST(Registry, BuildsAComponentFromItsBlock)
{
  const Registry registry = small_registry();
  const auto law          = registry.create<ConstitutiveLaw<2, 3>>("spring", R"j({"c": 4})j");

  using Matrix = ConstitutiveLaw<2, 3>::Matrix;
  Matrix F;
  F[0][0] = 1;
  F[2][1] = 2;
  std::vector<double> W(1);
  law->energy({F}, W);
  EXPECT_DOUBLE_EQ(W[0], 10);
}

TEST(Registry, BuildsSlotsAndTheirDefaults)
{
  const Registry registry = small_registry();
  const auto law =
    registry.create<ConstitutiveLaw<1, 2>>("scaled",
                                           R"j({"factor": 2, "law": {"scaled": {"factor": 5}}})j");
  std::vector<double> W(1);
  ConstitutiveLaw<1, 2>::Matrix F;
  F[0][0] = 1;
  law->energy({F}, W);
  EXPECT_DOUBLE_EQ(W[0], 2 * 5 * 3 / 2.); // the default law of the inner one is a spring with c = 3
}

TEST(Registry, SaysWhatIsWrongWithABlock)
{
  const Registry registry = small_registry();
  try
    {
      registry.create<ConstitutiveLaw<2, 2>>("spring", R"j({"c": -1, "d": 2})j");
      FAIL();
    }
  catch (const Error &error)
    {
      ASSERT_EQ(error.issues().size(), 2u);
      EXPECT_EQ(error.issues()[0].pointer, "/c");
      EXPECT_EQ(error.issues()[0].message, "must be greater than 0, found -1");
      EXPECT_EQ(error.issues()[1].pointer, "/d");
    }
}

TEST(Registry, NamesWhatItHasInsteadOfAnUnknownComponent)
{
  const Registry registry = small_registry();
  const std::string message =
    message_of([&] { registry.create<ConstitutiveLaw<2, 2>>("sprung", "{}"); });
  EXPECT_EQ(
    message,
    "no plugin provides the constitutive_law \"sprung\"; available are \"scaled\", \"spring\"");
}

TEST(Registry, RefusesASecondComponentOfTheSameName)
{
  Registry registry = small_registry();
  EXPECT_EQ(message_of([&] { registry.add<ConstitutiveLaw, Spring>("spring", spring_schema); }),
            "the constitutive_law \"spring\" exists already");
  EXPECT_NE(message_of([&] { registry.add<ConstitutiveLaw, Spring>("a b", spring_schema); }), "");
}

TEST(Registry, ATransactionAddsAllOrNothing)
{
  Registry registry        = small_registry();
  const std::size_t before = registry.entries().size();
  EXPECT_THROW(registry.transaction("twice",
                                    "twice.feib.so",
                                    [](Registry &registry) {
                                      registry.add<ConstitutiveLaw, Spring>("new", spring_schema);
                                      registry.add<ConstitutiveLaw, Spring>("spring",
                                                                            spring_schema);
                                    }),
               Error);
  EXPECT_EQ(registry.entries().size(), before);

  registry.transaction("once", "once.feib.so", [](Registry &registry) {
    registry.add<ConstitutiveLaw, Spring>("new", spring_schema);
  });
  ASSERT_EQ(registry.entries().size(), before + 1);
  EXPECT_EQ(registry.entries()[0].name, "new");
  EXPECT_EQ(registry.entries()[0].plugin, "once");
  EXPECT_EQ(registry.entries()[0].origin, "once.feib.so");
  EXPECT_EQ(registry.entries()[1].origin, "");
  EXPECT_NE(message_of([&] {
              registry.add<ConstitutiveLaw, Spring>("new", spring_schema);
            }).find("from once.feib.so"),
            std::string::npos);
}

TEST(Parameters, MisuseIsAProgrammersError)
{
  const Registry registry = small_registry();
  const auto fluid =
    registry.create<fluid_solver_interface<2>>("stokes",
                                               R"j({"viscosity": 2, "probes": [{"at": 1}]})j");
  const Parameters &p = fluid->parameters;

  EXPECT_EQ(p.number("viscosity"), 2);
  EXPECT_EQ(p.integer("sweeps"), 2);
  EXPECT_EQ(p.boolean("steady"), false);
  EXPECT_EQ(p.string("convection"), "none");
  EXPECT_EQ(p.child("solver").number("tolerance"), 1e-10);
  EXPECT_EQ(p.child("solver").pointer(), "/solver");
  ASSERT_EQ(p.children("probes").size(), 1u);
  EXPECT_EQ(p.children("probes")[0].number("weight"), 0.5);
  EXPECT_EQ(p.children("probes")[0].pointer(), "/probes/0");
  EXPECT_FALSE(p.has("force"));

  EXPECT_THROW(p.number("force"), std::logic_error);
  EXPECT_THROW(p.number("convection"), std::logic_error);
  EXPECT_THROW(p.integer("viscosity_"), std::logic_error);
  EXPECT_THROW(p.string("viscosity"), std::logic_error);
  EXPECT_THROW(p.child("viscosity"), std::logic_error);
  EXPECT_THROW(p.children("solver"), std::logic_error);
  EXPECT_THROW(p.choice(), std::logic_error);
  EXPECT_THROW(p.fail("solver/tolerance", "is odd"), Error);
}

TEST(Parameters, ExpressionsAreTexts)
{
  const Registry registry = small_registry();
  const auto fluid        = registry.create<fluid_solver_interface<3>>(
    "stokes", R"j({"viscosity": 1, "force": [0.1, "sin(x)", 1e-20]})j");
  EXPECT_EQ(fluid->parameters.expressions("force"),
            (std::vector<std::string>{"0.1", "sin(x)", "1e-20"}));
  EXPECT_EQ(fluid->parameters.expressions("viscosity"), (std::vector<std::string>{"1"}));
}

TEST(Parameters, AnIntegerTooLargeIsTheUsersError)
{
  const Registry registry = small_registry();
  EXPECT_THROW(registry.create<fluid_solver_interface<2>>(
                 "stokes", R"j({"viscosity": 1, "sweeps": 3000000000})j"),
               Error);
}
