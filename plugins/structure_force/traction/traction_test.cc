// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/structure_force_kit.h>

FEIB_TEST_STRUCTURE_FORCE("traction");
