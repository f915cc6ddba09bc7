// libFuzzer for the HTTP request reader: scripts/fuzz http SECONDS
#include "tests/fuzz/corpus.h"
#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
    clerestory::test::plant(clerestory::test::httpSeeds(), (*words)[*count - 1]);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    clerestory::test::fuzzHttp({data, size});
    return 0;
}
