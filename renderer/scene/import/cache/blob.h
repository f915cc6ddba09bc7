// A Scene or an EnvironmentMap as one flat sequence of bytes, for the transfer from the importing
// process and for the cache. Not an exchange format: only the same program reads it.
#pragma once

#include "scene/environment.h"
#include "scene/scene.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

namespace clerestory {

struct BlobError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

using BlobSink = std::function<void(const void* bytes, std::size_t count)>;

// Calls the sink with the parts of the blob, in order. Large arrays are passed without a copy.
void writeScene(const Scene& scene, const BlobSink& sink);

// Copies the next bytes of a blob to `to`. Throws if it cannot.
using BlobSource = std::function<void(void* to, std::size_t count)>;

// Throws BlobError unless the blob is the complete output of writeScene(). Reads `size` bytes at
// most. Does not check the scene's consistency: see sceneProblems(). The contentHash is computed
// here and not taken from the blob.
Scene readScene(const BlobSource& source, std::uint64_t size);
Scene readScene(std::span<const std::byte> blob);

void writeEnvironment(const EnvironmentMap& map, const BlobSink& sink);

// Without a name. Throws BlobError unless the blob is a complete map of valid texels.
EnvironmentMap readEnvironment(std::span<const std::byte> blob);

}  // namespace clerestory
