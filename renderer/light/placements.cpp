#include "light/placements.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clerestory::light {
namespace {

// Triangles that are copied so that instances have their own: of one mesh, and of all.
constexpr std::uint64_t kMaxCopiedOfMesh = 8'192, kMaxCopied = 65'536;
// What is divided near a small body is divided in all instances that share triangles.
constexpr std::size_t kMaxSharing = 4;
constexpr double kSameSize = 1e-3;  // of squares of lengths, relative to the greatest

// Whether both give all ways the same length: their products with their transposes are equal.
bool areOneSize(const glm::dmat3& a, const glm::dmat3& b) {
    const glm::dmat3 x = glm::transpose(a) * a, y = glm::transpose(b) * b;
    double greatest = 0.0, difference = 0.0;
    for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row) {
            greatest = std::max(greatest, std::abs(x[column][row]));
            difference = std::max(difference, std::abs(x[column][row] - y[column][row]));
        }
    }
    return difference <= kSameSize * greatest;
}

double greatestScale(const glm::dmat4& m) {
    double scale = 0.0;
    for (int column = 0; column < 3; ++column) {
        scale = std::max(scale, glm::length(glm::dvec3(m[column])));
    }
    return scale;
}

class Grouping {
public:
    Grouping(const Scene& scene, const Pose& pose, const EdgeLengths& edges)
        : scene_(scene), pose_(pose), edges_(edges), instancesOf_(scene.meshes.size()) {
        const std::vector<bool> moves = instancesThatMove(scene);
        for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
            if (isDivided(scene, moves, i)) instancesOf_[scene.instances[i].mesh].push_back(i);
        }
    }

    std::vector<Placement> placements() {
        std::vector<Placement> all;
        for (Index mesh = 0; mesh < scene_.meshes.size(); ++mesh) {
            if (instancesOf_[mesh].empty()) continue;
            for (Placement& p : ofMesh(mesh)) all.push_back(std::move(p));
        }
        return all;
    }

private:
    const glm::dmat4& worldOf(std::uint32_t instance) const {
        return pose_.worldFromNode[scene_.instances[instance].node];
    }

    std::vector<Placement> ofMesh(Index mesh) {
        const std::uint64_t triangles = scene_.meshes[mesh].primitives;
        const std::uint64_t limit = std::min(kMaxCopiedOfMesh, kMaxCopied - copied_);
        const std::size_t most = 1 + limit / std::max<std::uint64_t>(triangles, 1);
        std::vector<Placement> sizes = bySize(mesh, most);
        if (sizes.size() > most) sizes = {shared(mesh)};
        if (!edges_.small.empty()) {
            std::vector<Placement> own = nearBodiesApart(mesh, sizes);
            if (own.size() <= most) sizes = std::move(own);
        }
        copied_ += triangles * (sizes.size() - 1);
        for (Placement& p : sizes) {
            for (const std::uint32_t i : p.instances) {
                if (p.instances.size() <= kMaxSharing) p.places.push_back({worldOf(i), i});
            }
        }
        return sizes;
    }

    // One more than `most` where there are more.
    std::vector<Placement> bySize(Index mesh, std::size_t most) const {
        std::vector<Placement> sizes;
        for (const std::uint32_t i : instancesOf_[mesh]) {
            const glm::dmat3 world(worldOf(i));
            auto same = std::find_if(sizes.begin(), sizes.end(), [&](const Placement& p) {
                return areOneSize(p.worldFromMesh, world);
            });
            if (same == sizes.end()) {
                if (sizes.size() > most) break;
                same = sizes.insert(same, {.mesh = mesh, .worldFromMesh = world});
            }
            same->instances.push_back(i);
        }
        return sizes;
    }

    Placement shared(Index mesh) const {
        Placement all{.mesh = mesh, .instances = instancesOf_[mesh]};
        double scale = 0.0;
        for (const std::uint32_t i : all.instances) {
            scale = std::max(scale, greatestScale(worldOf(i)));
        }
        all.worldFromMesh = glm::dmat3(scale);
        return all;
    }

    std::vector<Placement> nearBodiesApart(Index mesh, const std::vector<Placement>& sizes) const {
        const double longest = longestEdge(mesh);
        std::vector<Placement> apart;
        for (const Placement& size : sizes) {
            Placement rest{.mesh = mesh, .worldFromMesh = size.worldFromMesh};
            for (const std::uint32_t i : size.instances) {
                const glm::dmat4& world = worldOf(i);
                const Bounds box = transformed(scene_.meshes[mesh].bounds, world);
                // Longer edges are divided anyway.
                const double length = std::min(longest * greatestScale(world), edges_.common);
                if (edges_.belowNearBodies(length, glm::dvec3(box.min), glm::dvec3(box.max), i)) {
                    apart.push_back(
                        {.mesh = mesh, .instances = {i}, .worldFromMesh = glm::dmat3(world)});
                } else {
                    rest.instances.push_back(i);
                }
            }
            if (!rest.instances.empty()) apart.push_back(std::move(rest));
        }
        return apart;
    }

    double longestEdge(Index mesh) const {
        double longest = 0.0;
        eachTriangle(scene_, scene_.meshes[mesh], [&](const std::uint32_t* corners) {
            for (int k = 0; k < 3; ++k) {
                const glm::dvec3 a(scene_.vertices[corners[k]].position);
                const glm::dvec3 b(scene_.vertices[corners[(k + 1) % 3]].position);
                longest = std::max(longest, glm::distance(a, b));
            }
        });
        return longest;
    }

    const Scene& scene_;
    const Pose& pose_;
    const EdgeLengths& edges_;
    std::vector<std::vector<std::uint32_t>> instancesOf_;
    std::uint64_t copied_ = 0;
};

}  // namespace

bool isDivided(const Scene& scene, const std::vector<bool>& moves, std::size_t i) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    return !moves[i] && mesh.primitive == Primitive::triangles && mesh.deformation == kNone &&
           !scene.materials[instance.material].unlit &&
           i != scene.ground;  // made with small triangles
}

std::vector<Placement> placementsOf(const Scene& scene, const Pose& pose,
                                    const EdgeLengths& edges) {
    return Grouping(scene, pose, edges).placements();
}

}  // namespace clerestory::light
