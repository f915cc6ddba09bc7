// libFuzzer over the JSON reader: scripts/fuzz json SECONDS
#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    clerestory::test::fuzzJson({data, size});
    return 0;
}
