// Validates a scene before the renderer uses it.
#include "scene/scene.h"

#include "scene/animation.h"
#include "scene/geometry.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace clerestory {
namespace {

bool contains(const Bounds& box, const glm::vec3& point) {
    return glm::all(glm::lessThanEqual(box.min, point)) &&
           glm::all(glm::lessThanEqual(point, box.max));
}

bool unitQuaternion(const glm::dquat& q) {
    return std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) < 1e-6;
}
bool validBlur(const MapBlur& blur) {
    return blur.size <= kLargestBlur && blur.stdev >= 0.0 && blur.stdev <= kLargestBlur;
}

class Check {
public:
    explicit Check(const Scene& scene) : scene_(scene) {}

    std::vector<std::string> run() {
        geometry();
        materials();
        pictures();
        placement();
        if (problems_.empty()) problems_ = motionProblems(scene_);
        if (problems_.empty()) extent();
        return std::move(problems_);
    }

private:
    void require(bool holds, std::string_view what, std::size_t index) {
        constexpr std::size_t kMaxProblems = 20;
        if (!holds && problems_.size() < kMaxProblems) {
            problems_.push_back(std::string(what) + " (number " + std::to_string(index) + ")");
        }
    }

    void geometry() {
        for (std::size_t i = 0; i < scene_.vertices.size(); ++i) {
            const Vertex& v = scene_.vertices[i];
            require(finite(v.position) && finite(v.normal) && finite(v.tangent) &&
                        finite(v.texCoord0) && finite(v.texCoord1) && finite(v.color),
                    "a vertex is not finite", i);
        }
        for (std::size_t i = 0; i < scene_.indices.size(); ++i) {
            require(scene_.indices[i] < scene_.vertices.size(), "an index is out of range", i);
        }
        for (std::size_t i = 0; i < scene_.clusters.size(); ++i) {
            const Cluster& c = scene_.clusters[i];
            const bool fits = std::uint64_t{c.firstIndex} + c.indexCount <= scene_.indices.size();
            require(fits, "a cluster does not fit the indices", i);
            require(!c.bounds.empty() && finite(c.bounds) && (!fits || containsItsVertices(c)),
                    "a cluster's bounds do not contain it", i);
        }
        for (std::size_t i = 0; i < scene_.meshes.size(); ++i) {
            const Mesh& m = scene_.meshes[i];
            const bool fits =
                std::uint64_t{m.firstCluster} + m.clusterCount <= scene_.clusters.size();
            require(fits, "a mesh has clusters out of range", i);
            require(m.material < scene_.materials.size(), "a mesh has no such material", i);
            require(!m.bounds.empty() && finite(m.bounds), "a mesh has no bounds", i);
            const bool known =
                m.primitive >= Primitive::points && m.primitive <= Primitive::triangles;
            require(known, "a mesh is neither triangles nor lines nor points", i);
            const std::uint32_t each = known ? indicesPer(m.primitive) : 1;
            const bool surface = m.primitive == Primitive::triangles;
            require(surface || m.flatPartCount == 0, "lines or points have flat parts", i);
            std::uint64_t primitives = 0;
            if (fits) {
                for (std::uint32_t c = 0; c < m.clusterCount; ++c) {
                    const Cluster& cluster = scene_.clusters[m.firstCluster + c];
                    primitives += cluster.indexCount / each;
                    require(cluster.indexCount % each == 0 &&
                                cluster.indexCount <= each * kClusterPrimitives &&
                                (!surface || cluster.firstIndex % 3 == 0),
                            "a mesh's cluster divides a primitive or is too large", i);
                    require(contains(m.bounds, cluster.bounds.min) &&
                                contains(m.bounds, cluster.bounds.max),
                            "a mesh's bounds do not contain it", i);
                }
            }
            flatPartsOf(m, i);
            require(std::isfinite(m.area) && m.area >= 0.0, "a mesh has no area", i);
            require(primitives == m.primitives, "a mesh has a wrong number of primitives", i);
        }
    }

    bool containsItsVertices(const Cluster& c) const {
        const auto own = std::span(scene_.indices).subspan(c.firstIndex, c.indexCount);
        return std::all_of(own.begin(), own.end(), [&](std::uint32_t index) {
            return index < scene_.vertices.size() &&
                   contains(c.bounds, scene_.vertices[index].position);
        });
    }

    void flatPartsOf(const Mesh& m, std::size_t i) {
        const bool fit =
            std::uint64_t{m.firstFlatPart} + m.flatPartCount <= scene_.flatParts.size();
        require(fit, "a mesh has flat parts out of range", i);
        std::uint64_t next = m.firstCluster;
        for (std::uint32_t p = 0; fit && p < m.flatPartCount; ++p) {
            const FlatPart& part = scene_.flatParts[m.firstFlatPart + p];
            require(part.firstCluster == next &&
                        next + part.clusterCount <= std::uint64_t{m.firstCluster} + m.clusterCount,
                    "a flat part's clusters are not its mesh's first", i);
            next += part.clusterCount;
            require(finite(part.normal) && std::abs(glm::length(part.normal) - 1.0) < 1e-6 &&
                        finite(part.offset) && finite(part.area) && part.area > 0.0 &&
                        !part.bounds.empty() && finite(part.bounds),
                    "a flat part has no plane", i);
        }
    }

    void materials() {
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
            fields(scene_.materials[i],
                   [&](const char* name, const auto& member, const auto& kind) {
                       if (valid(member, kind)) return;
                       require(false, "a material's " + std::string(name) + " is out of range", i);
                   });
        }
    }

    template <class T>
    static bool valid(const T& value, const FactorRange& range) {
        const auto inside = [&](float v, float max) { return v >= range.min && v <= max; };
        if constexpr (std::is_same_v<T, float>) {
            return inside(value, range.max);
        } else {
            for (int i = 0; i < T::length(); ++i) {
                if (!inside(value[i], i < 3 ? range.max : range.maxCoverage)) return false;
            }
            return true;
        }
    }
    template <class E>
    static bool valid(E value, const EnumRange<E>& range) {
        return value <= range.last;
    }
    bool valid(const TextureSlot& slot, const SlotRange&) const {
        bool all = (!slot.present() || slot.texture < scene_.textures.size()) && slot.texCoord < 2;
        fields(slot, [&](const char*, const auto& member, const auto& kind) {
            all = all && valid(member, kind);
        });
        return all;
    }
    static bool valid(const glm::dquat& q, const Rotation&) { return unitQuaternion(q); }
    static bool valid(const MapBlur& blur, const Nested&) { return validBlur(blur); }
    static bool valid(const std::string&, const Text&) { return true; }
    static bool valid(bool, const Flag&) { return true; }
    template <class T>
    static bool valid(const T&, const Unchecked&) {
        return true;
    }

    void pictures() {
        for (std::size_t i = 0; i < scene_.images.size(); ++i) {
            const TextureImage& image = scene_.images[i];
            std::uint64_t texels = 0, width = image.width, height = image.height;
            bool valid = width > 0 && height > 0 && width <= 65536 && height <= 65536 &&
                         image.levels > 0 && image.levels <= 17;
            for (std::uint32_t level = 0; valid && level < image.levels; ++level) {
                texels += width * height;
                valid = level + 1 == image.levels || width > 1 || height > 1;
                width = std::max<std::uint64_t>(1, width / 2);
                height = std::max<std::uint64_t>(1, height / 2);
            }
            require(valid && texels * 4 == image.texels.size(),
                    "an image's levels do not fit its size", i);
            require(finite(image.mean) && std::isfinite(image.leastGreen) &&
                        std::isfinite(image.slope) && image.slope >= 0.0f,
                    "an image's mean or slope is not finite", i);
        }
        for (std::size_t i = 0; i < scene_.textures.size(); ++i) {
            require(scene_.textures[i].image < scene_.images.size(), "a texture has no such image",
                    i);
        }
    }

    void placement() {
        for (std::size_t i = 0; i < scene_.nodes.size(); ++i) {
            const Node& n = scene_.nodes[i];
            require(n.parent == kNone || n.parent < i, "a node precedes its parent", i);
            require(finite(n.parentFromLocal), "a node's transform is not finite", i);
        }
        const auto hasNode = [&](Index node) { return node < scene_.nodes.size(); };
        for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
            require(hasNode(scene_.instances[i].node) &&
                        scene_.instances[i].mesh < scene_.meshes.size() &&
                        scene_.instances[i].material < scene_.materials.size(),
                    "an instance has no such node, mesh or material", i);
        }
        for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
            const Light& l = scene_.lights[i];
            require((l.node == kNone || hasNode(l.node)) && finite(l.intensity) &&
                        finite(l.range) && l.range >= 0.0f && finite(l.innerConeAngle) &&
                        finite(l.outerConeAngle) && finite(l.radius) && l.radius >= 0.0f,
                    "a light is out of range", i);
        }
        for (std::size_t i = 0; i < scene_.cameras.size(); ++i) {
            const Camera& c = scene_.cameras[i];
            require(hasNode(c.node) && finite(c.yfov) && finite(c.yHalfHeight) && finite(c.znear) &&
                        finite(c.zfar) && c.yfov > 0.0 && c.yfov < 3.1416 && c.yHalfHeight > 0.0 &&
                        c.znear >= 0.0 && c.zfar >= 0.0,
                    "a camera is out of range", i);
        }
        for (std::size_t i = 0; i < scene_.probes.size(); ++i) {
            const Probe& p = scene_.probes[i];
            require((p.node == kNone || hasNode(p.node)) && finite(p.position) && finite(p.size) &&
                        p.size > 0.0 && finite(p.zfar) && p.zfar >= 0.0 && p.resolution <= 4096 &&
                        validBlur(p.blur),
                    "a probe is out of range", i);
        }
        require(unitQuaternion(scene_.environmentRotation),
                "the environment's rotation is no unit quaternion", 0);
        require(scene_.scenesOfFile.empty() ? scene_.sceneOfFile == 0
                                            : scene_.sceneOfFile < scene_.scenesOfFile.size(),
                "the file has no such scene", scene_.sceneOfFile);
        std::set<std::string_view> variants;
        for (std::size_t k = 0; k < scene_.variants.size(); ++k) {
            const Variant& variant = scene_.variants[k];
            require(!variant.name.empty() && variants.insert(variant.name).second,
                    "a variant has no unique name", k);
            for (const Variant::Choice& choice : variant.choices) {
                require(
                    choice.mesh < scene_.meshes.size() && choice.material < scene_.materials.size(),
                    "a variant has no such mesh or material", k);
            }
        }
        if (scene_.defaultView) {
            const DefaultView& v = *scene_.defaultView;
            require(finite(v.position) && finite(v.target) && v.position != v.target &&
                        finite(v.yfov) && v.yfov > 0.0 && v.yfov < 3.1416 && v.fit.x >= 0.0 &&
                        v.fit.x <= 10.0 && v.fit.y >= 0.0 && v.fit.y <= 10.0,
                    "the default view is out of range", 0);
        }
    }

    // Even if every part is valid, a deep tree of large scales can overflow. poseAt() checks the
    // same for clips.
    void extent() {
        const Pose rest = restPose(scene_);
        for (std::size_t i = 0; i < scene_.nodes.size(); ++i) {
            require(inReach(rest.worldFromNode[i]), "a node's transform is out of range", i);
        }
        for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
            const Instance& one = scene_.instances[i];
            require(inReach(transformed(boundsOf(rest, scene_.meshes[one.mesh]),
                                        rest.worldFromNode[one.node])),
                    "an instance is too large or too far away", i);
        }
        require((scene_.reach.empty() || inReach(scene_.reach)) &&
                    (scene_.motionReach.empty() || inReach(scene_.motionReach)),
                "animated bounds are out of range", 0);
    }

    const Scene& scene_;
    std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> sceneProblems(const Scene& scene) {
    return Check(scene).run();
}

}  // namespace clerestory
