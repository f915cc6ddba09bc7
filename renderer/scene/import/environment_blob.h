// An EnvironmentMap as one flat run of bytes, as scene_blob.h has it of scenes.
#pragma once

#include "scene/environment.h"
#include "scene/import/scene_blob.h"

namespace clerestory {

void writeEnvironment(const EnvironmentMap& map, const BlobSink& sink);

// Without a name. Throws BlobError for anything but a whole map of sound texels.
EnvironmentMap readEnvironment(std::span<const std::byte> blob);

}  // namespace clerestory
