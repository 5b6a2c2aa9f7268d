// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>

#include "core/components.h"

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>

using feib::ConstitutiveLaw;
using feib::testing::Spring;
using feib::testing::spring_schema;

#if defined(FEIB_TEST_a_good)

namespace
{
  /// A law that cannot be made, in the way that its stiffness chooses.
  template <int structure_dim, int dim>
  struct Failing : Spring<structure_dim, dim>
  {
    explicit Failing(const feib::Parameters &parameters)
      : Spring<structure_dim, dim>(parameters)
    {
      if (parameters.number("c") == 1)
        throw 1;
      if (parameters.number("c") == 2)
        throw std::runtime_error("the table is empty");
      if (parameters.number("c") == 3)
        parameters.number("not_in_the_schema");
      if (parameters.number("c") == 4)
        throw std::bad_alloc();
    }
  };

  /// A law that throws when its stress is asked for, in the way that its stiffness chooses.
  template <int structure_dim, int dim>
  struct ThrowingStress : Spring<structure_dim, dim>
  {
    using Matrix = typename Spring<structure_dim, dim>::Matrix;

    explicit ThrowingStress(const feib::Parameters &parameters)
      : Spring<structure_dim, dim>(parameters)
      , how(parameters.number("c"))
    {}

    void
    stress(const std::vector<Matrix> &, std::vector<Matrix> &) const override
    {
      if (how == 1)
        throw 1;
      if (how == 2)
        throw std::runtime_error("the table is empty");
      throw std::bad_alloc();
    }

    double how;
  };
} // namespace

FEIB_PLUGIN("a_good", "1.0", registry)
{
  registry.add<ConstitutiveLaw, ThrowingStress>("throwing_stress", spring_schema);
  registry.add<ConstitutiveLaw, Failing>("failing_law", spring_schema);
  registry.add<ConstitutiveLaw, Spring>("good_law", spring_schema);
}

#elif defined(FEIB_TEST_older_abi)

#undef FEIB_ABI
#define FEIB_ABI 0
FEIB_PLUGIN("older_abi", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("older_abi_law", spring_schema);
}

#elif defined(FEIB_TEST_other_build)

#undef FEIB_BUILD_TYPE
#ifdef DEBUG
#define FEIB_BUILD_TYPE "release"
#else
#define FEIB_BUILD_TYPE "debug"
#endif
FEIB_PLUGIN("other_build", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("other_build_law", spring_schema);
}

#elif defined(FEIB_TEST_other_headers)

#undef FEIB_HEADER_HASH
#define FEIB_HEADER_HASH "0123456789abcdef"
FEIB_PLUGIN("other_headers", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("other_headers_law", spring_schema);
}

#elif defined(FEIB_TEST_printing)

FEIB_PLUGIN("printing", "1.0", registry)
{
  std::printf("hello from ");
  std::cout << "the plugin\n" << std::string(1000000, '.');
  registry.add<ConstitutiveLaw, Spring>("printing_law", spring_schema);
}

#elif defined(FEIB_TEST_bad_name)

FEIB_PLUGIN("bad_name", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("bad-name-law", spring_schema);
}

#elif defined(FEIB_TEST_large_schema)

FEIB_PLUGIN("large_schema", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("large_schema_law",
                                        spring_schema + std::string(10000000, ' '));
}

#elif defined(FEIB_TEST_deep_schema)

FEIB_PLUGIN("deep_schema", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("deep_schema_law", std::string(1000000, '['));
}

#elif defined(FEIB_TEST_foreign_letters)

FEIB_PLUGIN("foreign_letters", "1.0", registry)
{
  std::string schema = spring_schema;
  schema.insert(schema.find("spring") + 1, "\xe4"); // Latin-1
  registry.add<ConstitutiveLaw, Spring>("foreign_letters_law", schema);
}

#elif defined(FEIB_TEST_small_description)

// What another program's plugins may be described by.
extern "C" __attribute__((visibility("default")))
const std::uint32_t feib_plugin[2] = {FEIB_ABI, 7};

#elif defined(FEIB_TEST_a_function)

extern "C" __attribute__((visibility("default"))) void
feib_plugin()
{}

#elif defined(FEIB_TEST_missing_symbol)

void a_function_nobody_wrote();

FEIB_PLUGIN("missing_symbol", "1.0", registry)
{
  a_function_nobody_wrote();
  registry.add<ConstitutiveLaw, Spring>("missing_symbol_law", spring_schema);
}

#elif defined(FEIB_TEST_duplicate)

FEIB_PLUGIN("duplicate", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("duplicate_law", spring_schema);
  registry.add<ConstitutiveLaw, Spring>("good_law", spring_schema);
}

#elif defined(FEIB_TEST_bad_schema)

FEIB_PLUGIN("bad_schema", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("bad_schema_law", spring_schema);
  registry.add<ConstitutiveLaw, Spring>("worse_schema_law", R"({
    "type": "object", "additionalProperties": false, "description": "A spring.",
    "properties": { "c": { "type": "number", "description": "Stiffness." } },
    "examples": [ {} ] })");
}

#elif defined(FEIB_TEST_throwing)

FEIB_PLUGIN("throwing", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("throwing_law", spring_schema);
  throw std::runtime_error("cannot find the licence key");
}

#elif defined(FEIB_TEST_throwing_int)

FEIB_PLUGIN("throwing_int", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("throwing_int_law", spring_schema);
  throw 7;
}

#elif defined(FEIB_TEST_ending)

// Ends the program in the way that a variable of the environment chooses.
namespace
{
  struct ThrowsAtOnce
  {
    ThrowsAtOnce()
    {
      const char *const variable = std::getenv("FEIB_TEST_END");
      if (variable != nullptr && std::string(variable) == "throw")
        throw std::runtime_error("a static object");
    }
  } throws_at_once;

  template <int structure_dim, int dim>
  struct Exiting : Spring<structure_dim, dim>
  {
    explicit Exiting(const feib::Parameters &parameters)
      : Spring<structure_dim, dim>(parameters)
    {
      std::exit(0);
    }
  };
} // namespace

FEIB_PLUGIN("ending", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Spring>("ending_law", spring_schema);
  const char *const variable = std::getenv("FEIB_TEST_END");
  const std::string how      = variable != nullptr ? variable : "";
  if (how == "exit")
    std::exit(0);
  else if (how == "quick_exit")
    std::quick_exit(0);
  else if (how == "terminate")
    std::terminate();
  else if (how == "when made")
    registry.add<ConstitutiveLaw, Exiting>("exiting_law", spring_schema);
  else if (!how.empty())
    std::raise(std::stoi(how));
}

#elif !defined(FEIB_TEST_no_plugin)

// Plain data with a hole.
[[maybe_unused]] static void
add_nothing(feib::Registry &)
{}

#if defined(FEIB_TEST_no_build_tag)
#define FEIB_TEST_DATA nullptr, "a", "1", &add_nothing
#elif defined(FEIB_TEST_no_name)
#define FEIB_TEST_DATA FEIB_BUILD_TAG, nullptr, "1", &add_nothing
#elif defined(FEIB_TEST_no_version)
#define FEIB_TEST_DATA FEIB_BUILD_TAG, "a", nullptr, &add_nothing
#elif defined(FEIB_TEST_no_function)
#define FEIB_TEST_DATA FEIB_BUILD_TAG, "a", "1", nullptr
#else
static char endless[1000] = {1, 2, 3};
__attribute__((constructor)) static void
fill()
{
  std::memset(endless, 'a', sizeof endless);
}
#define FEIB_TEST_DATA FEIB_BUILD_TAG, endless, "1", &add_nothing
#endif
extern "C" __attribute__((visibility("default")))
const FeibPlugin feib_plugin = {FEIB_ABI, FEIB_TEST_DATA};

#endif
