#include <feib/testing/coupling_operator_kit.h>

// In 2D and 3D, on refined meshes: (J^T f) . v = f . (J v), and entries() are those of J.
FEIB_TEST_COUPLING_OPERATOR("my_coupling")
