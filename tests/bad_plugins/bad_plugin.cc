// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>

#include "core/components.h"

using feib::ConstitutiveLaw;
using feib::testing::Spring;
using feib::testing::spring_schema;

#if defined(FEIB_TEST_a_good)

FEIB_PLUGIN("a_good", "1.0", registry)
{
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

#endif
