#include <feib/testing/structure_force_kit.h>

// Its load is the derivative of its energy, and so on.
FEIB_TEST_STRUCTURE_FORCE("my_force");
