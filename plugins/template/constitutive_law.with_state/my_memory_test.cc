#include <feib/testing/constitutive_law_kit.h>

// For each example of the schema and all dimensions: P = dW/dF, that the state moves on once and
// dissipates, ...
FEIB_TEST_CONSTITUTIVE_LAW("my_memory");
