// libFuzzer for the decoders of compressed files: scripts/fuzz webp|avif|ktx2|meshopt|draco SECONDS
#include "tests/fuzz/corpus.h"
#include "tests/fuzz/targets.h"

namespace {

std::string codec() {
    const char* name = std::getenv("CLERESTORY_CODEC");
    return name ? name : "";
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
    clerestory::test::plant(clerestory::test::codecSeeds(codec()), (*words)[*count - 1]);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const auto kTarget = clerestory::test::codecTarget(codec());
    kTarget({data, size});
    return 0;
}
