#include <feib/testing/refinement_strategy_kit.h>

// It comes to rest, follows structures, keeps to its levels, goes on from checkpoints.
FEIB_TEST_REFINEMENT_STRATEGY("my_refinement");
