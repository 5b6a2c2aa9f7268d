// SPDX-License-Identifier: LGPL-2.1-or-later
#include "kit_test.h"

#include <feib/testing/structure_force_kit.h>

// Without a fault the kit finds none.
FEIB_TEST_STRUCTURE_FORCE("wrong_force");

namespace
{
  using namespace feib::testing;

  /// All that is found about the force with a fault, on a closed curve.
  std::string
  findings(const std::string &fault)
  {
    StructureForceRequirements<2> requirements(registry());
    EXPECT_TRUE(requirements.attach("wrong_force",
                                    R"({"of": {"spring_network": {"stiffness": 2, "damping": 1}},
                                        "fault": ")" +
                                      fault + "\"}",
                                    "closed curve"))
      << requirements.refusal;
    std::string text;
    for (const std::string &sentence : requirements.check().sentences)
      text += sentence + "\n";
    return text;
  }

  void
  expect_found(const std::string &fault, const std::string &sentence)
  {
    const std::string found = findings(fault);
    EXPECT_NE(found.find(sentence), std::string::npos) << fault << ": " << found;
  }
} // namespace

TEST(StructureForceKitItself, NamesWhatIsWrong)
{
  EXPECT_EQ(findings("none"), "");
  expect_found("sign", "load() is not - d energy/dX");
  expect_found("factor", "load() is not - d energy/dX");
  expect_found("throws", "it throws: no load today");
  expect_found("derivative", "load_derivative() is not the derivative of load()");
  expect_found("entries", "tangent() does not hold the entries");
  expect_found("beyond", "tangent() has entries of nodes that are not there");
  expect_found("linear", "linear() is said of a load whose derivative depends on X");
  expect_found("not viscous", "viscous() is false, but there is a viscous_load()");
  expect_found("drives", "viscous_load() does not dissipate");
  expect_found("quadratic", "viscous_load() is not linear");
  expect_found("not external", "external() is false, but there is an external_load()");
  expect_found("soft", "stiffness() says less than");
  expect_found("forgets", "what a force remembers belongs into archive()");
}
