// libFuzzer over the reader of scene blobs: scripts/fuzz blob SECONDS
#include "tests/fuzz/targets.h"

#include <fstream>

// Begins with scenes, which mutations of nothing would hardly become: into the corpus, which is the
// last word of the command line.
extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
    const std::string folder = (*words)[*count - 1];
    int number = 0;
    for (const std::string& seed : clerestory::test::blobSeeds()) {
        std::ofstream(folder + "/seed" + std::to_string(number++), std::ios::binary) << seed;
    }
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    clerestory::test::fuzzBlob({data, size});
    return 0;
}
