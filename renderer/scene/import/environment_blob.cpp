#include "scene/import/environment_blob.h"

#include "scene/import/import.h"

#include <cstring>

namespace clerestory {
namespace {

struct EnvironmentHeader {
    char magic[8] = {'C', 'L', 'E', 'N', 'V', 'M', 'A', 'P'};
    std::uint32_t version = 1;
    std::uint32_t faceSize = 0;
};

}  // namespace

void writeEnvironment(const EnvironmentMap& map, const BlobSink& sink) {
    EnvironmentHeader header;
    header.faceSize = map.faceSize;
    sink(&header, sizeof header);
    sink(map.texels.data(), map.texels.size() * sizeof(glm::vec3));
}

EnvironmentMap readEnvironment(std::span<const std::byte> blob) {
    EnvironmentHeader header, expected;
    if (blob.size() < sizeof header) throw BlobError("the environment map is cut short");
    std::memcpy(&header, blob.data(), sizeof header);
    expected.faceSize = header.faceSize;
    if (std::memcmp(&header, &expected, sizeof header) != 0 || header.faceSize == 0 ||
        header.faceSize > kLargestImportedFace) {
        throw BlobError("this is no environment map of this version");
    }
    EnvironmentMap map;
    map.faceSize = header.faceSize;
    const std::size_t texels = std::size_t{6} * map.faceSize * map.faceSize;
    if (blob.size() != sizeof header + texels * sizeof(glm::vec3)) {
        throw BlobError("the environment map has not the texels that it says");
    }
    map.texels.resize(texels);
    std::memcpy(map.texels.data(), blob.data() + sizeof header, texels * sizeof(glm::vec3));
    for (const glm::vec3& t : map.texels) {
        for (int c = 0; c < 3; ++c) {
            if (!(t[c] >= 0.0f && t[c] <= 65504.0f)) {
                throw BlobError("the environment map holds what is no light");
            }
        }
    }
    updateContentHash(map);
    return map;
}

}  // namespace clerestory
