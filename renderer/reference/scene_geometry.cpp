// Collects the triangles of the posed scene; evaluates materials and normals at hits.
#include "reference/scene_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace clerestory::reference {
namespace {

// Metres from the origin: squares of differences stay finite in float. Other triangles are dropped.
constexpr double kMaxCoordinate = 1e15;

bool withinRange(const glm::dvec3& p) {
    return glm::all(glm::lessThanEqual(glm::abs(p), glm::dvec3(kMaxCoordinate)));
}

glm::dvec3 centreOf(const Scene& scene, const Pose& pose, double& diagonal) {
    Bounds all;
    for (const Instance& instance : scene.instances) {
        const Bounds box = transformed(boundsOf(pose, scene.meshes[instance.mesh]),
                                       pose.worldFromNode[instance.node]);
        if (withinRange(box.min) && withinRange(box.max)) all.add(box);
    }
    diagonal = all.empty() ? 1.0 : std::max(1e-9, double(all.diagonal()));
    return all.empty() ? glm::dvec3(0.0) : 0.5 * (glm::dvec3(all.min) + glm::dvec3(all.max));
}

// The cofactor matrix transforms normals, also for singular matrices.
glm::dmat3 cofactors(const glm::dmat3& m) {
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

// IEC 61966-2-1.
const std::array<double, 256>& linearFromSrgb() {
    static const std::array<double, 256> table = [] {
        std::array<double, 256> t{};
        for (int i = 0; i < 256; ++i) {
            const double s = i / 255.0;
            t[i] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
        }
        return t;
    }();
    return table;
}

std::uint32_t wrapped(double x, std::uint32_t size, Wrap wrap) {
    const double n = size;
    if (wrap == Wrap::clampToEdge) x = std::clamp(x, 0.0, n - 1.0);
    if (wrap == Wrap::repeat) x -= n * std::floor(x / n);
    if (wrap == Wrap::mirroredRepeat) {
        x -= 2.0 * n * std::floor(x / (2.0 * n));
        x = std::min(x, 2.0 * n - 1.0 - x);
    }
    // The clamp handles rounding of huge coordinates; NaN becomes 0.
    return x > 0.0 ? static_cast<std::uint32_t>(std::min(x, n - 1.0)) : 0;
}

glm::dvec4 texel(const TextureImage& image, std::uint32_t x, std::uint32_t y) {
    const std::uint8_t* t = image.texels.data() + 4 * (std::size_t{y} * image.width + x);
    if (image.colorSpace == ColorSpace::linear) return glm::dvec4(t[0], t[1], t[2], t[3]) / 255.0;
    const auto& linear = linearFromSrgb();
    return {linear[t[0]], linear[t[1]], linear[t[2]], t[3] / 255.0};
}

glm::dvec4 sampled(const Scene& scene, const Texture& texture, glm::dvec2 uv) {
    const TextureImage& image = scene.images[texture.image];
    const auto at = [&](double x, double y) {
        return texel(image, wrapped(x, image.width, texture.wrapU),
                     wrapped(y, image.height, texture.wrapV));
    };
    const glm::dvec2 size(image.width, image.height);
    if (texture.magnify == Filter::nearest) {
        const glm::dvec2 texel = glm::floor(uv * size);
        return at(texel.x, texel.y);
    }
    const glm::dvec2 position = uv * size - 0.5, corner = glm::floor(position),
                     fraction = position - corner;
    return glm::mix(
        glm::mix(at(corner.x, corner.y), at(corner.x + 1.0, corner.y), fraction.x),
        glm::mix(at(corner.x, corner.y + 1.0), at(corner.x + 1.0, corner.y + 1.0), fraction.x),
        fraction.y);
}

// Linear values at the interpolated texture coordinates (v = 0 is the first row), bilinear; white
// for an empty slot. There are no mipmaps: the samples of a pixel average the texture.
glm::dvec4 textureAt(const Scene& scene, const TextureSlot& slot, const Vertex& a, const Vertex& b,
                     const Vertex& c, double weightB, double weightC) {
    if (!slot.present()) return glm::dvec4(1.0);
    const bool second = slot.texCoord == 1;
    const glm::dvec2 ua(second ? a.texCoord1 : a.texCoord0), ub(second ? b.texCoord1 : b.texCoord0),
        uc(second ? c.texCoord1 : c.texCoord0);
    const glm::dvec2 uv = ua * (1.0 - weightB - weightC) + ub * weightB + uc * weightC;
    // KHR_texture_transform: scale, rotate, translate. v points down, hence the signs of the
    // rotation.
    const glm::dvec2 scaled = uv * glm::dvec2(slot.scale);
    const double cosine = std::cos(slot.rotation), sine = std::sin(slot.rotation);
    const glm::dvec2 rotated(cosine * scaled.x + sine * scaled.y,
                             cosine * scaled.y - sine * scaled.x);
    return sampled(scene, scene.textures[slot.texture], rotated + glm::dvec2(slot.offset));
}

// The tangent-space normal of a normal map's texel; not normalised.
glm::dvec3 tangentSpaceNormal(const Scene& scene, const TextureSlot& slot,
                              const glm::dvec4& texel) {
    const glm::dvec4 value = texel * 2.0 - 1.0;
    if (!scene.images[scene.textures[slot.texture].image].packedNormal) return glm::dvec3(value);
    const double x = value.r, y = value.a;
    return {x, y, std::sqrt(std::max(1.0 - x * x - y * y, 0.0))};
}

}  // namespace

SceneGeometry::SceneGeometry(const Scene& scene, const Pose& pose,
                             const MaterialBindings& materials, const Effects& effects)
    : scene_(scene),
      pose_(pose),
      materials_(materials),
      emission_(effects.emission),
      refraction_(effects.refraction),
      layers_(effects.materialLayers),
      surfaces_(surfacesOf(scene, materials)) {
    for (const TextureImage& image : scene.images) {
        if (image.texels.size() < std::size_t{4} * image.width * image.height) {
            throw std::invalid_argument("the scene's images have no texels");
        }
    }
    origin_ = centreOf(scene, pose, diagonal_);
    for (const Instance& instance : scene.instances) {
        InstanceTransform t{.worldFromMesh = pose.worldFromNode[instance.node]};
        t.worldFromMesh[3] -= glm::dvec4(origin_, 0.0);
        const glm::dmat3 linear(t.worldFromMesh);
        const double determinant = glm::determinant(linear);
        t.orientation = determinant < 0.0 ? -1.0 : 1.0;
        t.normalFromMesh = t.orientation * cofactors(linear);
        t.scale = std::cbrt(std::abs(determinant));
        transforms_.push_back(t);
    }
    for (const FlatMirror& mirror : clerestory::flatMirrors(scene, pose, materials, surfaces_)) {
        flatMirrors_.push_back(mirror.relativeTo(origin_));
    }
    collectTriangles();
    bvh_.emplace(
        triangles_.size(),
        [this](std::uint32_t i) -> EmbreeBvh::Corners {
            return {triangles_[i].a, triangles_[i].b, triangles_[i].c};
        },
        [this](std::uint32_t triangle, double weightB, double weightC, bool counterClockwise) {
            return acceptsHit(triangle, weightB, weightC, counterClockwise);
        });
}

void SceneGeometry::collectTriangles() {
    for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
        const Instance& instance = scene_.instances[surfaces_[s].instance];
        if (scene_.meshes[instance.mesh].primitive != Primitive::triangles) continue;
        if (!refraction_) surfaces_[s].glass = Glass::none;
        const Material& material = materialOf(surfaces_[s]);
        hasTransparency_ |=
            surfaces_[s].glass != Glass::none || material.alphaMode == AlphaMode::blend;
        addSurface(s);
    }
}

void SceneGeometry::addSurface(std::uint32_t s) {
    const Surface& surface = surfaces_[s];
    const InstanceTransform& transform = transforms_[surface.instance];
    const Material& material = materialOf(surface);
    // Rays leave a solid through back faces.
    const bool bothSides = material.doubleSided || surface.glass == Glass::solid;
    const MeshVertices vertices = verticesIn(surface);
    for (std::uint32_t k = 0; k < surface.clusterCount; ++k) {
        const Cluster& cluster = scene_.clusters[surface.firstCluster + k];
        for (std::uint32_t j = 0; j + 2 < cluster.indexCount; j += 3) {
            Triangle t{.firstIndex = cluster.firstIndex + j,
                       .surface = s,
                       .side = bothSides ? 0 : static_cast<std::int32_t>(transform.orientation)};
            bool inRange = true;
            for (int corner = 0; corner < 3; ++corner) {
                const Vertex& v = vertices[scene_.indices[t.firstIndex + corner]];
                const glm::dvec3 p(transform.worldFromMesh * glm::dvec4(v.position, 1.0));
                inRange = inRange && withinRange(p);
                (corner == 0 ? t.a : corner == 1 ? t.b : t.c) = glm::vec3(p);
            }
            const glm::dvec3 normal =
                glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a));
            if (inRange && glm::dot(normal, normal) > 0.0) triangles_.push_back(t);
        }
    }
}

bool SceneGeometry::acceptsHit(std::uint32_t triangle, double weightB, double weightC,
                               bool counterClockwise) const {
    const Triangle& t = triangles_[triangle];
    if (t.side != 0 && counterClockwise != (t.side > 0)) return false;
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

SurfaceInteraction SceneGeometry::interactionAt(const Hit& hit, const glm::dvec3& direction) const {
    const Triangle& t = triangles_[hit.triangle];
    const double wb = hit.weightB, wc = hit.weightC, wa = 1.0 - wb - wc;
    const MeshVertices vertices = verticesIn(surfaces_[t.surface]);
    const Vertex& a = vertices[scene_.indices[t.firstIndex]];
    const Vertex& b = vertices[scene_.indices[t.firstIndex + 1]];
    const Vertex& c = vertices[scene_.indices[t.firstIndex + 2]];

    SurfaceInteraction p{.triangle = hit.triangle, .surface = &surfaces_[t.surface]};
    p.instance = p.surface->instance;
    p.material = &materialOf(*p.surface);
    const Material& m = *p.material;
    const InstanceTransform& transform = transforms_[p.instance];
    const auto interpolate = [&](const auto& va, const auto& vb, const auto& vc) {
        return va * wa + vb * wb + vc * wc;
    };
    const glm::dvec3 cornerA(t.a), cornerB(t.b), cornerC(t.c);
    p.position = interpolate(cornerA, cornerB, cornerC);
    const glm::dvec3 maxCorner =
        glm::max(glm::abs(cornerA), glm::max(glm::abs(cornerB), glm::abs(cornerC)));
    p.maxCoordinate = greatest(maxCorner);
    const glm::dvec3 face = unitOr(glm::cross(cornerB - cornerA, cornerC - cornerA), -direction);
    const bool counterClockwise = glm::dot(face, direction) < 0.0;
    p.geometricNormal = counterClockwise ? face : -face;
    p.front = counterClockwise == (transform.orientation > 0.0);

    const auto slot = [&](const TextureSlot& s) { return textureAt(scene_, s, a, b, c, wb, wc); };
    const glm::dvec4 base =
        glm::dvec4(m.baseColor) *
        interpolate(glm::dvec4(a.color), glm::dvec4(b.color), glm::dvec4(c.color)) *
        slot(m.baseColorTexture);
    p.baseColor = glm::max(glm::dvec3(base), 0.0);
    if (m.alphaMode == AlphaMode::blend) p.coverage = std::clamp(base.w, 0.0, 1.0);
    if (m.unlit) return p;

    const glm::dvec4 surface = slot(m.metallicRoughnessTexture);
    p.metallic = std::clamp(m.metallic * surface.b, 0.0, 1.0);
    p.roughness = std::clamp(m.roughness * surface.g, 0.0, 1.0);
    p.occlusion = 1.0 + m.occlusionStrength * (slot(m.occlusionTexture).r - 1.0);
    if (emission_)
        p.emission = glm::dvec3(emittedRadiance(m)) * glm::dvec3(slot(m.emissiveTexture));
    if (p.surface->glass != Glass::none) {
        p.transmission = std::clamp(m.transmission * slot(m.transmissionTexture).r, 0.0, 1.0);
        p.thickness = m.thickness * slot(m.thicknessTexture).g * transform.scale;
    }

    const auto normalOf = [&](const Vertex& v) {
        return unitOr(transform.normalFromMesh * glm::dvec3(v.normal), p.geometricNormal);
    };
    glm::dvec3 n = interpolate(normalOf(a), normalOf(b), normalOf(c));
    const auto tangentOf = [&](const Vertex& v) {
        const glm::dvec3 tangent(v.tangent);
        return unitOr(glm::dmat3(transform.worldFromMesh) * tangent, glm::dvec3(0.0));
    };
    const glm::dvec3 tangent = interpolate(tangentOf(a), tangentOf(b), tangentOf(c));
    const glm::dvec3 bitangent = glm::cross(n, tangent) * (a.tangent.w * transform.orientation);
    const auto withMap = [&](const TextureSlot& normals, double scale) {
        glm::dvec3 bumpy = n;
        if (normals.present() && scale != 0.0) {
            const glm::dvec3 mapped = tangentSpaceNormal(scene_, normals, slot(normals));
            bumpy = tangent * (mapped.x * scale) + bitangent * (mapped.y * scale) + n * mapped.z;
        }
        bumpy = unitOr(p.front ? bumpy : -bumpy, p.geometricNormal);
        // A shading normal that faces away from the ray is moved to the horizon.
        constexpr double kHorizon = 1e-4;
        const double cosine = -glm::dot(bumpy, direction);
        return cosine < kHorizon
                   ? unitOr(bumpy - direction * (kHorizon - cosine), p.geometricNormal)
                   : bumpy;
    };
    p.normal = withMap(m.normalTexture, m.normalScale);
    p.ior = m.ior;
    p.specular = m.specular;
    p.specularColor = m.specularColor;
    if (!layers_) return p;

    p.specular *= slot(m.specularTexture).a;
    p.specularColor *= glm::dvec3(slot(m.specularColorTexture));
    SurfaceInteraction::Layers& layers = p.layers;
    layers.clearcoat = m.clearcoat * slot(m.clearcoatTexture).r;
    layers.clearcoatRoughness = m.clearcoatRoughness * slot(m.clearcoatRoughnessTexture).g;
    layers.clearcoatNormal = withMap(m.clearcoatNormalTexture, m.clearcoatNormalScale);
    layers.sheen = glm::dvec3(m.sheenColor) * glm::dvec3(slot(m.sheenColorTexture));
    layers.sheenRoughness = m.sheenRoughness * slot(m.sheenRoughnessTexture).a;
    layers.film = m.iridescence * slot(m.iridescenceTexture).r;
    layers.filmIor = m.iridescenceIor;
    layers.filmThickness =
        std::lerp(double(m.iridescenceThicknessMin), double(m.iridescenceThickness),
                  slot(m.iridescenceThicknessTexture).g);
    layers.throughShare = m.diffuseTransmission * slot(m.diffuseTransmissionTexture).a;
    layers.through = glm::dvec3(m.diffuseTransmissionColor) *
                     glm::dvec3(slot(m.diffuseTransmissionColorTexture));
    if (m.anisotropy > 0.0f) {
        const glm::dvec4 texel = slot(m.anisotropyTexture);
        const bool turned = m.anisotropyTexture.present();
        const glm::dvec2 along = turned ? 2.0 * glm::dvec2(texel) - 1.0 : glm::dvec2(1.0, 0.0);
        const double cosine = std::cos(m.anisotropyRotation);
        const double sine = std::sin(m.anisotropyRotation);
        const glm::dvec3 grain = tangent * (cosine * along.x - sine * along.y) +
                                 bitangent * (sine * along.x + cosine * along.y);
        layers.anisotropy = m.anisotropy * texel.b;
        layers.grain = unitOr(grain - p.normal * glm::dot(grain, p.normal), Frame(p.normal).x);
    }
    return p;
}

double SceneGeometry::normalSpreadAcross(const Hit& hit, const SurfaceInteraction& point,
                                         const glm::dvec3& direction, double width) const {
    constexpr double kMinCosine = 0.1;
    const Triangle& t = triangles_[hit.triangle];
    const glm::dvec3 b = glm::dvec3(t.b) - glm::dvec3(t.a), c = glm::dvec3(t.c) - glm::dvec3(t.a);
    const glm::dvec3 normal = glm::cross(b, c);
    const double squared = glm::dot(normal, normal);
    const glm::dvec3 across =
        unitOr(glm::cross(point.geometricNormal, direction), Frame(point.geometricNormal).x);
    const double stretch =
        std::max(std::abs(glm::dot(point.geometricNormal, direction)), kMinCosine);
    const auto normalChange = [&](const glm::dvec3& offset) {
        Hit shifted = hit;
        shifted.weightB += glm::dot(glm::cross(offset, c), normal) / squared;
        shifted.weightC += glm::dot(glm::cross(b, offset), normal) / squared;
        return interactionAt(shifted, direction).normal - point.normal;
    };
    const glm::dvec3 one = normalChange(across * width);
    const glm::dvec3 other =
        normalChange(glm::cross(point.geometricNormal, across) * (width / stretch));
    return std::sqrt(glm::length(glm::cross(one, other)));
}

namespace {

// The point, moved off its surface towards `direction`. reach: greatest coordinate.
glm::dvec3 offsetPosition(const SurfaceInteraction& point, const glm::dvec3& direction,
                          double reach) {
    // The position is exact in double. Corners and Embree's ray are rounded to 2^-24 of the
    // greatest coordinate, and Embree's arithmetic adds errors of that size.
    const double offset = 1e-6 * reach + 1e-30;
    const bool isOutside = glm::dot(direction, point.geometricNormal) >= 0.0;
    return point.position + point.geometricNormal * (isOutside ? offset : -offset);
}

}  // namespace

Ray SceneGeometry::spawnRay(const SurfaceInteraction& point, const glm::dvec3& direction) {
    return {.origin = offsetPosition(point, direction, point.maxCoordinate),
            .direction = direction,
            .originTriangle = point.triangle};
}

Ray SceneGeometry::spawnRayTo(const SurfaceInteraction& point, const SurfaceInteraction& end) {
    const glm::dvec3 way = end.position - point.position;
    Ray ray = spawnRay(point, way);
    const double reach = std::max(point.maxCoordinate, end.maxCoordinate);
    const glm::dvec3 rest = offsetPosition(end, -way, reach) - ray.origin;
    ray.tMax = glm::length(rest);
    ray.direction = unitOr(rest, unitOr(way, point.geometricNormal));
    return ray;
}

}  // namespace clerestory::reference
