// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_constitutive_law_kit_h
#define feib_testing_constitutive_law_kit_h

#include <feib/testing/examples.h>
#include <feib/testing/law_declarations.h>
#include <feib/testing/law_requirements.h>

#include <string>
#include <tuple>

namespace feib::testing
{
  /// Each finding is a failure of the test.
  inline void
  expect_none(const Findings &findings)
  {
    for (const std::string &sentence : findings.sentences)
      ADD_FAILURE() << sentence;
  }


  /// What every constitutive law must keep. Include it in one source of a test program.
  class ConstitutiveLawKit
    : public ::testing::TestWithParam<std::tuple<std::string, LawRequirement>>
  {};

  TEST_P(ConstitutiveLawKit, Keeps)
  {
    const auto &[law, requirement] = GetParam();
    expect_none(findings_of(requirement, registry(), law));
  }

  class ConstitutiveLawExamples : public ::testing::TestWithParam<std::string>
  {};

  TEST_P(ConstitutiveLawExamples, EveryDimensionHasOne)
  {
    expect_none(check_examples(registry(), GetParam()));
  }

  TEST_P(ConstitutiveLawExamples, AreAsDeclared)
  {
    expect_none(check_declarations(registry(), GetParam()));
  }
} // namespace feib::testing

/// Runs the conformance kit for the law of that name.
#define FEIB_TEST_CONSTITUTIVE_LAW(name) FEIB_TEST_CONSTITUTIVE_LAW_(name, __LINE__)
#define FEIB_TEST_CONSTITUTIVE_LAW_(name, line) FEIB_TEST_CONSTITUTIVE_LAW__(name, line)
#define FEIB_TEST_CONSTITUTIVE_LAW__(law_, line)                                        \
  namespace feib::testing                                                               \
  {                                                                                     \
    INSTANTIATE_TEST_SUITE_P(Line##line,                                                \
                             ConstitutiveLawKit,                                        \
                             ::testing::Combine(::testing::Values(std::string(law_)),   \
                                                ::testing::ValuesIn(law_requirements)), \
                             [](const auto &info) {                                     \
                               return std::get<0>(info.param) + "_" +                   \
                                      std::get<1>(info.param).name;                     \
                             });                                                        \
    INSTANTIATE_TEST_SUITE_P(Line##line,                                                \
                             ConstitutiveLawExamples,                                   \
                             ::testing::Values(std::string(law_)),                      \
                             [](const auto &info) { return info.param; });              \
  }                                                                                     \
  static_assert(true, "")

#endif
