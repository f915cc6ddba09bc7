#include "tests/fuzz/targets.h"

#include "scene/builtin/builtin_scenes.h"
#include "scene/classification.h"
#include "scene/import/scene_blob.h"
#include "scene/scene.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cmath>

namespace clerestory::test {
namespace {

std::string blobOf(const Scene& scene) {
    std::string blob;
    writeScene(scene, [&](const void* bytes, std::size_t count) {
        blob.append(static_cast<const char*>(bytes), count);
    });
    return blob;
}

std::span<const std::byte> bytesOf(const std::string& text) {
    return std::as_bytes(std::span(text));
}

constexpr std::size_t kChecksum = sizeof(std::uint64_t);

// The parts that no mutation may be asked to guess.
const std::string& header() {
    static const std::string bytes = [] {
        const std::string empty = blobOf(Scene{});
        return empty.substr(0, 16);
    }();
    return bytes;
}

std::string completed(Bytes content) {
    std::string blob = header();
    blob.append(reinterpret_cast<const char*>(content.data()), content.size());
    const std::uint64_t checksum = XXH3_64bits(blob.data(), blob.size());
    blob.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
    return blob;
}

void requireFinite(const Bounds& box) {
    if (box.empty()) return;
    for (int i = 0; i < 3; ++i) {
        require(std::isfinite(box.min[i]) && std::isfinite(box.max[i]), "boxes are finite");
    }
}

// What everybody does who trusts a scene that was checked.
void use(const Scene& scene) {
    for (const double time : {0.0, 0.7}) {
        const Pose pose = poseAt(scene, time);
        requireFinite(worldBounds(scene, pose));
        requireFinite(lastingBounds(scene, pose));
    }
    const DefaultView view = defaultView(scene);
    require(std::isfinite(view.position.x) && std::isfinite(view.target.x), "the view is finite");
    require(surfacesOf(scene).size() <= scene.instances.size() * (1 + scene.flatParts.size()),
            "there are no more surfaces than instances have parts");
    triangleCount(scene);
    const Scene again = readScene(bytesOf(blobOf(scene)));
    require(blobOf(again) == blobOf(scene), "what was read is written as it was");
}

}  // namespace

void fuzzBlob(Bytes content) {
    const std::string blob = completed(content);
    try {
        readScene({reinterpret_cast<const std::byte*>(content.data()), content.size()});
    } catch (const BlobError&) {
    }
    try {
        const Scene scene = readScene(bytesOf(blob));
        if (sceneProblems(scene).empty()) use(scene);
    } catch (const BlobError&) {
    }
}

std::vector<std::string> blobSeeds() {
    std::vector<std::string> seeds;
    Scene box = makeBuiltinScene("six-walls").value();
    Scene nothing;
    nothing.environment = "white";
    Scene moving = box;
    moving.movingNodes.push_back({.node = 0});
    moving.clips.push_back({.name = "swing",
                            .duration = 1.0,
                            .tracks = {{.moved = Moved::translation,
                                        .target = 0,
                                        .times = {0.0f, 1.0f},
                                        .values = {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f}}}});
    for (const Scene* scene : {&nothing, &box, &moving}) {
        const std::string blob = blobOf(*scene);
        seeds.push_back(blob.substr(header().size(), blob.size() - header().size() - kChecksum));
    }
    return seeds;
}

}  // namespace clerestory::test
