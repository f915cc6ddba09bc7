#include "scene/ground.h"

#include "scene/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace clerestory {
namespace {

// Cells along an axis where the scene stands, and from there to each edge.
constexpr int kInnerCells = 48, kOuterCells = 8;
constexpr double kSizePerDiagonal = 12.0;
// Below the lowest point, relative to the scene's diagonal: a floor of the scene keeps its pixels.
constexpr double kGap = 5e-5;

double lowestPoint(const Scene& scene, const Pose& pose) {
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        if (!pose.hidden.empty() && pose.hidden[i]) continue;
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        const MeshVertices vertices = verticesOf(scene, pose, mesh);
        const glm::dmat4& world = pose.worldFromNode[instance.node];
        const glm::dvec3 up(world[0].y, world[1].y, world[2].y);
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            for (std::uint32_t k = 0; k < cluster.indexCount; ++k) {
                const Vertex& vertex = vertices[scene.indices[cluster.firstIndex + k]];
                lowest = std::min(lowest, glm::dot(up, glm::dvec3(vertex.position)) + world[3].y);
            }
        }
    }
    return lowest;
}

// Coordinates of the lines of the grid, ascending: even up to `inner`, then ever wider.
std::vector<float> linesOf(double inner, double half) {
    inner = std::min(inner, half);
    const int outer = inner < half ? kOuterCells : 0;
    std::vector<float> lines;
    for (int i = outer; i > 0; --i) {
        lines.push_back(static_cast<float>(-inner * std::pow(half / inner, double(i) / outer)));
    }
    for (int i = 0; i <= kInnerCells; ++i) {
        lines.push_back(static_cast<float>(inner * (2.0 * i / kInnerCells - 1.0)));
    }
    for (int i = 1; i <= outer; ++i) {
        lines.push_back(static_cast<float>(inner * std::pow(half / inner, double(i) / outer)));
    }
    return lines;
}

MeshDraft planeOf(const std::vector<float>& x, const std::vector<float>& z, Index material) {
    MeshDraft draft{.name = "ground", .material = material};
    draft.hasNormals = draft.hasTexCoords = true;
    for (const float b : z) {
        for (const float a : x) {
            Vertex v;
            v.position = {a, 0.0f, b};
            v.normal = {0.0f, 1.0f, 0.0f};
            v.texCoord0 = v.texCoord1 = {a, b};
            draft.vertices.push_back(v);
        }
    }
    const auto columns = static_cast<std::uint32_t>(x.size());
    for (std::uint32_t j = 0; j + 1 < z.size(); ++j) {
        for (std::uint32_t i = 0; i + 1 < columns; ++i) {
            const std::uint32_t a = j * columns + i, b = a + columns;
            draft.indices.insert(draft.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
        }
    }
    return draft;
}

Material materialOf(const GroundPlane& ground, bool shadowCatcher) {
    Material m{.name = "ground", .baseColor = glm::vec4(glm::vec3(ground.color), 1.0f)};
    m.metallic = static_cast<float>(ground.metallic);
    m.roughness = static_cast<float>(ground.roughness);
    const double root = std::sqrt(ground.reflectance);  // ((n - 1) / (n + 1))^2
    m.ior = static_cast<float>((1.0 + root) / (1.0 - root));
    if (shadowCatcher) m.alphaMode = AlphaMode::blend;
    return m;
}

}  // namespace

void addGround(Scene& scene, const GroundPlane& ground, bool shadowCatcher) {
    const Pose pose = poseAt(scene, 0.0);
    const Bounds bounds = lastingBounds(scene, pose);
    if (bounds.empty() && !ground.height) return;
    const double diagonal =
        bounds.empty() ? 1.0 : std::max(1e-6, static_cast<double>(bounds.diagonal()));
    const glm::dvec3 middle = bounds.empty() ? glm::dvec3(0.0) : glm::dvec3(bounds.center());
    const glm::dvec3 extent =
        bounds.empty() ? glm::dvec3(1.0) : glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
    const double height = ground.height.value_or(lowestPoint(scene, pose) - kGap * diagonal);
    if (!std::isfinite(height)) return;  // nothing is visible
    const double half = 0.5 * ground.size.value_or(kSizePerDiagonal * diagonal);
    const auto lines = [&](double along) {
        return linesOf(0.7 * along + 0.3 * extent.y + 0.01 * diagonal, half);
    };
    scene.materials.push_back(materialOf(ground, shadowCatcher));
    const auto material = static_cast<Index>(scene.materials.size() - 1);
    const Index mesh = addMesh(scene, planeOf(lines(extent.x), lines(extent.z), material));
    if (mesh == kNone) return;
    glm::dmat4 place(1.0);
    place[3] = glm::dvec4(middle.x, height, middle.z, 1.0);
    addInstance(scene, addNode(scene, "ground", place), mesh);
    scene.ground = static_cast<Index>(scene.instances.size() - 1);
    scene.shadowCatcher = shadowCatcher;
}

std::string explained(const GroundPlane& ground, bool shadowCatcher) {
    std::string text = shadowCatcher ? "ground: added, a shadow catcher" : "ground: added";
    text += ground.height ? ", at the height " + field::numberText(*ground.height) + " m"
                          : ", at the lowest point of the scene";
    return text;
}

}  // namespace clerestory
