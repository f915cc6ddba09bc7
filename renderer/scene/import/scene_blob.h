// A Scene as one flat run of bytes, for handing it from the importing process to ours. Not a file
// format: both ends are the same program.
#pragma once

#include "scene/scene.h"

#include <cstddef>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

namespace clerestory {

struct BlobError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

using BlobSink = std::function<void(const void* bytes, std::size_t count)>;

// Calls the sink with the blob's parts in order; large arrays are handed over as they lie.
void writeScene(const Scene& scene, const BlobSink& sink);

// Throws BlobError for anything that writeScene() did not write whole; reads nothing out of range.
// The scene's own consistency is left to sceneProblems(). Its contentHash is counted here: nobody
// can pass a scene off as another.
Scene readScene(std::span<const std::byte> blob);

}  // namespace clerestory
