// Runs the fuzz targets on a short, fixed list of mutations that is the same on every machine.
#include "tests/fuzz/targets.h"

#include <gtest/gtest.h>

#include <random>

namespace clerestory::test {
namespace {

// One of the changes that a fuzzer makes.
void mutate(std::string& text, std::mt19937& random, const std::vector<std::string>& seeds,
            std::size_t most) {
    const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
    const std::size_t at = below(text.size() + 1);
    switch (below(7)) {
        case 0:
            if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
            break;
        case 1:
            if (at < text.size()) text[at] = static_cast<char>(random());
            break;
        case 2:
            text.insert(at, 1, "\r\n :,\"{}[]%0\\"[below(13)]);
            break;
        case 3:
            text.erase(at, below(8) + 1);
            break;
        case 4:
            text.insert(at, text.substr(below(text.size()), below(64)));
            break;
        case 5: {
            const std::string& other = seeds[below(seeds.size())];
            text.insert(at, other.substr(below(other.size()), below(64)));
            break;
        }
        default: {
            static const char* const kWords[] = {
                "1e308",  "-1",       "Content-Length: ", "\r\n\r\n", "null",
                "[[[[[[", "HTTP/1.0", "\xff\xfe",         "1e999",    "99999999999999999999",
                "%00",    "true"};
            text.insert(at, kWords[below(std::size(kWords))]);
        }
    }
    if (text.size() > most) text.resize(most);
}

void over(const std::vector<std::string>& seeds, void (*target)(Bytes), int rounds,
          std::size_t most = 4096) {
    std::mt19937 random(20261121);
    for (int i = 0; i < rounds; ++i) {
        std::string text = seeds[static_cast<std::size_t>(i) % seeds.size()];
        for (int k = i % 6; k >= 0; --k) mutate(text, random, seeds, most);
        target({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    }
}

TEST(Mutations, HttpParsingIsIndependentOfChunks) {
    for (const std::string& seed : httpSeeds()) {
        fuzzHttp({reinterpret_cast<const std::uint8_t*>(seed.data()), seed.size()});
    }
    over(httpSeeds(), fuzzHttp, 20'000);
}

TEST(Mutations, JsonIsAValidRequestOrRejected) {
    for (const std::string& seed : jsonSeeds()) {
        fuzzJson({reinterpret_cast<const std::uint8_t*>(seed.data()), seed.size()});
    }
    over(jsonSeeds(), fuzzJson, 20'000);
}

TEST(Mutations, BlobsAreValidScenesOrRejected) {
    for (const std::string& seed : blobSeeds()) {
        fuzzBlob({reinterpret_cast<const std::uint8_t*>(seed.data()), seed.size()});
    }
    over(blobSeeds(), fuzzBlob, 20'000, 65536);
}

}  // namespace
}  // namespace clerestory::test
