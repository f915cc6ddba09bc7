// Gathering the triangles, and what is at a point of one.
#include "reference/world.h"

#include "reference/texture.h"
#include "reference/tree.h"

#include <stdexcept>

namespace clerestory::reference {
namespace {

// Metres from the origin; squares of differences stay finite in float.
constexpr double kFarthest = 1e15;

bool inReach(const glm::dvec3& p) {
    return glm::all(glm::lessThanEqual(glm::abs(p), glm::dvec3(kFarthest)));
}

glm::dvec3 middleOf(const Scene& scene, const Pose& pose, double& diagonal) {
    Bounds all;
    for (const Instance& instance : scene.instances) {
        const Bounds box = transformed(boundsOf(pose, scene.meshes[instance.mesh]),
                                       pose.worldFromNode[instance.node]);
        if (inReach(box.min) && inReach(box.max)) all.add(box);
    }
    diagonal = all.empty() ? 1.0 : std::max(1e-9, double(all.diagonal()));
    return all.empty() ? glm::dvec3(0.0) : 0.5 * (glm::dvec3(all.min) + glm::dvec3(all.max));
}

// Columns of cofactors: how normals turn, for singular matrices too.
glm::dmat3 cofactors(const glm::dmat3& m) {
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

// What a normal map's texel says, in tangent space; of any length.
glm::dvec3 bumpOf(const Scene& scene, const TextureSlot& slot, const glm::dvec4& texel) {
    const glm::dvec4 number = texel * 2.0 - 1.0;
    if (!scene.images[scene.textures[slot.texture].image].packedNormal) return glm::dvec3(number);
    const double x = number.r, y = number.a;
    return {x, y, std::sqrt(std::max(1.0 - x * x - y * y, 0.0))};
}

}  // namespace

World::World(const Scene& scene, const Pose& pose, const MaterialBindings& materials,
             const Effects& effects)
    : scene_(scene),
      pose_(pose),
      materials_(materials),
      emission_(effects.emission),
      refraction_(effects.refraction),
      surfaces_(surfacesOf(scene, materials)) {
    for (const TextureImage& image : scene.images) {
        if (image.texels.size() < std::size_t{4} * image.width * image.height) {
            throw std::invalid_argument("the scene's images hold no texels");
        }
    }
    origin_ = middleOf(scene, pose, diagonal_);
    for (const Instance& instance : scene.instances) {
        Placing p{.worldFromMesh = pose.worldFromNode[instance.node]};
        p.worldFromMesh[3] -= glm::dvec4(origin_, 0.0);
        const glm::dmat3 linear(p.worldFromMesh);
        const double volume = glm::determinant(linear);
        p.turning = volume < 0.0 ? -1.0 : 1.0;
        p.normalFromMesh = p.turning * cofactors(linear);
        p.scale = std::cbrt(std::abs(volume));
        placings_.push_back(p);
    }
    gather();
    tree_ = std::make_unique<Tree>(*this);
}

World::~World() = default;

void World::gather() {
    for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
        if (!refraction_) surfaces_[s].glass = Glass::none;
        const Material& material = materialOf(surfaces_[s]);
        anyClear_ |= surfaces_[s].glass != Glass::none || material.alphaMode == AlphaMode::blend;
        addSurface(s);
    }
}

void World::addSurface(std::uint32_t s) {
    const Surface& surface = surfaces_[s];
    const Placing& placing = placings_[surface.instance];
    const Material& material = materialOf(surface);
    // A solid is left through its faces' backs.
    const bool bothSides = material.doubleSided || surface.glass == Glass::solid;
    const MeshVertices vertices = verticesIn(surface);
    for (std::uint32_t k = 0; k < surface.clusterCount; ++k) {
        const Cluster& cluster = scene_.clusters[surface.firstCluster + k];
        for (std::uint32_t j = 0; j + 2 < cluster.indexCount; j += 3) {
            Triangle t{.firstIndex = cluster.firstIndex + j,
                       .surface = s,
                       .side = bothSides ? 0 : static_cast<std::int32_t>(placing.turning)};
            bool sound = true;
            for (int corner = 0; corner < 3; ++corner) {
                const Vertex& v = vertices[scene_.indices[t.firstIndex + corner]];
                const glm::dvec3 p(placing.worldFromMesh * glm::dvec4(v.position, 1.0));
                sound = sound && inReach(p);
                (corner == 0 ? t.a : corner == 1 ? t.b : t.c) = glm::vec3(p);
            }
            const glm::dvec3 across =
                glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a));
            if (sound && glm::dot(across, across) > 0.0) triangles_.push_back(t);
        }
    }
}

bool World::meets(std::uint32_t number, double weightB, double weightC, bool seenTurning) const {
    const Triangle& t = triangles_[number];
    if (t.side != 0 && seenTurning != (t.side > 0)) return false;
    const Material& m = materialOf(surfaces_[t.surface]);
    if (m.alphaMode != AlphaMode::mask) return true;
    const MeshVertices vertices = verticesIn(surfaces_[t.surface]);
    const Vertex& a = vertices[scene_.indices[t.firstIndex]];
    const Vertex& b = vertices[scene_.indices[t.firstIndex + 1]];
    const Vertex& c = vertices[scene_.indices[t.firstIndex + 2]];
    const double color =
        a.color.w * (1.0 - weightB - weightC) + b.color.w * weightB + c.color.w * weightC;
    const double coverage =
        m.baseColor.w * color * textureAt(scene_, m.baseColorTexture, a, b, c, weightB, weightC).w;
    return coverage >= m.alphaCutoff;
}

Point World::pointAt(const Hit& hit, const glm::dvec3& along) const {
    const Triangle& t = triangles_[hit.triangle];
    const double wb = hit.weightB, wc = hit.weightC, wa = 1.0 - wb - wc;
    const MeshVertices vertices = verticesIn(surfaces_[t.surface]);
    const Vertex& a = vertices[scene_.indices[t.firstIndex]];
    const Vertex& b = vertices[scene_.indices[t.firstIndex + 1]];
    const Vertex& c = vertices[scene_.indices[t.firstIndex + 2]];

    Point p{.triangle = hit.triangle, .surface = &surfaces_[t.surface]};
    p.instance = p.surface->instance;
    p.material = &materialOf(*p.surface);
    const Material& m = *p.material;
    const Placing& placing = placings_[p.instance];
    const auto blend = [&](const auto& va, const auto& vb, const auto& vc) {
        return va * wa + vb * wb + vc * wc;
    };
    const glm::dvec3 cornerA(t.a), cornerB(t.b), cornerC(t.c);
    p.place = blend(cornerA, cornerB, cornerC);
    const glm::dvec3 most =
        glm::max(glm::abs(cornerA), glm::max(glm::abs(cornerB), glm::abs(cornerC)));
    p.reach = greatest(most);
    const glm::dvec3 face = unitOr(glm::cross(cornerB - cornerA, cornerC - cornerA), -along);
    const bool seenTurning = glm::dot(face, along) < 0.0;
    p.face = seenTurning ? face : -face;
    p.front = seenTurning == (placing.turning > 0.0);

    const auto slot = [&](const TextureSlot& s) { return textureAt(scene_, s, a, b, c, wb, wc); };
    const glm::dvec4 base = glm::dvec4(m.baseColor) *
                            blend(glm::dvec4(a.color), glm::dvec4(b.color), glm::dvec4(c.color)) *
                            slot(m.baseColorTexture);
    p.baseColor = glm::max(glm::dvec3(base), 0.0);
    if (m.alphaMode == AlphaMode::blend) p.coverage = std::clamp(base.w, 0.0, 1.0);
    if (m.unlit) return p;

    const glm::dvec4 surface = slot(m.metallicRoughnessTexture);
    p.metallic = std::clamp(m.metallic * surface.b, 0.0, 1.0);
    p.roughness = std::clamp(m.roughness * surface.g, 0.0, 1.0);
    p.occlusion = 1.0 + m.occlusionStrength * (slot(m.occlusionTexture).r - 1.0);
    if (emission_) p.emitted = glm::dvec3(emittedRadiance(m)) * glm::dvec3(slot(m.emissiveTexture));
    if (p.surface->glass != Glass::none) {
        p.transmission = std::clamp(m.transmission * slot(m.transmissionTexture).r, 0.0, 1.0);
        p.thickness = m.thickness * slot(m.thicknessTexture).g * placing.scale;
    }

    const auto normalOf = [&](const Vertex& v) {
        return unitOr(placing.normalFromMesh * glm::dvec3(v.normal), p.face);
    };
    glm::dvec3 n = blend(normalOf(a), normalOf(b), normalOf(c));
    if (m.normalTexture.present() && m.normalScale != 0.0f) {
        const auto tangentOf = [&](const Vertex& v) {
            const glm::dvec3 tangent(v.tangent);
            return unitOr(glm::dmat3(placing.worldFromMesh) * tangent, glm::dvec3(0.0));
        };
        const glm::dvec3 tangent = blend(tangentOf(a), tangentOf(b), tangentOf(c));
        const glm::dvec3 bitangent = glm::cross(n, tangent) * (a.tangent.w * placing.turning);
        const glm::dvec3 bump = bumpOf(scene_, m.normalTexture, slot(m.normalTexture));
        const double scale = m.normalScale;
        n = tangent * (bump.x * scale) + bitangent * (bump.y * scale) + n * bump.z;
    }
    n = unitOr(p.front ? n : -n, p.face);
    // A smoothed or bumpy normal may face away from who looks; it is brought to the horizon.
    constexpr double kHorizon = 1e-4;
    const double seen = -glm::dot(n, along);
    if (seen < kHorizon) n = unitOr(n - along * (kHorizon - seen), p.face);
    p.normal = n;
    return p;
}

double World::turnAcross(const Hit& hit, const Point& point, const glm::dvec3& along,
                         double width) const {
    constexpr double kGrazing = 0.1;
    const Triangle& t = triangles_[hit.triangle];
    const glm::dvec3 b = glm::dvec3(t.b) - glm::dvec3(t.a), c = glm::dvec3(t.c) - glm::dvec3(t.a);
    const glm::dvec3 normal = glm::cross(b, c);
    const double squared = glm::dot(normal, normal);
    const glm::dvec3 across =
        unitOr(glm::cross(point.face, along), Frame(point.face).x);  // and away from the eye
    const double stretch = std::max(std::abs(glm::dot(point.face, along)), kGrazing);
    const auto turned = [&](const glm::dvec3& way) {
        Hit beside = hit;
        beside.weightB += glm::dot(glm::cross(way, c), normal) / squared;
        beside.weightC += glm::dot(glm::cross(b, way), normal) / squared;
        return pointAt(beside, along).normal - point.normal;
    };
    const glm::dvec3 one = turned(across * width);
    const glm::dvec3 other = turned(glm::cross(point.face, across) * (width / stretch));
    return std::sqrt(glm::length(glm::cross(one, other)));
}

Ray World::leaving(const Point& point, const glm::dvec3& along) {
    // The place is exact in double; corners, and the ray that Embree gets, are rounded to 2^-24 of
    // their greatest coordinate, and its sums add some of the same.
    const double away = 1e-6 * point.reach + 1e-30;
    const glm::dvec3 side = glm::dot(along, point.face) >= 0.0 ? point.face : -point.face;
    return {.origin = point.place + side * away, .direction = along, .leaves = point.triangle};
}

}  // namespace clerestory::reference
