#include "scene/flat_mirrors.h"

#include <algorithm>

namespace clerestory {
namespace {

constexpr float kMaxRoughness = 0.1f;
constexpr float kMinMetallic = 0.99f;

}  // namespace

bool FlatMirror::nearBox(const glm::dvec3& point) const {
    const double margin = 1e-3 * static_cast<double>(box.diagonal());
    return glm::all(glm::greaterThanEqual(point, glm::dvec3(box.min) - margin)) &&
           glm::all(glm::lessThanEqual(point, glm::dvec3(box.max) + margin));
}

FlatMirror FlatMirror::relativeTo(const glm::dvec3& origin) const {
    FlatMirror moved = *this;
    moved.plane.offset += glm::dot(plane.normal, origin);
    moved.box = {glm::vec3(glm::dvec3(box.min) - origin), glm::vec3(glm::dvec3(box.max) - origin)};
    return moved;
}

std::vector<FlatMirror> flatMirrors(const Scene& scene, const Pose& pose,
                                    const MaterialBindings& materials,
                                    const std::vector<Surface>& surfaces) {
    std::vector<FlatMirror> mirrors;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const Surface& s = surfaces[i];
        if (s.flatPart == kNone || s.reflector != Reflector::flat || s.glass != Glass::none ||
            s.roughness > kMaxRoughness || s.slope > 0.0f) {
            continue;
        }
        const Material& material = materials.material(scene, s.material);
        if (material.alphaMode != AlphaMode::opaque || hasLayers(material) ||
            classOf(scene, material).metallic < kMinMetallic) {
            continue;
        }
        const FlatPart& part = scene.flatParts[s.flatPart];
        const glm::dmat4& worldFromMesh = pose.worldFromNode[scene.instances[s.instance].node];
        const auto plane = transformed(part.plane(), worldFromMesh);
        const Bounds box = transformed(part.bounds, worldFromMesh);
        if (plane && finite(box)) mirrors.push_back({i, *plane, box, material.doubleSided});
    }
    std::stable_sort(mirrors.begin(), mirrors.end(), [](const FlatMirror& a, const FlatMirror& b) {
        return a.box.diagonal() > b.box.diagonal();
    });
    if (mirrors.size() > kMaxFlatMirrors) mirrors.resize(kMaxFlatMirrors);
    return mirrors;
}

}  // namespace clerestory
