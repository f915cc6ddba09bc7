// Layout of a file: header, SurfaceLight::firstOfInstance, SurfaceLight::values.
#include "light/light_files.h"

#include "light/refinement.h"
#include "scene/cache_file.h"
#include "scene/hash.h"

#include <cerrno>
#include <cstring>
#include <span>

namespace clerestory::light {
namespace {

constexpr const char* kExtension = ".light";

struct Header {
    char magic[8] = {'C', 'L', 'L', 'I', 'G', 'H', 'T', '\0'};
    std::uint32_t version = 1;
    std::uint32_t revision = 0;
    std::uint64_t key = 0;
    std::uint64_t meshes = 0;  // a hash of the refined ones, whose vertices have the values
    std::uint64_t instances = 0, values = 0;
    std::uint64_t checksum = 0;  // of everything, with this field 0
};
static_assert(sizeof(Header) == 56);

std::uint64_t checksumOf(Header header, std::span<const std::byte> first,
                         std::span<const std::byte> values) {
    header.checksum = 0;
    return hashOfBytes(values,
                       hashOfBytes(first, hashOfBytes(std::as_bytes(std::span(&header, 1)))));
}

std::uint64_t hashOfMeshes(const Scene& scene) {
    return hashOfBytes(std::as_bytes(std::span(scene.indices)),
                       hashOfBytes(std::as_bytes(std::span(scene.vertices))));
}

// Every vertex of an instance with light has a value.
bool belongs(const SurfaceLight& light) {
    const Scene& scene = *light.scene;
    if (light.firstOfInstance.size() != scene.instances.size() || light.values.empty()) {
        return false;
    }
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::int64_t first = light.firstOfInstance[i];
        if (first == kNoLight) continue;
        const VertexRange range = vertexRange(scene, scene.meshes[scene.instances[i].mesh]);
        if (first + range.first < 0 || first + std::int64_t{range.first} + range.count >
                                           static_cast<std::int64_t>(light.values.size())) {
            return false;
        }
    }
    return true;
}

}  // namespace

std::filesystem::path LightFiles::fileOf(std::uint64_t key) const {
    return options_.folder /
           (hashWordOf(options_.version + '\n' + std::to_string(key)) + kExtension);
}

std::optional<SurfaceLight> LightFiles::find(std::uint64_t key,
                                             const std::shared_ptr<const Scene>& scene) const {
    if (options_.folder.empty()) return std::nullopt;
    const auto content = readCacheFile(fileOf(key), options_.maxBytes);
    Header header;
    const Header expected;
    if (!content || content->size < sizeof header) return std::nullopt;
    std::memcpy(&header, content->bytes.get(), sizeof header);
    const auto rest = content->span().subspan(sizeof header);
    if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 ||
        header.version != expected.version || header.key != key ||
        header.meshes != hashOfMeshes(*scene) ||
        header.instances > rest.size() / sizeof(std::int32_t) ||
        header.values > rest.size() / sizeof(LightValue) ||
        header.instances * sizeof(std::int32_t) + header.values * sizeof(LightValue) !=
            rest.size()) {
        return std::nullopt;
    }
    const auto first = rest.first(header.instances * sizeof(std::int32_t));
    const auto values = rest.subspan(first.size());
    if (header.checksum != checksumOf(header, first, values)) return std::nullopt;
    SurfaceLight light{.key = key, .revision = header.revision, .share = 1.0, .scene = scene};
    light.firstOfInstance.resize(header.instances);
    light.values.resize(header.values);
    std::memcpy(light.firstOfInstance.data(), first.data(), first.size());
    std::memcpy(light.values.data(), values.data(), values.size());
    if (!belongs(light)) return std::nullopt;
    return light;
}

void LightFiles::store(const SurfaceLight& light) {
    if (options_.folder.empty()) return;
    const auto first = std::as_bytes(std::span(light.firstOfInstance));
    const auto values = std::as_bytes(std::span(light.values));
    Header header;
    header.revision = light.revision;
    header.key = light.key;
    header.meshes = hashOfMeshes(*light.scene);
    header.instances = light.firstOfInstance.size();
    header.values = light.values.size();
    header.checksum = checksumOf(header, first, values);
    if (writeCacheFile(fileOf(light.key), {std::as_bytes(std::span(&header, 1)), first, values})) {
        failureReported_ = false;
        return trimCacheFolder(options_.folder, kExtension, options_.maxBytes);
    }
    if (failureReported_.exchange(true) || !options_.reportFailure) return;
    options_.reportFailure("Light cannot be stored in \"" + options_.folder.string() +
                           "\": " + std::strerror(errno));
}

}  // namespace clerestory::light
