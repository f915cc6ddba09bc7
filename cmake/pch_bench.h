// Precompiled for the benchmarks.
#include "pch_base.h"
