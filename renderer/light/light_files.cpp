// Layout of a file: header, EdgeLengths::small, SurfaceLight::firstOfInstance,
// SurfaceLight::values, SurfaceLight::emitters, LightGrid::values.
#include "light/light_files.h"

#include "light/division.h"
#include "scene/cache_file.h"
#include "scene/hash.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

namespace clerestory::light {
namespace {

constexpr const char* kExtension = ".light";

struct Header {
    char magic[8] = {'C', 'L', 'L', 'I', 'G', 'H', 'T', '\0'};
    std::uint32_t version = 8;
    std::uint32_t revision = 0;
    std::uint64_t key = 0;
    std::uint64_t meshes = 0;  // a hash of the refined ones, whose vertices have the values
    std::uint64_t instances = 0, values = 0, emitters = 0;
    glm::dvec3 gridFirst{0.0}, gridSpacing{1.0};
    glm::uvec3 gridCount{0u};
    std::uint32_t bodies = 0;                    // EdgeLengths::small
    double commonEdge = 0.0, edgePerSize = 0.0;  // its other members
    std::uint64_t checksum = 0;                  // of everything, with this field 0
};
static_assert(sizeof(Header) == 144);

// Without unused bytes.
struct StoredBody {
    glm::vec3 min{0.0f}, max{0.0f};
    double size = 0.0;
    std::uint64_t instance = 0;
};
static_assert(sizeof(StoredBody) == 40);

// rest: everything after the header, list by list.
std::uint64_t checksumOf(Header header, std::initializer_list<std::span<const std::byte>> rest) {
    header.checksum = 0;
    std::uint64_t hash = hashOfBytes(std::as_bytes(std::span(&header, 1)));
    for (const std::span<const std::byte> list : rest) hash = hashOfBytes(list, hash);
    return hash;
}

std::vector<StoredBody> stored(const std::vector<EdgeLengths::Body>& bodies) {
    std::vector<StoredBody> list;
    for (const EdgeLengths::Body& b : bodies) {
        list.push_back({b.box.min, b.box.max, b.size, b.instance});
    }
    return list;
}

std::uint64_t hashOfMeshes(const Scene& scene) {
    return hashOfBytes(std::as_bytes(std::span(scene.indices)),
                       hashOfBytes(std::as_bytes(std::span(scene.vertices))));
}

// Every vertex of an instance with light has a value. Finds SurfaceLight::moving.
bool belongs(SurfaceLight& light) {
    const Scene& scene = *light.scene;
    if (light.firstOfInstance.size() != scene.instances.size() || light.values.empty()) {
        return false;
    }
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::int64_t first = light.firstOfInstance[i];
        if (first == kNoLight) continue;
        if (isConstant(first)) {
            if (constantValue(first) != light.moving.size() + 1) return false;
            light.moving.push_back(static_cast<std::uint32_t>(i));
            continue;
        }
        const VertexRange range = vertexRange(scene, scene.meshes[scene.instances[i].mesh]);
        if (first + range.first < 0 || first + std::int64_t{range.first} + range.count >
                                           static_cast<std::int64_t>(light.values.size())) {
            return false;
        }
    }
    return light.moving.size() < light.values.size() &&
           (light.moving.empty() || light.grid.points() > 0);
}

}  // namespace

std::filesystem::path LightFiles::fileOf(std::uint64_t key) const {
    return options_.folder /
           (hashWordOf(options_.version + '\n' + std::to_string(key)) + kExtension);
}

std::optional<SurfaceLight> LightFiles::find(std::uint64_t key, const Refine& refine) const {
    if (options_.folder.empty()) return std::nullopt;
    const auto content = readCacheFile(fileOf(key), options_.maxBytes);
    Header header;
    const Header expected;
    if (!content || content->size < sizeof header) return std::nullopt;
    std::memcpy(&header, content->bytes.get(), sizeof header);
    const auto rest = content->span().subspan(sizeof header);
    LightGrid grid{header.gridFirst, header.gridSpacing, header.gridCount, {}};
    const glm::uvec3 cells = grid.count;
    constexpr std::size_t kMaxEntries = 1u << 30;  // of each list
    if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 ||
        header.version != expected.version || header.key != key || header.instances > kMaxEntries ||
        header.values > kMaxEntries || (header.emitters != 0 && header.emitters != header.values) ||
        std::max({cells.x, cells.y, cells.z}) > 1024u) {
        return std::nullopt;
    }
    const std::size_t sizes[] = {
        header.bodies * sizeof(StoredBody), header.instances * sizeof(std::int32_t),
        header.values * sizeof(LightValue), header.emitters * sizeof(EmittersValue),
        grid.points() * sizeof(LightValue)};
    if (std::accumulate(std::begin(sizes), std::end(sizes), std::size_t{0}) != rest.size()) {
        return std::nullopt;
    }
    std::span<const std::byte> lists[5];
    for (std::size_t i = 0, at = 0; i < 5; at += sizes[i++]) lists[i] = rest.subspan(at, sizes[i]);
    if (header.checksum != checksumOf(header, {lists[0], lists[1], lists[2], lists[3], lists[4]})) {
        return std::nullopt;
    }
    const auto read = [](std::span<const std::byte> bytes, auto& list) {
        list.resize(bytes.size() / sizeof list[0]);
        if (!bytes.empty()) std::memcpy(list.data(), bytes.data(), bytes.size());
    };
    SurfaceLight light{.key = key, .revision = header.revision, .share = 1.0};
    light.edges = {header.commonEdge, {}, header.edgePerSize};
    std::vector<StoredBody> bodies;
    read(lists[0], bodies);
    for (const StoredBody& b : bodies) {
        light.edges.small.push_back(
            {{b.min, b.max}, b.size, static_cast<std::uint32_t>(b.instance)});
    }
    read(lists[1], light.firstOfInstance);
    read(lists[2], light.values);
    read(lists[3], light.emitters);
    read(lists[4], grid.values);
    light.grid = std::move(grid);
    light.scene = refine(light.edges);
    if (header.meshes != hashOfMeshes(*light.scene) || !belongs(light)) return std::nullopt;
    return light;
}

void LightFiles::store(const SurfaceLight& light) {
    if (options_.folder.empty()) return;
    const std::vector<StoredBody> small = stored(light.edges.small);
    const auto bodies = std::as_bytes(std::span(small));
    const auto first = std::as_bytes(std::span(light.firstOfInstance));
    const auto values = std::as_bytes(std::span(light.values));
    const auto emitters = std::as_bytes(std::span(light.emitters));
    Header header;
    header.revision = light.revision;
    header.key = light.key;
    header.meshes = hashOfMeshes(*light.scene);
    header.instances = light.firstOfInstance.size();
    header.values = light.values.size();
    header.emitters = light.emitters.size();
    header.gridFirst = light.grid.first;
    header.gridSpacing = light.grid.spacing;
    header.gridCount = light.grid.count;
    const auto gridValues = std::as_bytes(std::span(light.grid.values));
    header.bodies = static_cast<std::uint32_t>(small.size());
    header.commonEdge = light.edges.common;
    header.edgePerSize = light.edges.perSize;
    header.checksum = checksumOf(header, {bodies, first, values, emitters, gridValues});
    if (writeCacheFile(fileOf(light.key), {std::as_bytes(std::span(&header, 1)), bodies, first,
                                           values, emitters, gridValues})) {
        failureReported_ = false;
        return trimCacheFolder(options_.folder, kExtension, options_.maxBytes);
    }
    if (failureReported_.exchange(true) || !options_.reportFailure) return;
    options_.reportFailure("Light cannot be stored in \"" + options_.folder.string() +
                           "\": " + std::strerror(errno));
}

}  // namespace clerestory::light
