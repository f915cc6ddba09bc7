#include "scene/default_view.h"
#include "tests/fuzz/targets.h"

#include "scene/classification.h"
#include "scene/import/cache/blob.h"
#include "scene/mesh_builder.h"
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

// The accesses of code that trusts a validated scene.
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

MeshDraft triangle(const char* name) {
    MeshDraft draft{.name = name, .indices = {0, 1, 2}};
    for (const glm::vec3& at : {glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}) {
        draft.vertices.push_back({.position = at});
    }
    return draft;
}

// Small, and with a little of everything.
Scene everything() {
    Scene scene;
    scene.environment = "white";
    scene.materials.resize(2);
    scene.materials[0].baseColorTexture.texture = 0;
    scene.materials[1].transmission = 1.0f;
    scene.images.push_back(
        {.name = "dot", .width = 1, .height = 1, .levels = 1, .texels = {255, 0, 0, 255}});
    scene.textures.push_back({.image = 0});
    const Index top = addNode(scene, "top"), below = addNode(scene, "below", glm::dmat4(1.0), top);
    addInstance(scene, below, addMesh(scene, triangle("still")), 1);
    scene.lights.push_back({.name = "lamp", .node = below});
    scene.cameras.push_back({.name = "camera", .node = top});
    scene.probes.push_back({.name = "probe", .node = below});
    scene.defaultView = DefaultView{};
    scene.warnings.push_back({"code", "subject", "message", 2});

    MeshDraft bending = triangle("bending");
    bending.deforms = true;
    const Index mesh = addMesh(scene, std::move(bending));
    addInstance(scene, top, mesh, 0);
    scene.skins.push_back({.joints = {top, below}, .jointFromMesh = {2, glm::dmat4(1.0)}});
    scene.morphWeights.push_back({.node = top, .rest = {0.5f}});
    scene.meshes[mesh].deformation = 0;
    Deformation deformation{.mesh = mesh,
                            .firstVertex = 3,
                            .skin = 0,
                            .weights = 0,
                            .perVertex = 1,
                            .influences = {{0, 1.0f}, {1, 1.0f}, {0, 1.0f}},
                            .firstDelta = {0, 1},
                            .deltas = {{.vertex = 1, .position = {0, 0, 1}}}};
    for (std::size_t k = 3; k < 6; ++k) {
        deformation.base.push_back({.position = scene.vertices[k].position});
    }
    scene.deformations.push_back(std::move(deformation));
    scene.movingNodes.push_back({.node = below});
    scene.clips.push_back({.name = "swing",
                           .duration = 1.0,
                           .tracks = {{.property = AnimatedProperty::translation,
                                       .target = 0,
                                       .times = {0.0f, 1.0f},
                                       .values = {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f}},
                                      {.property = AnimatedProperty::weights,
                                       .target = 0,
                                       .interpolation = Interpolation::step,
                                       .times = {0.0f},
                                       .values = {1.0f}}}});
    finishMotion(scene);
    updateContentHash(scene);
    require(sceneProblems(scene).empty(), "the seed is sound");
    return scene;
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
    for (const Scene& scene : {Scene{}, everything()}) {
        const std::string blob = blobOf(scene);
        seeds.push_back(blob.substr(header().size(), blob.size() - header().size() - kChecksum));
    }
    return seeds;
}

}  // namespace clerestory::test
