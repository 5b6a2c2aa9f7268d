// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_examples_h
#define feib_testing_examples_h

#include <feib/case.h>
#include <feib/schema.h>
#include <feib/testing/plugins.h>

#include <gtest/gtest.h>

#include <string>

namespace feib::testing
{
  /// Calls @p check with each example of the schema of a component, JSON. That there is none of
  /// this name, or no example, is a failure of the test.
  template <class Interface, typename Check>
  void
  for_each_example(const std::string &name, const Check &check)
  {
    for (const Registry::Entry &entry : registry().entries())
      if (entry.kind == Interface::kind && entry.name == name)
        {
          const auto examples = Schema(entry.schema).examples();
          EXPECT_FALSE(examples.empty()) << "the schema of " << name << " gives no example";
          for (const std::string &example : examples)
            {
              SCOPED_TRACE(name + " " + example);
              check(example);
            }
          return;
        }
    ADD_FAILURE() << "there is no " << Interface::kind << " " << name;
  }

  /// The block of an output writer ("output") or refinement strategy ("refinement") with all
  /// defaults.
  inline Parameters
  filled_block(const std::string &place, const std::string &name, const std::string &block)
  {
    const std::string component = "{\"" + name + "\": " + block + "}";
    const Case description(R"({"dimension": 2, "domain": {"cells": [1, 1]}, "fluid":
                             {"navier_stokes": {"density": 1, "viscosity": 1}},
                             "time": {"step": 1, "end": 1}, ")" +
                             place +
                             "\": " + (place == "output" ? "[" + component + "]" : component) + "}",
                           "kit",
                           registry());
    return (place == "output" ? description.parameters().children(place)[0]
                              : description.parameters().child(place))
      .choice()
      .second;
  }
} // namespace feib::testing

#endif
