// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kit_test.h"

#include <feib/testing/constitutive_law_kit.h>

// Without a fault the kit finds none.
FEIB_TEST_CONSTITUTIVE_LAW("wrong_law");

namespace
{
  using namespace feib::testing;

  struct Fault
  {
    decltype(LawRequirement::check) check;
    const char *name, *sentence;
  };

  const ExpectNamed expect_named{"wrong_law",
                                 R"({"neo_hookean": {"shear_modulus": 1.5, "stress_free": true}})"};

  const ExpectNamed expect_named_of_viscous{
    "wrong_law",
    R"({"kelvin_voigt": {"viscosity": 0.3, "law": {"neo_hookean": {"shear_modulus": 1.5}}}})"};

  const ExpectNamed expect_named_of_softening{"wrong_law",
                                              R"({"mullins_damage": {"r": 1.5, "m": 0.4, "law":
        {"neo_hookean": {"shear_modulus": 1.5, "stress_free": true}}}})"};

  /// What a fault is found by, as a part of a test.
  auto
  requirement(const Fault &fault)
  {
    return [&fault](const std::string &law, const std::string &block) {
      expect_none(fault.check(registry(), law, block));
    };
  }
} // namespace

TEST(ConstitutiveLawKitItself, NamesWhatIsWrong)
{
  const std::vector<Fault> faults = {
    {check_stress, "sign", "P : dF is -1 times the change of W"},
    {check_stress, "factor two", "P : dF is 2 times the change of W"},
    {check_stress, "half the energy", "P : dF is 2 times the change of W"},
    {check_stress, "transposed", "P is not dW/dF"},
    {check_stress, "a term missing", "P is not dW/dF"},
    {check_stress, "no energy for it", "P is not dW/dF"},
    {check_stress, "infinite where stretched", "P is not dW/dF"},
    {check_stress, "throws", "the law has no value"},
    {check_stress, "one value too few", "one value for each point"},
    {check_stress_derivative, "derivative too stiff", "dP is not the derivative of P"},
    {check_stress_derivative, "derivative without a row", "dP is not the derivative of P"},
    {check_symmetry, "no energy, derivative right", "no second derivative of an energy"},
    {check_frame_indifference, "depends on the observer", "W(Q F) is not W(F)"},
    {check_frame_indifference, "stress of an observer", "P(Q F) is not Q P(F)"},
    {check_linear, "says it is linear", "linear() is true"},
    {check_domain, "says it is defined everywhere", "needs_positive_determinant()"},
    {check_resistance, "both negative", "W falls"},
    {check_rest, "not a number at rest", "W is not finite at F = I"},
    {check_rest, "not a number at rest, stress", "P is not finite at F = I"},
    {check_rest, "another when asked again", "W is another when it is asked for again"},
    {check_arrays, "depends on others", "the energy of a point depends on the points around it"},
    {check_time, "changes with time", "say so by time_dependent()"}};
  for (const Fault &fault : faults)
    expect_named(requirement(fault), fault.name, fault.sentence);

  const std::vector<Fault> viscous_faults = {
    {check_viscous_stress, "drives", "drives instead of damping"},
    {check_viscous_stress, "square of the rate", "is not linear in dF/dt"},
    {check_viscous_stress, "no potential", "P(A) : B is not P(B) : A"},
    {check_viscous_stress, "resists rotation", "resists a rotation of the whole"},
    {check_viscous_stress, "damping of an observer", "depends on how the observer stands"},
    {check_viscous_stress, "viscous unsaid", "say so by viscous()"}};
  for (const Fault &fault : viscous_faults)
    expect_named_of_viscous(requirement(fault), fault.name, fault.sentence);

  const std::vector<Fault> state_faults = {
    {check_state, "counts the state twice", "is it counted twice?"},
    {check_state, "state gives energy", "the energy grows when the state moves on"},
    {check_state, "state another when asked again", "the state is another when it is asked"}};
  for (const Fault &fault : state_faults)
    expect_named_of_softening(requirement(fault), fault.name, fault.sentence);

  for (const LawRequirement &asked : law_requirements)
    {
      bool seen = false;
      for (const auto *const list : {&faults, &viscous_faults, &state_faults})
        for (const Fault &fault : *list)
          seen = seen || fault.check == asked.check;
      EXPECT_TRUE(seen) << asked.name << " was never seen to fail";
    }
}

TEST(ShippedLaws, DeclareHowTheyBehave)
{
  const feib::Schema complete(R"({"required": ["declares"], "properties": {"declares":
    {"required": ["stress_free", "resists_collapse", "rank_one_convex"]}}})");
  unsigned int n_laws = 0;
  for (const auto &entry : feib::testing::registry().entries())
    if (entry.kind == std::string("constitutive_law") && entry.name != "wrong_law")
      {
        EXPECT_TRUE(complete.accepts(entry.schema)) << entry.name;
        ++n_laws;
      }
  EXPECT_GT(n_laws, 0u);
}
