// The check between whoever made a scene and everybody who trusts it.
#include "scene/scene.h"

#include "scene/motion_problems.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace clerestory {
namespace {

bool finite(float v) {
    return std::isfinite(v);
}
bool finite(double v) {
    return std::isfinite(v);
}
template <int N, class T>
bool finite(const glm::vec<N, T>& v) {
    for (int i = 0; i < N; ++i) {
        if (!std::isfinite(v[i])) return false;
    }
    return true;
}
bool finite(const glm::dmat4& m) {
    return finite(m[0]) && finite(m[1]) && finite(m[2]) && finite(m[3]);
}

bool finite(const Bounds& box) {
    return finite(box.min) && finite(box.max);
}

bool holds(const Bounds& box, const glm::vec3& point) {
    return glm::all(glm::lessThanEqual(box.min, point)) &&
           glm::all(glm::lessThanEqual(point, box.max));
}

bool unitQuaternion(const glm::dquat& q) {
    return std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) < 1e-6;
}
bool sound(const MapBlur& blur) {
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
    void require(bool holds, const char* what, std::size_t index) {
        constexpr std::size_t kEnough = 20;
        if (!holds && problems_.size() < kEnough) {
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
            const bool fits = c.indexCount % 3 == 0 && c.indexCount <= 3 * kClusterTriangles &&
                              std::uint64_t{c.firstIndex} + c.indexCount <= scene_.indices.size();
            require(fits, "a cluster does not fit the indices", i);
            require(!c.bounds.empty() && finite(c.bounds) && (!fits || holdsItsVertices(c)),
                    "a cluster's bounds do not hold it", i);
        }
        for (std::size_t i = 0; i < scene_.meshes.size(); ++i) {
            const Mesh& m = scene_.meshes[i];
            const bool fits =
                std::uint64_t{m.firstCluster} + m.clusterCount <= scene_.clusters.size();
            require(fits, "a mesh has clusters out of range", i);
            require(m.material < scene_.materials.size(), "a mesh has no such material", i);
            require(!m.bounds.empty() && finite(m.bounds), "a mesh has no bounds", i);
            std::uint64_t triangles = 0;
            if (fits) {
                for (std::uint32_t c = 0; c < m.clusterCount; ++c) {
                    const Cluster& cluster = scene_.clusters[m.firstCluster + c];
                    triangles += cluster.indexCount / 3;
                    require(
                        holds(m.bounds, cluster.bounds.min) && holds(m.bounds, cluster.bounds.max),
                        "a mesh's bounds do not hold it", i);
                }
            }
            flatPartsOf(m, i);
            require(std::isfinite(m.area) && m.area >= 0.0, "a mesh has no area", i);
            require(triangles == m.triangles, "a mesh counts its triangles wrong", i);
        }
    }

    bool holdsItsVertices(const Cluster& c) const {
        const auto own = std::span(scene_.indices).subspan(c.firstIndex, c.indexCount);
        return std::all_of(own.begin(), own.end(), [&](std::uint32_t index) {
            return index < scene_.vertices.size() &&
                   holds(c.bounds, scene_.vertices[index].position);
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
        const auto unit = [](float v) { return v >= 0.0f && v <= 1.0f; };
        const auto notNegative = [](const glm::vec3& c) {
            return finite(c) && c.x >= 0.0f && c.y >= 0.0f && c.z >= 0.0f;
        };
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
            const Material& m = scene_.materials[i];
            require(finite(m.baseColor) && finite(m.normalScale) && unit(m.metallic) &&
                        unit(m.roughness) && unit(m.occlusionStrength) && unit(m.transmission) &&
                        finite(m.alphaCutoff) && m.specular >= 0.0f && finite(m.specular) &&
                        notNegative(m.specularColor),
                    "a material's factor is out of range", i);
            require(notNegative(m.emissive) && m.emissiveStrength >= 0.0f &&
                        finite(m.emissiveStrength) && finite(emittedRadiance(m)),
                    "a material's emission is out of range", i);
            require(finite(m.ior) && m.ior >= 1.0f && finite(m.thickness) && m.thickness >= 0.0f &&
                        notNegative(m.attenuationColor) && finite(m.attenuationDistance) &&
                        m.attenuationDistance >= 0.0f,
                    "a material's volume is out of range", i);
            require(unitQuaternion(m.environmentRotation),
                    "a material's environment rotation is no unit quaternion", i);
            require(sound(m.mapBlur), "a material's blur is out of range", i);
            for (const TextureSlot* s : textureSlots(m)) {
                require(!s->present() || s->texture < scene_.textures.size(),
                        "a material has no such texture", i);
                require(
                    s->texCoord < 2 && finite(s->offset) && finite(s->scale) && finite(s->rotation),
                    "a material's texture transform is out of range", i);
            }
        }
    }

    void pictures() {
        for (std::size_t i = 0; i < scene_.images.size(); ++i) {
            const TextureImage& image = scene_.images[i];
            std::uint64_t texels = 0, width = image.width, height = image.height;
            bool sound = width > 0 && height > 0 && width <= 65536 && height <= 65536 &&
                         image.levels > 0 && image.levels <= 17;
            for (std::uint32_t level = 0; sound && level < image.levels; ++level) {
                texels += width * height;
                sound = level + 1 == image.levels || width > 1 || height > 1;
                width = std::max<std::uint64_t>(1, width / 2);
                height = std::max<std::uint64_t>(1, height / 2);
            }
            require(sound && texels * 4 == image.texels.size(),
                    "an image's levels do not fit its size", i);
            require(finite(image.mean), "an image's mean is not finite", i);
        }
        for (std::size_t i = 0; i < scene_.textures.size(); ++i) {
            require(scene_.textures[i].image < scene_.images.size(), "a texture has no such image",
                    i);
        }
    }

    void placement() {
        for (std::size_t i = 0; i < scene_.nodes.size(); ++i) {
            const Node& n = scene_.nodes[i];
            require(n.parent == kNone || n.parent < i, "a node stands before its parent", i);
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
                        finite(l.outerConeAngle),
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
                        sound(p.blur),
                    "a probe is out of range", i);
        }
        require(unitQuaternion(scene_.environmentRotation),
                "the environment's rotation is no unit quaternion", 0);
        if (scene_.defaultView) {
            const DefaultView& v = *scene_.defaultView;
            require(finite(v.position) && finite(v.target) && v.position != v.target &&
                        finite(v.yfov) && v.yfov > 0.0 && v.yfov < 3.1416,
                    "the default view is out of range", 0);
        }
    }

    // Where everything is right by itself, a deep tree of large scales may still lead out of what
    // numbers hold. Clips may, too: poseAt() looks after those.
    void extent() {
        const Pose rest = restPose(scene_);
        for (std::size_t i = 0; i < scene_.nodes.size(); ++i) {
            require(inReach(rest.worldFromNode[i]), "a node stands nowhere", i);
        }
        for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
            const Instance& one = scene_.instances[i];
            require(inReach(transformed(boundsOf(rest, scene_.meshes[one.mesh]),
                                        rest.worldFromNode[one.node])),
                    "an instance is too large or too far away", i);
        }
        require(scene_.reach.empty() || inReach(scene_.reach), "what moves goes too far", 0);
    }

    const Scene& scene_;
    std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> sceneProblems(const Scene& scene) {
    return Check(scene).run();
}

}  // namespace clerestory
