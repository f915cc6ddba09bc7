// libFuzzer for the JSON reader: scripts/fuzz json SECONDS
#include "tests/fuzz/corpus.h"
#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
    clerestory::test::plant(clerestory::test::jsonSeeds(), (*words)[*count - 1]);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    clerestory::test::fuzzJson({data, size});
    return 0;
}
