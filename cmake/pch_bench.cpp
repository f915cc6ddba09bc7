// CMake precompiles the header for a target, and a target needs a source.
#include "pch_bench.h"
