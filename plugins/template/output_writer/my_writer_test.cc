#include <feib/testing/output_writer_kit.h>

// It goes on with its files, misses those that are gone, says what cannot be written.
FEIB_TEST_OUTPUT_WRITER("my_writer");
