// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/coupling_operator_kit.h>

FEIB_TEST_COUPLING_OPERATOR("divergence_free")
