// libFuzzer for the reader of scene blobs: scripts/fuzz blob SECONDS
#include "tests/fuzz/corpus.h"
#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
    clerestory::test::plant(clerestory::test::blobSeeds(), (*words)[*count - 1]);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    clerestory::test::fuzzBlob({data, size});
    return 0;
}
