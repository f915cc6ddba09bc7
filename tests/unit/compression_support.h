// Shared by the tests of compressed glTF files: import from memory, comparison of two scenes, and
// damaged copies of a stream.
#pragma once

#include "tests/support/glb_builder.h"
#include "tests/unit/import_support.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <random>
#include <string>

namespace clerestory::test {

inline Scene importedGlb(const std::string& glb, const ImportLimits& limits = {}) {
    const TemporaryFolder folder;
    return importSceneInProcess(folder.write("scene.glb", glb), limits);
}

// The error of importing a file that must fail, "reason: message".
inline std::string errorOf(const std::string& glb, const ImportLimits& limits = {}) {
    try {
        importedGlb(glb, limits);
    } catch (const ImportError& error) {
        return std::string(nameOf(error.reason())) + ": " + error.what();
    }
    return "was imported";
}

// Largest differences of the vertices; the meshes must have the same triangles.
struct Difference {
    float position = 0.0f, normal = 0.0f, texCoord = 0.0f, color = 0.0f;
};

inline Difference difference(const Scene& a, const Scene& b) {
    Difference most;
    EXPECT_EQ(a.indices, b.indices);
    EXPECT_EQ(a.vertices.size(), b.vertices.size());
    for (std::size_t i = 0; i < std::min(a.vertices.size(), b.vertices.size()); ++i) {
        const Vertex &x = a.vertices[i], &y = b.vertices[i];
        most.position = std::max(most.position, glm::distance(x.position, y.position));
        most.normal = std::max(most.normal, glm::distance(x.normal, y.normal));
        most.texCoord = std::max(most.texCoord, glm::distance(x.texCoord0, y.texCoord0));
        most.color = std::max(most.color, glm::distance(x.color, y.color));
    }
    return most;
}

// Truncates the stream or changes some of its bytes, depending on the seed.
inline std::string damagedStream(std::string bytes, unsigned seed) {
    std::mt19937 random(seed);
    if (bytes.empty() || seed % 4 == 0) {
        bytes.resize(bytes.empty() ? 0 : random() % bytes.size());
        return bytes;
    }
    for (unsigned times = 1 + seed % 5; times > 0; --times) {
        bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    return bytes;
}

// Each damaged stream gives a valid scene or an ImportError; every other exception fails the test.
// `file` places a stream in a file.
inline void expectNoCrash(const std::string& stream, unsigned seeds,
                          const std::function<std::string(const std::string&)>& file) {
    unsigned errors = 0;
    for (unsigned seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(seed);
        try {
            EXPECT_TRUE(sceneProblems(importedGlb(file(damagedStream(stream, seed)))).empty());
        } catch (const ImportError& error) {
            ++errors;
            EXPECT_LT(std::string(error.what()).size(), 300u);
        }
    }
    EXPECT_GT(errors, 0u);
}

// Milliseconds of an import in this process, the best of five.
inline double importMilliseconds(const std::filesystem::path& file) {
    double best = 1e9;
    for (int i = 0; i < 5; ++i) {
        const auto start = std::chrono::steady_clock::now();
        importSceneInProcess(file);
        const std::chrono::duration<double, std::milli> took =
            std::chrono::steady_clock::now() - start;
        best = std::min(best, took.count());
    }
    return best;
}

// Prints the times of the same surface with and without compression.
inline void reportLoadTimes(const char* codec, const std::string& compressed,
                            const std::string& plain) {
    const TemporaryFolder folder;
    const double with = importMilliseconds(folder.write("compressed.glb", compressed));
    const double without = importMilliseconds(folder.write("plain.glb", plain));
    std::cout << codec << ": " << with << " ms, without compression " << without << " ms; "
              << compressed.size() << " bytes, without compression " << plain.size() << "\n";
}

}  // namespace clerestory::test
