#include <feib/testing/constitutive_law_kit.h>

// For each example of the schema and all dimensions: P = dW/dF, dP = dP/dF, rotations, ...
FEIB_TEST_CONSTITUTIVE_LAW("my_law");
