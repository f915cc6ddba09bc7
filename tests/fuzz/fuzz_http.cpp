// libFuzzer over the HTTP guard: scripts/fuzz http SECONDS
#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    clerestory::test::fuzzHttp({data, size});
    return 0;
}
