#include <feib/testing/time_integrator_kit.h>

// Energy and momentum balance, the order is 1, steps can be undone, checkpoints, ranks.
FEIB_TEST_TIME_INTEGRATOR("my_scheme", 1);
